"""Tracks of real animals, people and robots: read from what common trackers write.

>>> from flockscope.tracks import Tracks, read
>>> read("no-such-file.csv")
Traceback (most recent call last):
    ...
worlds.input_error.InputError: no-such-file.csv cannot be read: No such file or directory
"""

from __future__ import annotations

from flockscope import _in_the_way  # noqa: F401 - it looks before the rest is imported

# isort: split
from app.tracks.read_tracks import read
from app.tracks.readers.track_reader import FileTracks, ReadingOptions, TrackReader
from app.tracks.tracks import DroppedRows, Tracks
from worlds.input_error import InputError

__all__ = [
    "DroppedRows",
    "FileTracks",
    "InputError",
    "ReadingOptions",
    "TrackReader",
    "Tracks",
    "read",
]
