"""What a tracking source is: the contract for a new one."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from app.live.control.plausibility import BodyTrack
from app.live.control.pose import MocapFrame, Sighting


class Source(Protocol):
    """Gives frames until it is told to stop; a value that a child process can be handed.

    It must survive pickling: keep what was asked for (a host, a path), and open it in `frames`.
    """

    @property
    def name(self) -> str:
        """Its kind, e.g. "optitrack"."""
        ...

    @property
    def longest_gap(self) -> float:
        """Seconds without a frame after which its connection is taken for lost, and opened again;
        infinite where frames may lie as far apart as they like, as in a recording, and for a
        source that has no such attribute."""
        ...

    def frames(self, stop: threading.Event) -> Iterator[MocapFrame]:
        """Connect, then return what gives the frames as they come.

        It runs in a child process and may block: while it connects for the timeout of the
        `Feed`, between frames for ever. `received` is read from `time.monotonic()` as soon as a
        frame is there, and numbers rise. It ends when `stop` is set or when there is no more.

        Raises InputError, OSError or RuntimeError with one line for whoever started it.
        """
        ...

    def describe(self) -> str:
        """What it is in a few words, e.g. "optitrack at 192.168.1.5 (y up, m)"."""
        ...


# What a recording holds: frames, each with what was tracked then.


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
