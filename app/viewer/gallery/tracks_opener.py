"""Tracks of a file: of one of this machine, or of one from a browser, read in a process aside."""

from __future__ import annotations

import re
from dataclasses import dataclass

from agents.recordings.recorder import KEY
from app.tracks.tracks import Tracks
from app.viewer.editing.layout_file import plain_name
from app.viewer.run.stored_flock import PARQUET

BINARY = (b"\x89HDF", b"SQLite format 3", b"\x93NUMPY")
"""How files of tracks begin that are no text: HDF5, SQLite and NumPy."""
C3D = b"\x50"
ZIP = b"PK\x03\x04"
FOOTER = 1 << 20
"""Bytes in which the metadata of a Parquet file stands, and the first names of an archive."""
HEAD = 2000
TOML_LINE = re.compile(r"\s*(\[|[\w.\"'-]+\s*=)")
"""The first line of a scene or a spec."""


@dataclass(frozen=True)
class TracksFields:
    """What somebody says of a file of tracks that it does not say itself; None: it says it."""

    rate: float | None = None
    """Frames per second."""
    unit: str | None = None
    scale: float | None = None
    """Metres in a pixel."""
    origin: str | None = None


def are_tracks(name: str, content: bytes) -> bool:
    """Whether a file from a browser may be tracks, by how it begins: it is none of our files.

    >>> are_tracks("a.csv", b"frame,id,x,y\\n"), are_tracks("run.toml", b"[run]\\nmodel = 'vem'\\n")
    (True, False)
    """
    if name.lower().endswith(".toml"):
        return False
    if content.startswith(PARQUET):
        return KEY not in content[-FOOTER:]
    if content.startswith(ZIP):
        return b".npy" in content[:FOOTER]  # an archive of arrays; those of ours hold files
    if content.startswith(BINARY):
        return True
    head = content[:HEAD]
    if any(byte < 9 for byte in head):
        return content[1:2] == C3D
    lines = head.decode("utf-8-sig", "replace").splitlines()
    first = next((line for line in lines if line.strip() and not line.startswith("#")), "")
    return TOML_LINE.match(first) is None


def open_tracks(name: str, content: bytes, fields: TracksFields) -> Tracks:
    """The tracks in the bytes of a file from a browser. Raises InputError."""
    from app.tracks.readers.track_reader import ReadingOptions
    from app.tracks.uploaded_tracks import read_uploaded

    options = ReadingOptions(
        rate=fields.rate, unit=fields.unit, scale=fields.scale, origin=fields.origin
    )
    return read_uploaded(plain_name(name), content, options)
