"""A figure of matplotlib as a file, whole or not at all."""

from __future__ import annotations

from pathlib import Path
from typing import Any, BinaryIO

from worlds.file_writer import writing

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


LOOK = {
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.grid.axis": "y",
    "axes.axisbelow": True,
    "grid.color": "#e3e6ea",
    "axes.edgecolor": "#7a828c",
    "xtick.color": "#3c434b",
    "ytick.color": "#3c434b",
    "axes.titlesize": 11,
    "lines.solid_capstyle": "butt",
    "figure.titlesize": 11,
    "legend.frameon": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "flockscope",
}
"""The look of all figures, as settings of matplotlib."""
