"""Designs: which values the axes take together, cell by cell, in an order of their own."""

from __future__ import annotations

import csv
import io
import itertools
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from app.settings import value as read_value
from app.strict_table import Value
from app.studies.sweeps.sweep_file import (
    MOST_CELLS,
    AnyDesign,
    Axis,
    Condition,
    GridDesign,
    Latin,
    ListDesign,
    Morris,
    Saltelli,
    SampleDesign,
    Sobol,
    Span,
)
from worlds.input_error import InputError
from worlds.plug_ins import demand
from worlds.text_file import read_text

WHOLE = ("agents", "informed", "dim")
"""Axes of whole numbers; also how many agents a kind has."""
Point = dict[str, Value]


def points_of(design: AnyDesign, folder: Path) -> list[Point]:
    """The points of a design, those left out for which its condition does not hold.

    `folder` is where files that it names are looked for first. Raises InputError.
    """
    points = [round_point(point) for point in MAKERS[type(design)](design, folder)]
    if not design.where:
        return points
    if isinstance(design, Saltelli | Morris):
        raise InputError(
            f"where cannot be said of a {design.kind} design, which needs all its cells"
        )
    condition = Condition(design.where, list(points[0]) if points else [])
    allowed = [point for point in points if condition.holds(point)]
    if not allowed:
        raise InputError(f"where = {design.where!r} holds for none of {len(points)} cells")
    return allowed


def round_point(point: Point) -> Point:
    """A point with whole numbers where there are no others."""
    return {
        name: nearest_whole(value) if name.rpartition(".")[2] in WHOLE else value
        for name, value in point.items()
    }


def nearest_whole(value: Value) -> Value:
    """The nearest whole number of a number."""
    return round(value) if isinstance(value, float) and math.isfinite(value) else value


def grid_points(design: GridDesign, _: Path) -> Iterator[Point]:
    """The last axis changes first."""
    values = {name: grid_values(name, axis) for name, axis in design.axes.items()}
    cells = math.prod(map(len, values.values()))
    if cells > MOST_CELLS:
        raise InputError(f"a grid of {cells} cells is not allowed: the largest has {MOST_CELLS}")
    for chosen in itertools.product(*values.values()):
        yield dict(zip(values, chosen, strict=True))


def grid_values(name: str, axis: Axis) -> list[Any]:
    """The values of an axis of a grid. Raises InputError."""
    if not isinstance(axis, Span):
        return list(axis)
    if axis.step is not None:
        count = math.floor(abs(axis.to - axis.from_) / axis.step + 1e-9) + 1
        if count > MOST_CELLS:
            raise InputError(f"{name}: step = {axis.step:g} makes {count} values")
        step = math.copysign(axis.step, axis.to - axis.from_)
        return [round_off(axis.from_ + k * step) for k in range(count)]
    if axis.count is None:
        raise InputError(f"{name}: a grid needs count or step")
    return [value_between(axis, k / (axis.count - 1)) for k in range(axis.count)]


def value_between(axis: Span, share: float) -> float:
    """The value at a share of the way; the ends are exact."""
    if share in (0.0, 1.0):
        return axis.to if share else axis.from_
    if axis.scale == "log":
        return round_off(math.exp((1 - share) * math.log(axis.from_) + share * math.log(axis.to)))
    return round_off((1 - share) * axis.from_ + share * axis.to)


def round_off(value: float) -> float:
    """A number without the last digits of its sum: 0.3 and not 0.30000000000000004."""
    return float(f"{value:.12g}")


def list_points(design: ListDesign, folder: Path) -> Iterator[Point]:
    """Rows as they stand."""
    rows = design.rows or read_csv(find_file(design.file, folder))
    names = set(rows[0])
    for number, row in enumerate(rows, 1):
        if set(row) != names:
            odd = ", ".join(sorted(names ^ set(row)))
            raise InputError(f"row {number} differs from the first in which axes it has: {odd}")
        yield row


def find_file(file: str, folder: Path) -> Path:
    """A file that a sweep names: beside it, or else from where the command is called."""
    in_folder = folder / file
    return in_folder if in_folder.exists() else Path(file)


def read_csv(path: Path) -> list[Point]:
    """The rows of a CSV whose first line names the axes. Raises InputError naming file and line."""
    lines = csv.reader(io.StringIO(read_text(f"CSV {str(path)!r}", path)))
    try:
        names = [name.strip() for name in next(lines)]
        rows: list[Point] = []
        for line in lines:
            if not line:
                continue
            if len(line) != len(names):
                raise InputError(
                    f"{len(line)} values for {len(names)} axes ({path}, line {lines.line_num})"
                )
            rows.append(
                {name: read_value(text.strip()) for name, text in zip(names, line, strict=True)}
            )
    except StopIteration:
        raise InputError(f"{path} is empty: its first line names the axes") from None
    except csv.Error as error:
        raise InputError(f"{path} is no CSV: {error}") from None
    if not rows or "" in names or len(set(names)) < len(names):
        raise InputError(f"{path} needs a line that names each axis once, and a row below it")
    return rows


def scale_points(design: SampleDesign, unit: np.ndarray) -> Iterator[Point]:
    """Points of the unit cube (K, D) as values of the axes."""
    for row in unit:
        yield {
            name: value_between(axis, float(share))
            if isinstance(axis, Span)
            else axis[min(int(share * len(axis)), len(axis) - 1)]
            for (name, axis), share in zip(design.axes.items(), row, strict=True)
        }


def sample_points(design: SampleDesign, _: Path) -> Iterator[Point]:
    """The points of a sample."""
    yield from scale_points(design, unit_sample(design))


def unit_sample(design: SampleDesign) -> np.ndarray:
    """The points of a sample in the unit cube, (K, D), the same for the same design."""
    match design:
        case Latin():  # each axis is cut into as many parts as there are points, and each has one
            from scipy.stats import qmc

            hypercube = qmc.LatinHypercube(len(design.axes), rng=design.seed)
            return hypercube.random(design.points)
        case Sobol():  # a power of two of points keeps the sequence balanced
            from scipy.stats import qmc

            sampler = qmc.Sobol(len(design.axes), rng=design.seed)
            return sampler.random_base2(design.points.bit_length() - 1)
        case Saltelli():
            demand("SALib", "a design of kind saltelli", "experiments")
            from SALib.sample import sobol

            second = {"calc_second_order": design.second_order}
            return sobol.sample(problem(design), design.points, seed=design.seed, **second)
        case Morris():
            demand("SALib", "a design of kind morris", "experiments")
            from SALib.sample import morris

            levels = {"num_levels": design.levels}
            return morris.sample(problem(design), design.trajectories, seed=design.seed, **levels)
    raise AssertionError(design)


def problem(design: SampleDesign) -> dict[str, Any]:
    """The unit cube of its axes, as SALib takes it."""
    names = list(design.axes)
    return {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}


MAKERS: dict[type, Any] = {
    GridDesign: grid_points,
    ListDesign: list_points,
    Latin: sample_points,
    Sobol: sample_points,
    Saltelli: sample_points,
    Morris: sample_points,
}
