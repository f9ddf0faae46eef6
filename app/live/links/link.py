"""What every car link is: it takes commands for all cars and never waits."""

from __future__ import annotations

from typing import Final, Protocol

STOP: Final = 0
"""Mode: throttle 0; clears a latched emergency stop in the cars."""
RUN: Final = 1
"""Mode: drive as told."""
EMERGENCY: Final = 2
"""Mode: throttle 0, latched in the cars until a frame says STOP."""
MODES: Final = (STOP, RUN, EMERGENCY)


class LinkLost(OSError):
    """A link that was open carries nothing any more; its text is the one line to show."""


class CarLink(Protocol):
    """Carries commands to cars. Written by one thread; nothing in it may block."""

    name: str
    """The text that it was opened with."""
    dropped: int = 0
    """Frames that were not sent, because the one before was still on its way."""

    def send(self, seq: int, mode: int, commands: dict[int, tuple[float, float]]) -> None:
        """Send one frame to all cars.

        `seq` counts up by one from frame to frame; `mode` is STOP, RUN or EMERGENCY; `commands`
        has (steer, throttle), both in [-1, 1], by the address of the car; steering to the left
        and driving forwards are positive. Unless the mode is RUN, the throttle goes out as 0.

        Raises InputError for what no car may be told, LinkLost if the other end is gone.
        """
        ...

    def occupies(self, cars: int) -> float:
        """Time that a frame to so many cars keeps the link busy, s; 0 if that is no matter."""
        return 0.0 * cars

    def close(self) -> None:
        """Let go of the port. What has been sent still goes out; nothing is raised."""
        ...


def shortage(link: CarLink, cars: int, rate: float = 100.0) -> str:
    """Why a link cannot carry `rate` frames per second to so many cars, "" if it can.

    A link that is too slow drops the frames that it has no time for, so that commands are never
    late by more than a frame, but fewer of them arrive.
    """
    busy = link.occupies(cars)
    if busy * rate <= 1.0:
        return ""
    return (
        f"{link.name} is busy for {1000.0 * busy:.1f} ms with every frame to {cars} cars, but one "
        f"is due every {1000.0 / rate:.1f} ms: about {1.0 / busy:.0f} of {rate:g} frames per "
        "second get through"
    )
