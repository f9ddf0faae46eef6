"""A new folder for each recording of a room."""

from __future__ import annotations

from datetime import datetime
from itertools import count
from pathlib import Path


def new_folder(folder: Path, now: datetime) -> Path:
    """A folder in `folder` that does not exist, named for the time: `2026-11-22-093015`."""
    name = now.strftime("%Y-%m-%d-%H%M%S")
    names = (name if number == 1 else f"{name}-{number}" for number in count(1))
    return next(folder / one for one in names if not (folder / one).exists())
