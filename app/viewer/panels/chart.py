"""One chart: curves over time between titled axes, and what is said above them."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import viser
from viser import uplot

from app.figure import UNDATED
from app.viewer.measuring.observable_curves import thin_ticks
from app.viewer.panels.sending import Sender
from app.viewer.panels.shell import Sheets, block
from worlds.file_writer import csv_text

# A plot to take home: as a table of all that was recorded, or as a picture.

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
        return self.table().encode() if kind == "CSV" else draw_plot(self, kind.lower())


def file_stem(name: str) -> str:
    """A file's name, without an ending, in letters that every system takes.

    >>> file_stem("vem (2) / ../x"), file_stem("../")
    ('vem-2-x', 'plot')
    """
    return re.sub(r"[^A-Za-z0-9_]+", "-", name).strip("-")[:LONGEST_NAME] or "plot"


def plot_csv(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table as CSV; numbers in full, nothing for nan."""
    return csv_text(header, ([plain_cell(cell) for cell in row] for row in rows))


def plain_cell(cell: Any) -> Any:
    """A cell of a table: whole numbers without a point, nothing for nan.

    >>> plain_cell(np.float64(3.0)), plain_cell(0.1), plain_cell(np.nan), plain_cell("x")
    (3, 0.1, '', 'x')
    """
    if not isinstance(cell, float):
        return cell
    if np.isnan(cell):
        return ""
    return int(cell) if cell.is_integer() and abs(cell) < 1e15 else float(cell)


def draw_plot(plotted: Plotted, kind: str) -> bytes:
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


HEIGHT, POINTS = 190, 400
"""Of a chart in a panel: pixels, and points of a curve at most, about."""
LARGE_HEIGHT, LARGE_POINTS = 400, 1500
"""The same of one that is shown large."""
PADDING = (10, 14, 0, 0)
DASH = (6.0, 5.0)
X = uplot.Scale(time=False)
"""Numbers, and no dates."""
TYPE = '11px "Flockscope Sans", sans-serif'
ROOM = {"x": 28, "y": 42, "title": 18}
"""Pixels for the numbers at the axes, and for the title of one."""


class ChartCurve(NamedTuple):
    """A curve and how it is drawn."""

    colour: str
    """CSS."""
    values: np.ndarray
    """(K,), NaN where there is none."""
    label: str = ""
    """What it is, with its unit, where the values under the mouse are told."""
    dash: tuple[float, ...] = ()
    """Pixels drawn and left out in turn; none: all are drawn."""
    width: float = 2.0
    """Pixels."""
    dots: bool = False
    """Whether its values are dots and no line."""

    @property
    def pen(self) -> tuple[str, str, tuple[float, ...], float, bool]:
        """All but the values."""
        return self.colour, self.label, self.dash, self.width, self.dots


class ChartContents(NamedTuple):
    """What a chart shows."""

    head: str
    """HTML above it; nothing if it is empty."""
    at: np.ndarray
    """(K,) times."""
    curves: tuple[ChartCurve, ...]
    """Nothing is drawn without any."""
    titles: tuple[str, str]
    """Of the axes, with units: of the times, and of the values."""
    y: uplot.Scale


NOTHING = ChartContents("", np.zeros(1), (), ("", ""), uplot.Scale())


class Chart:
    """Shows curves; hidden while it has none."""

    def __init__(self, gui: viser.GuiApi, height: int = HEIGHT, points: int = POINTS):
        self.points = points
        self.pens: tuple[Any, ...] = ()
        self.titles = ("", "")
        self.scales: dict[str, uplot.Scale] = {"x": X, "y": uplot.Scale()}
        self.head = gui.add_html("", visible=False)
        nothing = np.zeros(1)
        self.plot = gui.add_uplot(
            (nothing, nothing),
            (uplot.Series(label="t"), uplot.Series(label="nothing")),
            scales=self.scales,
            axes=axes(*self.titles),
            height=height,
            padding=PADDING,
            visible=False,
        )

    def show(self, contents: ChartContents) -> None:
        """Draw curves below the HTML of a head; each only if there is any."""
        if contents.head:
            self.head.content = block(contents.head)
        if contents.curves:
            self.draw(contents)
        self.head.visible, self.plot.visible = bool(contents.head), bool(contents.curves)

    def draw(self, contents: ChartContents) -> None:
        """Tell browsers what has changed of the curves; there are some."""
        columns = self.columns(contents)
        scales = {"x": X, "y": contents.y}
        pens = (contents.titles[0], *(curve.pen for curve in contents.curves))
        if not are_equal(columns, self.plot.data):
            self.plot.data = columns
        if scales != self.scales:
            self.scales = self.plot.scales = scales
        if contents.titles != self.titles:
            self.titles = contents.titles
            self.plot.axes = axes(*contents.titles)
        if pens != self.pens:
            self.pens = pens
            styles = (series(*curve.pen) for curve in contents.curves)
            self.plot.series = (uplot.Series(label=contents.titles[0]), *styles)

    def columns(self, contents: ChartContents) -> tuple[np.ndarray, ...]:
        """The times and the curves as they are drawn: over some time, be it ever so short."""
        indices = self.drawn_indices(contents)
        columns = (contents.at[indices], *(curve.values[indices] for curve in contents.curves))
        if columns[0][0] < columns[0][-1]:
            return columns
        return (
            columns[0][:1] + np.array([0.0, 1.0]),
            *(np.append(column[:1], np.nan) for column in columns[1:]),
        )

    def drawn_indices(self, contents: ChartContents) -> np.ndarray:
        """Which of the points are drawn: few enough, always every dot and the last of a curve."""
        finite = (
            np.flatnonzero(np.isfinite(curve.values))[0 if curve.dots else -1 :]
            for curve in contents.curves
        )
        return np.unique(np.concatenate([thin_ticks(contents.at, self.points), *finite]))


def are_equal(columns: Sequence[np.ndarray], others: Sequence[np.ndarray]) -> bool:
    """Whether all of some columns are those of others."""
    return len(columns) == len(others) and all(
        np.array_equal(a, b, equal_nan=True) for a, b in zip(columns, others, strict=True)
    )


def axes(x: str, y: str) -> tuple[uplot.Axis, uplot.Axis]:
    """The axes below and to the left, by their titles."""
    type: Any = {"font": TYPE, "labelFont": TYPE, "labelSize": ROOM["title"], "labelGap": 0}
    return (
        uplot.Axis(label=x, size=ROOM["x"], **type),
        uplot.Axis(label=y, size=ROOM["y"], **type),
    )


def series(
    colour: str, label: str, dash: tuple[float, ...], width: float, dots: bool
) -> uplot.Series:
    """How a curve is drawn."""
    if dots:
        shape: Any = {"show": True, "size": DOT, "fill": colour, "width": 0}
        hidden: Any = {"class": "fs-mark"}  # among the values under the mouse
        return uplot.Series(label=label, stroke=colour, width=0, points=shape, **hidden)
    more: Any = {"dash": dash} if dash else {}
    return uplot.Series(label=label, stroke=colour, width=width, points={"show": False}, **more)


# A plot on a page: a chart, to be looked at large and to be taken along.

LARGE = "Large"
"""The button that shows a plot large; static/plots.js presses it when a plot is clicked."""


class Plot:
    """A chart with its buttons, and the same chart in every browser that looks at it large."""

    def __init__(
        self,
        server: viser.ViserServer,
        title: str,
        take: Callable[[], Plotted | None],
        sender: Sender,
        label: str = "",
    ):
        """`take` says, when somebody asks, what the plot shows; None for nothing.

        `label` stands at the buttons.
        """
        self.title, self.take, self.sender = title, take, sender
        self.label = label or f"{title} as"
        self.shown = self.shown_large = NOTHING
        self.chart = Chart(server.gui)
        self.buttons = server.gui.add_button_group(
            self.label,
            (LARGE, *KINDS),
            visible=False,
            hint="Large: over the page, also by a click on the plot. CSV: every value that is "
            "kept, with its unit. PNG, SVG: a figure to print",
        )
        self.buttons.on_click(self.send_download)
        self.sheets = Sheets(server, self.large)

    def show(self, contents: ChartContents, head: str = "") -> None:
        """Draw curves; where they are shown large, below another head."""
        self.shown, self.shown_large = contents, contents._replace(head=head or contents.head)
        self.chart.show(contents)
        self.buttons.visible = bool(contents.curves)
        self.sheets.update_each(lambda chart: chart.show(self.shown_large))

    def large(self, gui: viser.GuiApi) -> Chart:
        """What is in a window that shows it large."""
        chart = Chart(gui, LARGE_HEIGHT, LARGE_POINTS)
        chart.show(self.shown_large)
        gui.add_button_group(self.label, KINDS).on_click(self.send_download)
        return chart

    async def send_download(self, event: viser.GuiEvent) -> None:
        client, file_kind = event.client, event.target.value
        if client is None:
            return
        if file_kind == LARGE:
            self.sheets.show(client, self.title)
        elif file_kind in KINDS and (plotted := self.take()) is not None:
            await self.sender.send(
                client, plotted.file(file_kind), lambda: plotted.content(file_kind)
            )
