"""What a recording holds: frames, each with what was tracked then."""

from __future__ import annotations

from dataclasses import dataclass

from app.live.control.pose import Sighting


@dataclass(frozen=True, slots=True)
class RecordedFrame:
    """One frame as it was recorded; played, it becomes a `MocapFrame`."""

    time: float
    """Seconds by the clock of the recording."""
    number: int
    """Of the frame, as recorded."""
    sightings: tuple[Sighting, ...]
