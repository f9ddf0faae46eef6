"""What drives the cars: the contract between the control loop and a rule."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from app.live.control.pose import Pose, Sighting
from worlds.input_error import InputError


class NoFreeSpace(InputError):
    """No free space for the simulated cars; raised once for each time that they are asked for."""


@dataclass(frozen=True, slots=True)
class Companion:
    """A simulated car in the world of the real ones."""

    name: str
    """`sim 1`, `sim 2`, ..."""
    pose: Pose
    steer: float
    """Angle of its front wheels as a share of full lock, in [-1, 1]; left is positive."""


class Driver(Protocol):
    """Computes commands from the poses; called once a tick, by one thread.

    What it answers may depend on nothing but what it was made of and what it has been called with,
    in order: no clock, no chance without a seed. Then a recording replays to the bit. It must be
    done within a few milliseconds.
    """

    def drive(
        self, now: float, sightings: tuple[Sighting, ...], injected: Pose | None, running: bool
    ) -> Mapping[str, tuple[float, float]]:
        """(steer, throttle) in [-1, 1] by car: left and forwards are positive.

        `now` is in seconds on the loop's clock. `sightings` has the cars, by the laboratory's
        names, that were seen within the limit `stale`, each where it was last seen; a car without
        a command gets no throttle. `injected` is the injected car, None where there is none.
        `running` says whether the cars were told to run in the last tick. Whatever it raises stops
        the cars; after NoFreeSpace they go on with the next tick, without new simulated cars.
        """
        ...


@runtime_checkable
class TunableDriver(Protocol):
    """A driver with parameters that can be changed while it drives."""

    def tune(self, values: Mapping[str, Any]) -> None:
        """Change parameters by name. Raises InputError, and then changes nothing."""
        ...


@runtime_checkable
class CompanionDriver(Protocol):
    """A driver with simulated cars beside the real ones, which drive while those run."""

    @property
    def companions(self) -> tuple[Companion, ...]:
        """The simulated cars as they are after the last tick."""
        ...

    def accompany(self, count: int) -> None:
        """Have so many simulated cars from now on: new ones begin where there is room, the last
        ones leave first. Raises InputError, and then changes nothing."""
        ...
