"""How far a sweep is, as its store says, also while another process runs it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from app.studies.runs.store import is_taken
from app.studies.runs.store_reader import StoreReader


def status_of(folder: Path) -> dict[str, Any]:
    """How far the sweep of a folder is. Raises InputError."""
    kept = StoreReader(folder)
    state, counts = kept.state, kept.counts
    running = is_taken(folder)
    progress = state.get("progress") if running else None
    return {
        "folder": str(folder),
        "title": state.get("title", ""),
        "state": "running" if running else "stopped" if left(state, counts) else "done",
        "runs": counts,
        "done": sum(counts.values()),
        "of": state.get("runs"),
        "others": kept.others,
        "rate": progress and progress.get("rate"),
        "seconds_left": progress and progress.get("seconds_left"),
        "workers": progress and progress.get("workers"),
        "pid": progress and progress.get("pid"),
    }


def left(state: dict[str, Any], counts: dict[str, int]) -> bool:
    """Whether there are runs to make."""
    return bool(state.get("runs", 0) > sum(counts.values()))
