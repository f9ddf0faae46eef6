"""The folder of recordings: which are in it, and how large they are."""

from __future__ import annotations

from pathlib import Path

from app.live.laboratory.recording_parts import parts_of
from worlds.input_error import InputError, unknown

MOST = 200
"""Recordings that are listed, the newest by name."""


def listed(shelf: Path | None) -> tuple[str, ...]:
    """The names of finished recordings in a folder, the newest first."""
    if shelf is None:
        return ()
    try:
        found = sorted((one.name for one in shelf.iterdir() if one.is_dir()), reverse=True)
    except OSError:
        return ()
    return tuple(name for name in found[: 5 * MOST] if is_finished(shelf / name))[:MOST]


def is_finished(folder: Path) -> bool:
    """Whether a folder holds a recording of which nothing is being written."""
    try:
        parts = parts_of(folder)
        return bool(parts) and not any(part.stream("ticks").exists() for part in parts)
    except OSError:
        return False


def on_shelf(shelf: Path | None, name: str) -> Path:
    """The recording of a name that is listed, and of no other. Raises InputError."""
    names = listed(shelf)
    if shelf is None or name not in names:
        raise (
            unknown("recording", name[:80], names) if names else InputError("there is no recording")
        )
    return shelf / name


def size(folder: Path) -> int:
    """Bytes of a recording so far."""
    try:
        return sum(part.size() for part in parts_of(folder))
    except OSError:
        return 0
