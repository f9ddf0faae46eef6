"""A plot to take home: as a table of all that was recorded, or as a picture."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from app.figure import UNDATED
from worlds.file_writer import csv_text

KINDS = ("CSV", "PNG", "SVG")
LONGEST_NAME = 120
"""Letters of a file's name, but for its ending."""
INCHES, DOTS = (6.4, 4.0), 200
DOT = 6.0
"""Diameter of a mark on a curve, pixels."""
PIXEL = 0.72
"""Points of a pen that is a pixel wide on the page."""
INK = "#30363d"


@dataclass(frozen=True)
class Line:
    """A curve of a picture."""

    label: str
    colour: str
    """CSS, without an alpha."""
    at: np.ndarray
    values: np.ndarray
    dash: tuple[float, ...] = ()
    """Pixels, as on the page."""
    width: float = 2.0
    strength: float = 1.0
    """Below 1 for what is faint."""
    marks: tuple[np.ndarray, np.ndarray] | None = None
    """Where dots stand on it, (K,) times and values."""


@dataclass(frozen=True)
class Plotted:
    """What one plot shows, with all that is known of it."""

    name: str
    """What its files are called, without an ending."""
    caption: str
    titles: tuple[str, str]
    """Of the axes, with units."""
    range: tuple[float | None, float | None]
    """Of the values; None where an end goes with them."""
    lines: Sequence[Line]
    table: Callable[[], str]
    """Makes the CSV."""

    def file(self, kind: str) -> str:
        """The name of one of its files, in letters that every system takes.

        >>> Plotted("a b/c", "", ("", ""), (None, None), (), str).file("CSV")
        'a-b-c.csv'
        """
        return f"{file_stem(self.name)}.{kind.lower()}"

    def content(self, kind: str) -> bytes:
        """One of its files."""
        return self.table().encode() if kind == "CSV" else drawn(self, kind.lower())


def file_stem(name: str) -> str:
    """A file's name, without an ending, in letters that every system takes.

    >>> file_stem("vem (2) / ../x"), file_stem("../")
    ('vem-2-x', 'plot')
    """
    return re.sub(r"[^A-Za-z0-9_]+", "-", name).strip("-")[:LONGEST_NAME] or "plot"


def plot_csv(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table as CSV; numbers in full, nothing for nan."""
    return csv_text(header, ([plain(cell) for cell in row] for row in rows))


def plain(cell: Any) -> Any:
    """A cell of a table: whole numbers without a point, nothing for nan.

    >>> plain(np.float64(3.0)), plain(0.1), plain(np.nan), plain("x")
    (3, 0.1, '', 'x')
    """
    if not isinstance(cell, float):
        return cell
    if np.isnan(cell):
        return ""
    return int(cell) if cell.is_integer() and abs(cell) < 1e15 else float(cell)


def drawn(plotted: Plotted, kind: str) -> bytes:
    """A plot as a figure to print: PNG or SVG."""
    from matplotlib.figure import Figure

    figure: Any = Figure(figsize=INCHES, dpi=DOTS, layout="constrained")
    axes = figure.add_subplot()
    for line in plotted.lines:
        style: Any = (0, [pixels / line.width for pixels in line.dash]) if line.dash else "-"
        axes.plot(
            line.at,
            line.values,
            label=line.label,
            color=line.colour,
            alpha=line.strength,
            linestyle=style,
            linewidth=line.width * PIXEL,
            zorder=3.0 if line.strength == 1.0 else 2.0,
        )
        if line.marks is not None and len(line.marks[0]):
            axes.plot(
                *line.marks,
                marker="o",
                markersize=DOT * PIXEL,
                linestyle="",
                color=line.colour,
                alpha=line.strength,
                zorder=4.0,
            )
    axes.set_xlabel(plotted.titles[0])
    axes.set_ylabel(plotted.titles[1])
    axes.set_ylim(*plotted.range)
    axes.margins(x=0.01)
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25, linewidth=0.6)
    figure.suptitle(plotted.caption, fontsize=9, color=INK, x=0.01, ha="left")
    if any(line.label for line in plotted.lines):
        across = 1 if max(len(line.label) for line in plotted.lines) > 34 else 2
        figure.legend(loc="outside lower center", ncols=across, frameon=False, fontsize=8.5)
    file = io.BytesIO()
    figure.savefig(file, format=kind, metadata=UNDATED.get(kind))
    return file.getvalue()
