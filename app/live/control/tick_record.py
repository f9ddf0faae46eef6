"""One tick of the control loop as it is recorded: its inputs and its outputs."""

from __future__ import annotations

from dataclasses import dataclass

from app.live.control.arm import State
from app.live.control.car_control import ControlStep
from app.live.control.loop_events import Event
from app.live.control.pose import MocapFrame, Pose


@dataclass(frozen=True)
class TickRecord:
    """A tick. It and those before it hold all inputs that its commands depend on."""

    tick: int
    now: float
    """`time.monotonic()` at its beginning, s; the time for which its commands are computed."""
    frames: tuple[MocapFrame, ...]
    """Those that arrived since the last tick; the last of them is used."""
    injected: Pose | None
    step: ControlStep
    arm: State
    events: tuple[Event, ...]
    latency: float | None
    """Seconds from the arrival of the newest frame to its commands; None without a new frame."""
