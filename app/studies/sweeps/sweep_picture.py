"""The picture of a sweep, written as PNG, SVG or PDF; distributions, and what cells look like."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from agents.flock import Flock
from agents.models.declare import DeclaredParameter
from app.figure import ENDINGS, NAMED, new_figure, write_figure
from app.studies.charts.axis_limits import column_bounds, measure_limits, parameter_bounds
from app.studies.charts.colour_table import CENSORED, COLOURS, FAILED
from app.studies.charts.mean_line import FEW, draw_lines, draw_sample, mark_missing
from app.studies.charts.run_group import CellRuns, is_number, label, values_of, varied_axes
from app.studies.charts.scaling import (
    CUMULANT,
    SIZE,
    Scaling,
    draw_scaling,
    group_by_size,
    plain_text,
)
from app.studies.charts.value_map import draw_map, place_cells
from app.studies.measure import UNBOUNDED, MeasureBounds
from app.studies.run_axes import axis_label
from app.studies.runs.store_reader import StoreReader
from app.studies.sweeps.sweep_table import (
    groups_of,
    measured_columns,
    models_of,
    places_of,
    spec_at,
)
from worlds.file_writer import demand_writable
from worlds.input_error import InputError, unknown
from worlds.number_text import counted

Kind = Literal["lines", "map", "points", "distribution", "scaling"]
KINDS: tuple[Kind, ...] = get_args(Kind)
MOST_PANELS = 12
"""Of a sample, a panel for each axis."""


def draw(
    reader: StoreReader,
    path: Path,
    observable: str | None = None,
    *,
    kind: str | None = None,
    x: str | None = None,
    y: str | None = None,
    where: str = "",
    snapshots: bool = False,
    scaling: Scaling | None = None,
    overwrite: bool = True,
) -> str:
    """Draw an observable, the first by default; returns the kind of picture. Raises InputError.

    `x` and `y` are the axes of the picture; `where` is a condition that leaves cells out.
    `snapshots`: whether a map shows how the flock of each cell looks at its end. `scaling`: the
    exponents of the collapse that a picture of finite-size scaling shows.
    """
    demand_writable("picture", path, overwrite, ENDINGS)
    if kind is not None and kind not in KINDS:
        raise unknown("kind of picture", kind, KINDS)
    name, groups = groups_of(reader, observable, where)
    axes = varied_axes(groups)
    for axis in (x, y):
        if axis is not None and axis not in axes:
            raise unknown("axis", axis, axes, str(reader.folder))
    kind = kind or ("map" if snapshots else choose_kind(groups, axes))
    if snapshots and kind != "map":
        raise InputError(f"snapshots are of a map, not of {kind}")
    if scaling is not None and kind != "scaling":
        raise InputError(f"exponents are of scaling, not of {kind}")
    # labels of scaling are mathematics, and have names of users escaped
    with new_figure({} if kind == "scaling" else NAMED) as figure:
        chart = SweepChart(figure, reader, name, groups)
        if kind == "map":
            chart.draw_map(*choose_two_axes(axes, x, y), snapshots)
        elif kind == "lines":
            chart.draw_lines(choose_axis(groups, axes, x))
        elif kind == "scaling":
            rest = [axis for axis in axes if axis != SIZE] or axes
            chart.draw_scaling(SIZE if x == SIZE else choose_axis(groups, rest, x), where, scaling)
        elif kind == "points":
            chart.draw_samples([x] if x else axes)
        else:
            chart.draw_distributions()
        title = f"{reader.state.get('title', reader.folder.name)}\n{describe_missing(groups)}"
        figure.suptitle(title, x=0.01, ha="left", wrap=True, parse_math=False)
        write_figure(figure, path)
    return kind


@dataclass
class SweepChart:
    """A chart of a sweep on a figure of its own: sizes, names and bounds of the axes."""

    figure: Any
    kept: StoreReader
    name: str
    """Of what is measured."""
    groups: list[CellRuns]

    @property
    def bounds(self) -> MeasureBounds:
        """Of what is measured."""
        return column_bounds(self.name)

    def axis_bounds(self, axis: str) -> MeasureBounds:
        """Of an axis of the sweep, by the model that is run."""
        return parameter_bounds(models_of(self.kept).of_axis(axis), axis)

    def name_axis(self, put: Callable[..., Any], axis: str) -> None:
        """Name an axis of the sweep along an axis of the picture, which `put` labels."""
        label = axis_label(models_of(self.kept).of_axis(axis), axis, mathtext_symbol)
        if label:
            put(label, parse_math=True)
        else:
            put(axis)

    def draw_lines(self, x: str) -> None:
        """Draw means over an axis."""
        self.figure.set_size_inches(7.2, 4.8)
        axes = self.figure.subplots()
        draw_lines(axes, self.groups, x, self.axis_bounds(x), self.bounds)
        self.name_axis(axes.set_xlabel, x)
        axes.set_ylabel(f"{self.name}, mean and 95 % interval")
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize=9)

    def draw_map(self, x: str, y: str, snapshots: bool) -> None:
        """Draw a map, with the flock of each cell in it if `snapshots`. Raises InputError."""
        across, up = values_of(self.groups, x), values_of(self.groups, y)
        wide = 0.9 if snapshots else 0.42
        high = max(5.2, 1.4 + wide * len(up)) if snapshots else 5.2
        self.figure.set_size_inches(1.8 + min(14.0, max(4.0, wide * len(across))), min(14.0, high))
        axes = self.figure.subplots()
        cells = place_cells(self.groups, across, up, x, y)
        mesh = draw_map(axes, cells, across, up, self.bounds)
        if snapshots:
            draw_snapshots(axes, self.kept, {c.group.number: (c.column, c.row) for c in cells})
        self.figure.colorbar(mesh, ax=axes, label=f"{self.name}, mean")
        signs = axes.get_legend_handles_labels()[0]
        if signs:
            self.figure.legend(handles=signs, loc="outside lower right", ncols=2, fontsize=9)
        self.name_axis(axes.set_xlabel, x)
        self.name_axis(axes.set_ylabel, y)

    def draw_scaling(self, x: str, where: str, by: Scaling | None) -> None:
        """Draw the panels of finite-size scaling that the sweep has. Raises InputError."""
        lines = group_by_size(self.kept, self.groups, x)
        cumulants = {}
        if CUMULANT in measured_columns(self.kept) and self.name != CUMULANT:
            cumulants = group_by_size(self.kept, groups_of(self.kept, CUMULANT, where)[1], x)
        across = 1 + bool(cumulants) + (by is not None)
        self.figure.set_size_inches(1.6 + 4.0 * across, 4.4)
        panels = list(self.figure.subplots(1, across, squeeze=False)[0])
        mark_missing(panels[0], self.groups, x)
        draw_scaling(panels, self.name, lines, cumulants, x, by, self.axis_bounds(x))
        if axis_label(models_of(self.kept).of_axis(x), x):
            for panel in panels[: 1 + bool(cumulants)]:
                self.name_axis(panel.set_xlabel, x)

    def draw_samples(self, axes: list[str]) -> None:
        """Draw the mean of each cell over each axis, a panel for each of the first."""
        panel_axes = axes[:MOST_PANELS]
        across = min(4, len(panel_axes))
        rows = -(-len(panel_axes) // across)
        self.figure.set_size_inches(1.2 + 2.9 * across, 1.0 + 2.7 * rows)
        panels = self.figure.subplots(rows, across, squeeze=False, sharey=True).ravel()
        for panel, axis in zip(panels, panel_axes, strict=False):
            draw_sample(panel, self.groups, axis, self.axis_bounds(axis), self.bounds)
            self.name_axis(panel.set_xlabel, axis)
        for panel in panels[len(panel_axes) :]:
            panel.set_visible(False)
        for row in range(rows):
            panels[row * across].set_ylabel(f"{self.name}, mean")

    def draw_distributions(self) -> None:
        """Draw a box for each cell."""
        self.figure.set_size_inches(6.8, 1.6 + 0.42 * len(self.groups))
        axes = self.figure.subplots()
        draw_distributions(axes, self.groups, self.bounds)
        axes.set_xlabel(self.name)


def mathtext_symbol(parameter: DeclaredParameter) -> str:
    """The symbol of a parameter for matplotlib; its name where that cannot set it."""
    from matplotlib.mathtext import MathTextParser

    try:
        MathTextParser("path").parse(f"${parameter.symbol}$")
    except ValueError:
        return plain_text(parameter.name)
    return f"${parameter.symbol}$"


def choose_kind(groups: list[CellRuns], axes: list[str]) -> Kind:
    """The kind of picture that shows what is swept over."""
    numeric = [axis for axis in axes if all(map(is_number, values_of(groups, axis)))]
    if not numeric:
        return "distribution"
    cells = 1
    for axis in axes:
        cells *= len(values_of(groups, axis))
    if len(axes) > 1 and cells > 4 * len(groups):  # a sample: hardly two cells share a value
        return "points"
    few = len(axes) == 1 or len(values_of(groups, axes[1])) <= FEW
    return "lines" if few or len(numeric) < 2 or len(axes) > 2 else "map"


def choose_axis(groups: list[CellRuns], axes: list[str], x: str | None) -> str:
    """The axis of lines. Raises InputError."""
    numeric = [axis for axis in axes if all(map(is_number, values_of(groups, axis)))]
    if x is not None and x not in numeric:
        raise InputError(f"axis {x!r} has no numbers: lines need some")
    if not numeric:
        raise InputError("no axis has numbers: lines need one, a distribution does not")
    return x or numeric[0]


def choose_two_axes(axes: list[str], x: str | None, y: str | None) -> tuple[str, str]:
    """The axes of a map. Raises InputError."""
    rest = [axis for axis in axes if axis not in (x, y)]
    first = x or (rest.pop(0) if rest else "")
    second = y or (rest.pop(0) if rest else "")
    if not first or not second:
        raise InputError("a map needs two axes with several values each")
    if rest:
        raise InputError(
            f"{', '.join(rest)} varies too: say at which value, such as --where '{rest[0]} == ...'"
        )
    return first, second


def describe_missing(groups: list[CellRuns]) -> str:
    """How many runs there are, and how many of them have no value."""
    ok, up = sum(len(group.values) for group in groups), sum(group.gave_up for group in groups)
    broken = sum(group.broken for group in groups)
    text = f"{counted(ok, 'run')} of {counted(len(groups), 'cell')}"
    text += f"; {up} gave up and are in no mean" if up else ""
    return text + (f"; {broken} failed" if broken else "")


# How runs are spread: a box for each group with every run as a point; bars with intervals.


MOST_DISTRIBUTIONS = 40
"""Boxes in one chart."""


def draw_distributions(
    axes: Any, groups: Sequence[CellRuns], bounds: MeasureBounds = UNBOUNDED
) -> None:
    """Draw a box for each cell, the first at the top. Raises InputError if there are too many."""
    if len(groups) > MOST_DISTRIBUTIONS:
        raise InputError(f"{len(groups)} boxes are too many: leave cells out with --where")
    places = np.arange(len(groups))[::-1]
    axes.boxplot(
        [group.values for group in groups],
        positions=places,
        orientation="horizontal",
        widths=0.55,
        showfliers=False,
        medianprops={"color": COLOURS[0]},
        manage_ticks=False,
    )
    off = np.random.default_rng(0)
    for place, group in zip(places, groups, strict=True):
        at = place + off.uniform(-0.18, 0.18, len(group.values))
        axes.plot(group.values, at, ".", color=COLOURS[0], alpha=0.45, markersize=4, clip_on=False)
        words = []
        if group.gave_up:
            words.append((f"{group.gave_up} gave up", CENSORED))
        if group.broken:
            words.append((f"{group.broken} failed", FAILED))
        for number, (text, colour) in enumerate(words):
            where = axes.get_yaxis_transform()
            axes.text(1.01, place - 0.25 * number, text, color=colour, fontsize=8, transform=where)
    axes.set_yticks(places, [label(group.axes) or "all runs" for group in groups], fontsize=9)
    axes.grid(axis="x")
    axes.set_xlim(*measure_limits([v for group in groups for v in group.values], bounds))


# How a flock of each cell of a map looks at its end, drawn small into the cell.


MOST = 150
"""Cells whose flocks are drawn."""
MOST_STEPS = 50_000_000
"""Steps of agents that are run again for it."""
PART = 0.84
"""Of a cell's width, the rest is its colour."""


def draw_snapshots(axes: Any, reader: StoreReader, at: dict[int, tuple[int, int]]) -> None:
    """Draw the flock of each cell's first run at its end; `at` is where a cell stands on the map.

    It is run again for that. Raises InputError if there are too many, or too long runs.
    """
    first: dict[int, tuple[int, int]] = {}
    for cell, seed, status, _, _, ticks, _ in reader.runs([]):
        if status in ("ok", "gave-up") and cell in at:
            first.setdefault(cell, (seed, ticks))
    steps = sum(
        ticks * reader.cells[cell]["identity"]["spec"]["agents"]
        for cell, (_, ticks) in first.items()
    )
    if len(first) > MOST or steps > MOST_STEPS:
        raise InputError(
            f"the flocks of {len(first)} cells, {steps:.2g} steps of agents, are too much to draw: "
            f"leave cells out with --where, {MOST} and {MOST_STEPS:.2g} are allowed"
        )
    places = places_of(reader)
    for cell, (seed, ticks) in first.items():
        flock = Flock(spec_at(reader, places[cell], seed))
        flock.run(ticks)
        column, row = at[cell]
        margin = 0.5 * (1.0 - PART)
        corner = column + margin, row + margin
        draw_flock(axes.inset_axes([*corner, PART, PART], transform=axes.transData), flock)


def draw_flock(inset: Any, flock: Flock) -> None:
    """Draw a flock from above: arrows along its headings, as large as its world or itself."""
    low, size = flock.world.low, flock.world.size
    position, heading = flock.position, flock.heading
    inset.quiver(
        *position.T[:2], *heading.T[:2],
        angles="xy", pivot="mid", scale=14.0, width=0.02, headwidth=5, color="black",
    )  # fmt: skip
    if all(flock.world.wraps[:2]):
        inset.set_xlim(low[0], low[0] + size[0])
        inset.set_ylim(low[1], low[1] + size[1])
    else:
        inset.margins(0.1)
    inset.set_aspect("equal", adjustable="box" if all(flock.world.wraps[:2]) else "datalim")
    inset.set_xticks([])
    inset.set_yticks([])
    inset.grid(False)
    inset.patch.set_alpha(0.75)
