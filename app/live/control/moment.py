"""One tick of the control loop as it is recorded: what came in and what went out."""

from __future__ import annotations

from dataclasses import dataclass

from app.live.control.arm import State
from app.live.control.control import Step
from app.live.control.events import Event
from app.live.control.pose import MocapFrame, Pose


@dataclass(frozen=True)
class Moment:
    """A tick. With those before it, it holds all that its commands follow from."""

    tick: int
    now: float
    """`time.monotonic()` at its beginning, s; all that it decides, it decides for this time."""
    frames: tuple[MocapFrame, ...]
    """Those that had come since the last tick; the last of them is the one that counts."""
    injected: Pose | None
    step: Step
    arm: State
    events: tuple[Event, ...]
    latency: float | None
    """Seconds from the arrival of the newest frame to its commands; None without a new frame."""
