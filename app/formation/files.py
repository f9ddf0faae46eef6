"""What the formation commands write: pictures as PNG and SVG, numbers as CSV."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from app.experiments.pictures.experiment_picture import LOOK
from app.figure import write_figure
from app.results_folder import PICTURES, make_folder
from worlds.file_writer import write_text

SAVED, LOST, INK, PALE = "#1f9d63", "#c0392b", "#3c434b", "#9aa3ad"
SHADES = "BrBG"
"""Colours of shares: downwash brown, upwash green."""


def written(folder: Path, name: str, draw: Callable[[Any], None]) -> dict[str, Path]:
    """Draw on a new figure and write it into the folder; the files by kind. Raises InputError."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    files = {kind: folder / f"{name}.{kind}" for kind in PICTURES}
    with matplotlib.rc_context(LOOK):  # type: ignore[arg-type]
        figure: Any = Figure(layout="constrained")
        FigureCanvasAgg(figure)
        draw(figure)
        make_folder(folder)
        for path in files.values():
            write_figure(figure, path)
    return files


def table(
    folder: Path, name: str, head: Sequence[str], rows: Iterable[Sequence[Any]]
) -> dict[str, Path]:
    """Write rows of numbers as CSV into the folder; the file by kind. Raises InputError."""
    path = folder / f"{name}.csv"
    lines = [",".join(head), *(",".join(f"{one:.9g}" for one in row) for row in rows)]
    make_folder(folder)
    write_text("table", path, "\n".join(lines) + "\n")
    return {"csv": path}
