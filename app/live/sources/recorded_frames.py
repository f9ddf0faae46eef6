"""What a recording holds: frames, each with what was tracked then."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from app.live.control.plausibility import BodyTrack
from app.live.control.pose import Sighting


@dataclass(frozen=True, slots=True)
class RecordedFrame:
    """One frame as it was recorded; played, it becomes a `MocapFrame`."""

    time: float
    """Seconds by the clock of the recording."""
    number: int
    """Of the frame, as recorded."""
    sightings: tuple[Sighting, ...]
    up: Mapping[str, tuple[float, float, float]] = field(default_factory=dict, compare=False)
    """The room's up in the axes of the bodies whose orientation is told, also of those that lie."""


def tracks_of(frames: Iterable[RecordedFrame]) -> list[BodyTrack]:
    """The track of every body that is tracked, or whose orientation is told, by name."""
    numbers: dict[str, list[int]] = {}
    rows: dict[str, list[tuple[float, float, float, float]]] = {}
    ups: dict[str, list[tuple[float, float, float]]] = {}
    for frame in frames:
        for name, up in frame.up.items():
            ups.setdefault(name, []).append(up)
        for sighting in frame.sightings:
            pose = sighting.pose
            if sighting.valid and pose is not None:
                numbers.setdefault(sighting.name, []).append(frame.number)
                rows.setdefault(sighting.name, []).append((frame.time, pose.x, pose.y, pose.yaw))
    tracks = []
    for name in sorted({*numbers, *ups}):
        time, x, y, yaw = np.array(rows.get(name, []), float).reshape(-1, 4).T
        tracks.append(
            BodyTrack(
                name,
                np.array(numbers.get(name, []), int),
                time,
                np.column_stack([x, y]),
                yaw,
                np.array(ups.get(name, []), float).reshape(-1, 3),
            )
        )
    return tracks
