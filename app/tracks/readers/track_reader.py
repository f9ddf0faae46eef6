"""What a reader of tracks is: a declaration, what it is told, and what it gives."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from app.tracks.readers.file_beginning import FileBeginning
from app.tracks.tracks import PIXELS, UNITS, DroppedRows
from worlds.input_error import InputError, shorten, unknown

TOP_LEFT = "top-left"
"""y points down, as in the pictures of a camera."""
BOTTOM_LEFT = "bottom-left"
"""y points up, as on paper."""
ORIGINS = (TOP_LEFT, BOTTOM_LEFT)
UPS = ("z", "y")
COLUMNS = ("frame", "time", "id", "x", "y", "z", "angle", "confidence")
"""What the columns of a plain table may hold."""


@dataclass(frozen=True)
class ReadingOptions:
    """What a user says of a file that it does not say itself, and what to take of it.

    Raises InputError for values that are none.
    """

    rate: float | None = None
    """Frames per second; of a file of times alone, how many it is put into."""
    unit: str | None = None
    """Of the numbers of the file: one of UNITS, or px."""
    origin: str | None = None
    """One of ORIGINS."""
    scale: float | None = None
    """Metres in a pixel."""
    up: str | None = None
    """The axis that points up, of places in space: one of UPS."""
    node: str | None = None
    """Which part of the body."""
    least_confidence: float | None = None
    """Places of which the tracker is less sure are left out; None: 0.6 where a tracker never
    leaves a place blank, else nothing is."""
    columns: Mapping[str, str] = field(default_factory=dict)
    """Of a plain table: what a column holds, one of COLUMNS -> its name."""
    frames: tuple[int, int] | None = None
    """The first frame that is read, and the one after the last, by their numbers."""
    every: int = 1
    """Only each so-many-th frame is read."""
    fill: int = 0
    """Gaps of at most so many frames are filled with a straight line."""
    flat: bool = False
    """Whether the height of places in space is left out."""

    def __post_init__(self) -> None:
        for name in ("rate", "scale"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < math.inf:
                raise InputError(f"--{name} {value:g} is not allowed: a number > 0 is needed")
        if self.unit is not None and self.unit not in (*UNITS, PIXELS):
            raise unknown("unit", self.unit, (*UNITS, PIXELS), "--unit")
        if self.origin is not None and self.origin not in ORIGINS:
            raise unknown("origin", self.origin, ORIGINS, "--origin")
        if self.up is not None and self.up not in UPS:
            raise unknown("axis", self.up, UPS, "--up")
        if self.least_confidence is not None and not 0.0 <= self.least_confidence <= 1.0:
            raise InputError(f"--least-confidence {self.least_confidence:g} is outside [0, 1]")
        if self.every < 1:
            raise InputError(f"--every {self.every} is not allowed: a whole number >= 1 is needed")
        if self.fill < 0:
            raise InputError(f"--fill {self.fill} is not allowed: a whole number >= 0 is needed")
        if self.frames is not None and not self.frames[0] < self.frames[1]:
            first, end = self.frames
            raise InputError(f"--frames {first}:{end} is not allowed: it holds no frame")
        for held in self.columns:
            if held not in COLUMNS:
                raise unknown("content of a column", held, COLUMNS, "--column")


@dataclass
class FileTracks:
    """What a file says, before anything that its user adds.

    Places stand in a table (T, N, dim), with frame (T,) and the ids (N,), or in rows (R, dim), in
    any order, with frame (R,) and ids (R,). Without frames, times (R,) or (T,) in s tell them.
    """

    position: np.ndarray
    ids: Sequence[object] | np.ndarray
    frame: np.ndarray | None = None
    time: np.ndarray | None = None
    """s; that of a row, or of a line of the table."""
    rate: float | None = None
    """Frames per second, if the file says it."""
    unit: str = ""
    """Of the places, if the file or its format says it."""
    origin: str = ""
    """One of ORIGINS, if the format says it; of places in space it does not matter."""
    up: str = ""
    """One of UPS, of places in space, if the format says it."""
    heading: np.ndarray | None = None
    """(..., dim), in the axes of the file; NaN or 0 where there is none."""
    confidence: np.ndarray | None = None
    filled: np.ndarray | None = None
    least_confidence: float = 0.0
    """What `ReadingOptions.least_confidence` is if it is not given."""
    period: tuple[float, ...] = ()
    boundary: str = ""
    dropped: list[DroppedRows] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    @property
    def is_table(self) -> bool:
        """Whether places stand in a table."""
        return self.position.ndim == 3

    def drop(self, rows: int | np.integer, reason: str) -> None:
        """Count rows that are left out."""
        if rows:
            self.dropped.append(DroppedRows(int(rows), reason))


@dataclass(frozen=True)
class TrackReader:
    """A format of tracks: how it is told by what a file holds, and read."""

    name: str
    """In lists and for --format, lower case."""
    title: str
    """For people, e.g. "idtracker.ai NumPy"."""
    extensions: tuple[str, ...]
    """How its files usually end, for lists; files are told by what they hold."""
    recognises: Callable[[FileBeginning], bool]
    """Whether a file is one of these, from its beginning."""
    read: Callable[[Sequence[Path], ReadingOptions], FileTracks]
    """Reads the files, of which there is one unless `takes_several`. Raises InputError."""
    needs: tuple[str, ...] = ()
    """The options without which such files cannot be read, e.g. ("--rate",)."""
    takes_several: bool = False
    """Whether several files, such as one for each animal, make one table."""

    def __post_init__(self) -> None:
        if not self.name or self.name != self.name.lower() or " " in self.name:
            raise InputError(f"a reader's name is a word in lower case, not {shorten(self.name)}")
