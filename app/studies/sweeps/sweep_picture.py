"""The picture of a sweep, written as PNG, SVG or PDF."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from app.figure import ENDINGS, NAMED, new_figure, write_figure
from app.studies.charts.axis_limits import column_bounds, parameter_bounds
from app.studies.charts.distribution import draw_distributions
from app.studies.charts.mean_line import FEW, draw_lines, draw_sample, mark_missing
from app.studies.charts.run_group import CellRuns, is_number, values_of, varied_axes
from app.studies.charts.scaling import CUMULANT, SIZE, Scaling, draw_scaling, group_by_size
from app.studies.charts.value_map import draw_map, place_cells
from app.studies.measure import MeasureBounds
from app.studies.runs.store_reader import StoreReader
from app.studies.sweeps.cell_snapshots import draw_snapshots
from app.studies.sweeps.sweep_groups import groups_of
from app.studies.sweeps.sweep_table import measured_columns
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
        cells = self.kept.cells.values()
        models = {str(cell["identity"]["spec"].get("model", "")) for cell in cells}
        return parameter_bounds(models.pop() if len(models) == 1 else "", axis)

    def draw_lines(self, x: str) -> None:
        """Draw means over an axis."""
        self.figure.set_size_inches(7.2, 4.8)
        axes = self.figure.subplots()
        draw_lines(axes, self.groups, x, self.axis_bounds(x), self.bounds)
        axes.set_xlabel(x)
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
        axes.set_xlabel(x)
        axes.set_ylabel(y)

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

    def draw_samples(self, axes: list[str]) -> None:
        """Draw the mean of each cell over each axis, a panel for each of the first."""
        panel_axes = axes[:MOST_PANELS]
        across = min(4, len(panel_axes))
        rows = -(-len(panel_axes) // across)
        self.figure.set_size_inches(1.2 + 2.9 * across, 1.0 + 2.7 * rows)
        panels = self.figure.subplots(rows, across, squeeze=False, sharey=True).ravel()
        for panel, axis in zip(panels, panel_axes, strict=False):
            draw_sample(panel, self.groups, axis, self.axis_bounds(axis), self.bounds)
            panel.set_xlabel(axis)
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
