"""A figure in the house's look, written as PNG and SVG."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from app.figure import write_figure
from app.results_folder import PICTURES, make_folder

LIFT, THRUST, POWER, FAINT, OTHER = "#2166ac", "#2a9d5c", "#c0392b", "#9aa3ad", "#b07d12"


def paint(draw: Callable[[Any], None], title: str, folder: Path, name: str) -> dict[str, Path]:
    """Let `draw` fill a figure and write NAME.png and NAME.svg; the files by kind.

    Raises InputError if they cannot be written.
    """
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from app.experiments.pictures.experiment_picture import LOOK

    files = {kind: folder / f"{name}.{kind}" for kind in PICTURES}
    with matplotlib.rc_context(LOOK):  # type: ignore[arg-type]
        figure: Any = Figure(layout="constrained")
        FigureCanvasAgg(figure)
        draw(figure)
        figure.suptitle(title, x=0.01, ha="left")
        make_folder(folder)
        for path in files.values():
            write_figure(figure, path)
    return files
