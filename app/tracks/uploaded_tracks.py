"""Tracks of a file from a browser: read by a process of its own, handed over as plain arrays."""

from __future__ import annotations

import io
import json
import tempfile
import zipfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from app.sandboxed_reader import read_in_sandbox
from app.tracks.tracks import DroppedRows, Tracks
from worlds.input_error import InputError

READER = f"{__name__}:tracks_as_arrays"
"""The reader, for the process of its own."""
ARRAYS = ("position", "frame", "time", "heading", "confidence", "filled")
WORDS = ("ids", "unit", "name", "format", "period", "boundary", "notes")
SPLIT = b"\n"
"""Between what is said of the file and the file."""
MOST_BYTES = 1 << 30
"""Of all arrays together."""


def read_uploaded(name: str, content: bytes, options: Any) -> Tracks:
    """The tracks in the bytes of a file; options: a `ReadingOptions`. Raises InputError."""
    told = json.dumps(asdict(options)).encode()
    return unpacked(read_in_sandbox(READER, name, told + SPLIT + content))


def tracks_as_arrays(name: str, content: bytes) -> bytes:
    """In the process aside: the tracks of a file as arrays and words. Raises InputError."""
    from app.tracks.read_tracks import read_files
    from app.tracks.readers.track_reader import ReadingOptions

    told, _, data = content.partition(SPLIT)
    values = json.loads(told)
    if values.get("frames") is not None:
        values["frames"] = tuple(values["frames"])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / (Path(name).name or "tracks")
        path.write_bytes(data)
        tracks = read_files([path], ReadingOptions(**values))
    return packed(tracks)


def packed(tracks: Tracks) -> bytes:
    """Tracks as an archive of plain arrays, and words as JSON in one of them."""
    arrays = {name: getattr(tracks, name) for name in ARRAYS}
    words = {name: getattr(tracks, name) for name in WORDS}
    words["dropped"] = [asdict(one) for one in tracks.dropped]
    told = np.frombuffer(json.dumps(words).encode(), np.uint8)
    file = io.BytesIO()
    np.savez(file, words=told, **{name: one for name, one in arrays.items() if one is not None})
    return file.getvalue()


def unpacked(content: bytes) -> Tracks:
    """Tracks of such an archive, in which nothing is unpickled. Raises InputError."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as members:
            size = sum(member.file_size for member in members.infolist())
        if size > MOST_BYTES:
            raise InputError(f"the tracks hold {size >> 20} MiB: {MOST_BYTES >> 20} at most")
        with np.load(io.BytesIO(content), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in ARRAYS if name in archive}
            words = json.loads(archive["words"].tobytes())
        words["dropped"] = tuple(DroppedRows(**one) for one in words["dropped"])
        for name in ("ids", "period", "notes"):
            words[name] = tuple(words[name])
        return Tracks(**arrays, **words)
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"the tracks cannot be taken over: {type(error).__name__}") from None
