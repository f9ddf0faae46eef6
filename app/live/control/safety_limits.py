"""Limits that nothing sent to a car may exceed, and when the cars are stopped."""

from __future__ import annotations

from pydantic import Field, model_validator

from app.live.links.firmware import WATCHDOG
from app.strict_table import StrictTable


class SafetyLimits(StrictTable):
    """When all cars stop. Defaults are those of the source; lengths in metres, times in s."""

    stale: float = Field(default=0.1, ge=0.02, le=WATCHDOG)
    """A car unseen for longer than this stops all; they run on once it is seen again."""
    long_gap: float = Field(default=1.0, ge=0.25, le=10.0)
    """A stop of this kind, or a standstill of the loop, that lasts longer takes the arming away."""
    frozen: float = Field(default=0.35, ge=0.2, le=2.0)
    """Time within which a car is detected that does not move as commanded."""
    leap: float = Field(default=0.25, ge=0.02, le=5.0)
    """A pose further than this beyond what the car can have driven is rejected."""
    unattended: float = Field(default=2.0, ge=0.5, le=60.0)
    """An operator that has been silent for longer, s, takes the arming away: it could not stop."""

    @model_validator(mode="after")
    def _are_in_order(self) -> SafetyLimits:
        if self.long_gap <= self.stale:
            raise ValueError("long_gap must be longer than stale")
        return self


class CarLimits(StrictTable):
    """Limits of a car and of its commands, which are shares of full lock and full throttle."""

    steer: float = Field(default=1.0, gt=0.0, le=1.0)
    """Most steering to either side; 1 is full lock."""
    throttle: float = Field(default=1.0, gt=0.0, le=1.0)
    """Most throttle forwards."""
    reverse: float = Field(default=0.0, ge=0.0, le=1.0)
    """Most throttle backwards; 0: it never reverses."""
    steering_rate: float = Field(default=8.0, gt=0.0, le=100.0)
    """Most change of steering per second; a servo of 7 rad/s with a lock of 45 deg does 8.9."""
    speed: float = Field(default=1.0, gt=0.0, le=10.0)
    """Speed at throttle 1, m/s."""
    lag: float = Field(default=0.15, ge=0.0, le=2.0)
    """Time constant of the motor, s."""
    rests: float = Field(default=0.1, ge=0.0, lt=1.0)
    """Throttle up to which it may stay where it is."""

    @property
    def fastest(self) -> float:
        """The highest speed that it can be commanded, m/s."""
        return self.speed * max(self.throttle, self.reverse)

    def runs_on(self, limits: SafetyLimits) -> float:
        """How far (m) it may still go if the worst fault begins at full speed.

        The worst is the slower of a frozen stream, found after `frozen`, and a link cut, found by
        its own watchdog; then it rolls out with the motor's lag.
        """
        return self.fastest * (max(limits.frozen, WATCHDOG) + self.lag)
