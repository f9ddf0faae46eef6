"""What drives the cars: the contract between the control loop and a rule."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

from app.live.pose import Pose, Sighting


class Driver(Protocol):
    """Turns what is seen into commands; called once a tick, by one thread.

    What it answers may depend on nothing but what it was made of and what it has been called with,
    in order: no clock, no chance without a seed. Then a recording replays to the bit. It must be
    done within a few milliseconds.
    """

    def drive(
        self, now: float, sightings: tuple[Sighting, ...], injected: Pose | None
    ) -> Mapping[str, tuple[float, float]]:
        """(steer, throttle) in [-1, 1] by car: left and forwards are positive.

        `now` is in seconds on the loop's clock. `sightings` has the cars, by the laboratory's
        names, that were seen within the limit `stale`, each where it was last seen; a car without
        a command gets no throttle. `injected` is the injected car, None where there is none.
        Whatever it raises stops the cars.
        """
        ...


@runtime_checkable
class Tunable(Protocol):
    """A driver with parameters that can be changed while it drives."""

    def tune(self, values: Mapping[str, Any]) -> None:
        """Change parameters by name. Raises Refusal, and then changes nothing."""
        ...
