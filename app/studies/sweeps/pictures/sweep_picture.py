"""The picture of a sweep, written as PNG, SVG or PDF."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal, get_args

from app.figure import LOOK, write_figure
from app.studies.runs.store_reader import StoreReader
from app.studies.sweeps.pictures.cell_runs import (
    CellRuns,
    groups_of,
    is_number,
    values_of,
    varied,
)
from app.studies.sweeps.pictures.maps import draw_map
from app.studies.sweeps.pictures.mean_lines import FEW, draw_distributions, draw_lines, draw_points
from app.studies.sweeps.pictures.scaling import SIZE, Scaling, draw_scaling
from worlds.file_writer import demand_writable
from worlds.input_error import InputError, unknown
from worlds.number_text import counted

Kind = Literal["lines", "map", "points", "distribution", "scaling"]
KINDS: tuple[Kind, ...] = get_args(Kind)
ENDINGS = (".png", ".svg", ".pdf")


def draw(
    kept: StoreReader,
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
    name, groups = groups_of(kept, observable, where)
    axes = varied(groups)
    for axis in (x, y):
        if axis is not None and axis not in axes:
            raise unknown("axis", axis, axes, str(kept.folder))
    kind = kind or ("map" if snapshots else suited(groups, axes))
    if snapshots and kind != "map":
        raise InputError(f"snapshots are of a map, not of {kind}")
    if scaling is not None and kind != "scaling":
        raise InputError(f"exponents are of scaling, not of {kind}")
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with matplotlib.rc_context(LOOK):  # type: ignore[arg-type]
        figure: Any = Figure(layout="constrained")
        FigureCanvasAgg(figure)
        if kind == "map":
            first, second = two(axes, x, y)
            draw_map(figure, name, groups, first, second, kept if snapshots else None)
        elif kind == "lines":
            draw_lines(figure, name, groups, one(groups, axes, x))
        elif kind == "scaling":
            rest = [axis for axis in axes if axis != SIZE] or axes
            along = SIZE if x == SIZE else one(groups, rest, x)
            draw_scaling(figure, kept, name, groups, along, where, scaling)
        elif kind == "points":
            draw_points(figure, name, groups, [x] if x else axes)
        else:
            draw_distributions(figure, name, groups)
        said = f"{kept.state.get('title', kept.folder.name)}\n{missing(groups)}"
        figure.suptitle(said, x=0.01, ha="left", wrap=True)
        write_figure(figure, path)
    return kind


def suited(groups: list[CellRuns], axes: list[str]) -> Kind:
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


def one(groups: list[CellRuns], axes: list[str], x: str | None) -> str:
    """The axis of lines. Raises InputError."""
    numeric = [axis for axis in axes if all(map(is_number, values_of(groups, axis)))]
    if x is not None and x not in numeric:
        raise InputError(f"axis {x!r} has no numbers: lines need some")
    if not numeric:
        raise InputError("no axis has numbers: lines need one, a distribution does not")
    return x or numeric[0]


def two(axes: list[str], x: str | None, y: str | None) -> tuple[str, str]:
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


def missing(groups: list[CellRuns]) -> str:
    """How many runs there are, and how many of them have no value."""
    ok, up = sum(len(group.values) for group in groups), sum(group.gave_up for group in groups)
    broken = sum(group.broken for group in groups)
    said = f"{counted(ok, 'run')} of {counted(len(groups), 'cell')}"
    said += f"; {up} gave up and are in no mean" if up else ""
    return said + (f"; {broken} failed" if broken else "")
