"""Tracks of a file: of one of this machine, or of one from a browser, read in a process aside."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from app.tracks.tracks import Tracks
from app.viewer.editing.layout_file import plain_name


@dataclass(frozen=True)
class TracksFields:
    """What somebody says of a file of tracks that it does not say itself; None: it says it."""

    rate: float | None = None
    """Frames per second."""
    unit: str | None = None
    scale: float | None = None
    """Metres in a pixel."""
    origin: str | None = None


def open_tracks(name: str, content: bytes, fields: TracksFields) -> Tracks:
    """The tracks in the bytes of a file from a browser. Raises InputError."""
    from app.tracks.readers.track_reader import ReadingOptions
    from app.tracks.uploaded_tracks import read_uploaded

    options = ReadingOptions(
        rate=fields.rate, unit=fields.unit, scale=fields.scale, origin=fields.origin
    )
    return read_uploaded(plain_name(name), content, options)


def tracks_at(path: Path) -> Tracks:
    """The tracks of a file of this machine, which says all itself. Raises InputError."""
    from app.tracks.read_tracks import read

    return read(path)
