"""What the control loop reports of itself at a tick, for the viewer and the terminal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from app.live.control.arm import State
from app.live.control.driver import Companion
from app.live.control.loop_durations import DurationSummary
from app.live.control.pose import Pose
from app.live.control.safety import Command, Safety, SafetyDecision, StopReason
from app.live.links.link import RUN

LATE = 0.03
"""Seconds since it was last seen after which a car is late: three frames at 100 Hz."""
Tracking = Literal["tracked", "late", "lost"]


@dataclass(frozen=True)
class CarStatus:
    """One car at a tick."""

    name: str
    pose: Pose | None
    """Where it was last seen."""
    age: float
    """Seconds since then; infinite if it never was."""
    tracking: Tracking
    runs: bool
    """Whether the command sent to it was to run."""
    sent: Command

    @property
    def state(self) -> str:
        """tracked, late, lost or stopped; lost before stopped before late."""
        if self.tracking == "lost":
            return "lost"
        return self.tracking if self.runs else "stopped"


@dataclass(frozen=True)
class Status:
    """The control loop and its cars at one tick."""

    tick: int
    time: float
    """`time.monotonic()` of the machine that runs the loop, s."""
    arm: State
    mode: int
    reasons: tuple[StopReason, ...]
    """Why the cars do not run, or could not be armed."""
    cars: tuple[CarStatus, ...]
    injected: Pose | None
    companions: tuple[Companion, ...]
    """The simulated cars beside them."""
    period: DurationSummary
    """Seconds from tick to tick."""
    latency: DurationSummary
    """Seconds from the arrival of a frame to the commands that it leads to."""
    missed: int
    """Ticks left out because their deadline had passed, in all."""
    dropped: int
    """Frames that the link did not send, in all."""
    troubles: dict[str, str]
    """What is wrong with the source, the link and the recording, by these names."""
    events: int
    """Number of events so far."""


def cars_of(safety: Safety, verdict: SafetyDecision, now: float) -> tuple[CarStatus, ...]:
    """The status of each car at `now` (s)."""
    return tuple(
        CarStatus(
            name,
            safety.seen.last[name].pose if name in safety.seen.last else None,
            safety.seen.age(name, now),
            tracking(safety.seen.age(name, now), safety.limits.stale),
            verdict.mode == RUN,
            verdict.commands[name],
        )
        for name in safety.cars
    )


def tracking(age: float, stale: float) -> Tracking:
    """Whether a car is tracked, late or lost, by the age (s) of its last pose.

    >>> tracking(0.02, stale=0.1), tracking(0.09, stale=0.1), tracking(0.11, stale=0.1)
    ('tracked', 'late', 'lost')
    """
    if age > stale:
        return "lost"
    return "late" if age > LATE else "tracked"
