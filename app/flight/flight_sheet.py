"""Columns of numbers as a CSV file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from app.results_folder import make_folder
from worlds.file_writer import csv_text, write_text


def write_sheet(path: Path, columns: Mapping[str, Sequence[Any]]) -> None:
    """Write columns of one length under their names; None stays empty. Raises InputError."""
    rows = (
        ["" if one is None else f"{float(one):.9g}" for one in row]
        for row in zip(*columns.values(), strict=True)
    )
    make_folder(path.parent)
    write_text("table", path, csv_text(columns, rows))


def beat_columns(beat: Any, frequency: float) -> dict[str, Any]:
    """Columns of one wing beat or more, angles in degrees; `beat` is a `History`."""
    import numpy as np

    made = {"time_s": beat.time, "beats": beat.time * frequency}
    for name, unit in COLUMNS.items():
        values = getattr(beat, name)
        made[f"{name}_{unit}"] = np.degrees(values) if unit.startswith("deg") else values
    return made


COLUMNS = {
    "distance": "m",
    "height": "m",
    "speed": "m_per_s",
    "climb": "m_per_s",
    "pitch": "deg",
    "pitch_rate": "deg_per_s",
    "attack": "deg",
    "flap": "deg",
    "twist": "deg",
    "lift": "N",
    "thrust": "N",
    "power": "W",
    "separated": "share",
}
"""Columns of a `History` and their units."""
