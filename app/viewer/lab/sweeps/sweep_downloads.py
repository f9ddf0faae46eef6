"""What can be taken along of a sweep: its table, its picture, its file."""

from __future__ import annotations

import tempfile
from pathlib import Path

from app.experiments.runs.store_reader import StoreReader
from app.experiments.sweeps.pictures.sweep_picture import draw
from app.experiments.sweeps.sweep_runner import SPEC
from app.experiments.sweeps.sweep_table import as_csv, wide, write_table
from worlds.input_error import InputError
from worlds.text_file import read_text

TABLES, PICTURES, FILE = ("CSV", "Parquet"), ("PNG", "SVG"), "Spec"


def content(folder: Path, kind: str, column: str | None = None) -> tuple[str, bytes]:
    """Name and bytes of one of its files. Raises InputError."""
    if kind == FILE:
        path = folder / SPEC
        return f"{folder.name}.toml", read_text(f"sweep {str(path)!r}", path).encode()
    kept = StoreReader(folder)
    if kind == "CSV":
        return f"{folder.name}.csv", as_csv(wide(kept)).encode()
    if kind not in (*TABLES, *PICTURES):
        raise InputError(f"{kind!r} is not one of {', '.join((*TABLES, *PICTURES, FILE))}")
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / f"{folder.name}.{kind.lower()}"
        if kind == "Parquet":
            write_table(wide(kept), path, False)
        else:
            draw(kept, path, column)
        return path.name, path.read_bytes()
