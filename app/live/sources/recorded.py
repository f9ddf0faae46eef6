"""A recording as a source: a C3D trial or a table of poses, played as it came or at any factor."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

from app.live.control.pose import MocapFrame
from app.live.sources.address import AXES, Address
from app.live.sources.axes import Axes
from app.live.sources.recording import RecordedFrame
from app.live.sources.table import read_table
from app.live.sources.trial import MarkedBody, read_trial
from worlds.refusal import Refusal, unknown

SUFFIXES = (".c3d", ".csv", ".parquet")


@dataclass(frozen=True)
class Recorded:
    """A recording that is played.

    Raises Refusal for a file of another kind or a factor that is none.
    """

    path: Path
    axes: Axes = field(default_factory=Axes)
    """How the recording system was set up; the unit of a C3D file is its own."""
    bodies: tuple[MarkedBody, ...] = ()
    """Of a C3D file: which markers make a body; empty: its rotations are the bodies."""
    factor: float = 1.0
    """How many times faster than it was recorded."""
    again: bool = False
    """Whether it begins anew after its end."""
    name: str = "recorded"

    def __post_init__(self) -> None:
        suffix = self.path.suffix.lower()
        if suffix not in SUFFIXES:
            raise unknown("kind of recording", suffix, SUFFIXES, str(self.path))
        if self.bodies and suffix != ".c3d":
            raise Refusal(f"{self.path} holds poses, not markers: it has no use for body=")
        if not 0.0 < self.factor < math.inf:
            raise Refusal(f"factor = {self.factor:g} is not a positive number")

    def describe(self) -> str:
        """What it is in a few words."""
        speed = "" if self.factor == 1.0 else f", {self.factor:g} times as fast"
        return f"{self.path.name}{speed}{', over and over' if self.again else ''}"

    def recording(self) -> list[RecordedFrame]:
        """All that it holds.

        Raises Refusal naming what is wrong with the file, and where.
        """
        if self.path.suffix.lower() == ".c3d":
            return read_trial(self.path, self.axes, self.bodies)
        return read_table(self.path, self.axes)

    def frames(self, stop: threading.Event) -> Iterator[MocapFrame]:
        """Read the file, then give its frames at their times; see `Source.frames`."""
        return self._played(self.recording(), stop)

    def _played(
        self, recording: list[RecordedFrame], stop: threading.Event
    ) -> Iterator[MocapFrame]:
        first, last = recording[0], recording[-1]
        step = (last.time - first.time) / max(1, len(recording) - 1)
        lasts = last.time - first.time + step
        holds = last.number - first.number + 1
        began = time.monotonic()
        for round_ in count() if self.again else range(1):
            for frame in recording:
                elapsed = round_ * lasts + frame.time - first.time
                if stop.wait(max(0.0, began + elapsed / self.factor - time.monotonic())):
                    return
                yield MocapFrame(
                    frame.number + round_ * holds,
                    time.monotonic(),
                    frame.sightings,
                    first.time + elapsed,
                )


def opened(address: Address) -> Recorded:
    """The recording that an address names, once the whole of it is found readable."""
    address.known((*AXES, "factor", "again"), several=("body",))
    try:
        recorded = Recorded(
            Path(address.place).expanduser(),
            address.axes(),
            tuple(_marked(word) for word in address.words("body")),
            address.number("factor", 1.0, 0.001, 1000.0),
            address.truth("again", False),
        )
    except Refusal as refused:
        said = str(refused)
        raise Refusal(said if address.text in said else f"{said} ({address.text})") from None
    recorded.recording()
    return recorded


def _marked(word: str) -> MarkedBody:
    parts = [part.strip() for part in word.split(",")]
    if len(parts) != 3 or not all(parts):
        raise Refusal(f"body = {word} is not of the form NAME,REAR,FRONT")
    return MarkedBody(*parts)
