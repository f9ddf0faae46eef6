"""A figure of matplotlib: begun in the look of all, and written whole or not at all."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from worlds.file_writer import writing

ENDINGS = (".png", ".svg", ".pdf")
"""Of the files that a figure is written to."""
DOTS = 160
"""Dots per inch of a PNG."""
UNDATED: dict[str, dict[str, None]] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
"""What takes the date out of a file, so that the same figure is the same file."""


def write_figure(figure: Any, path: Path, dots: int = DOTS) -> None:
    """Write a figure as its ending says, PNG, SVG or PDF; a file is replaced. Raises InputError."""
    with writing("picture", path) as file:
        save_figure(figure, file, path.suffix, dots)


def save_figure(figure: Any, file: BinaryIO, ending: str, dots: int = DOTS) -> None:
    """Write a figure into a file that is open."""
    kind = ending.lower().lstrip(".")
    figure.savefig(file, format=kind, dpi=dots, metadata=UNDATED.get(kind))


INK, EDGE, GRID = "#3c434b", "#7a828c", "#e3e6ea"
"""Of words, of axes, of lines behind what is drawn."""
LOOK = {
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.grid.axis": "y",
    "axes.axisbelow": True,
    "grid.color": GRID,
    "axes.edgecolor": EDGE,
    "xtick.color": INK,
    "ytick.color": INK,
    "axes.titlesize": 11,
    "lines.solid_capstyle": "butt",
    "figure.titlesize": 11,
    "legend.frameon": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "flockscope",
}
"""The look of all figures, as settings of matplotlib."""
NAMED = {"text.parse_math": False}
"""Settings for labels that hold names of users, in which a dollar begins no mathematics."""

DRAWING = threading.RLock()
"""Held while a figure is drawn: the settings of matplotlib are those of the whole process, so a
thread that sets them would change what another is drawing, and put back what that one has set."""


@contextmanager
def new_figure(settings: Mapping[str, Any] | None = None) -> Iterator[Any]:
    """An empty figure in the look of all, to be drawn and written before this ends.

    `settings`: of matplotlib, beside `LOOK`. One thread draws at a time; the others wait.
    """
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    look: Any = {**LOOK, **(settings or {})}
    with DRAWING, matplotlib.rc_context(look):
        figure = Figure(layout="constrained")
        FigureCanvasAgg(figure)
        yield figure
