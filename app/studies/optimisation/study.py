"""An optimisation as a value: read from a file, its box of points, and the runs of a point."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from agents.observables.catalogue import OBSERVABLES
from agents.spec import LARGEST_SEED, Spec
from app.strict_table import Line, StrictTable, Value
from app.studies.cluster.cluster_options import Cluster
from app.studies.key_lines import KeyLocations, name_in_refusal
from app.studies.run_axes import AxisModels, ByAxis, read_axis, spec_with, value_of
from app.studies.search import Algorithm, demand_package
from app.studies.sweeps.checked_sweep import (
    Sweep,
    base_of,
    check_file,
    first_flock,
    make_job,
)
from app.studies.sweeps.designs import Point, round_point, value_between
from app.studies.sweeps.sweep_cells import Basis, Cell
from app.studies.sweeps.sweep_file import (
    MOST_TICKS,
    Axis,
    Condition,
    ObservableBound,
    Observe,
    Replicates,
    RunOptions,
    Span,
    Stop,
    SweepFile,
    comparison,
    file_text,
)
from app.studies.sweeps.sweep_job import K, measure_of
from worlds.input_error import InputError, unknown
from worlds.text_file import read_text, toml

# The TOML file of an optimisation: a sweep's, with a search in place of designs.

MOST_EVALUATIONS = 1_000_000
FRESH_FROM = 1000
"""How much later fresh seeds begin, so that they are easily told from the others."""


class Search(StrictTable):
    """What is searched, and how."""

    algorithm: Algorithm
    axes: ByAxis[Axis] = Field(min_length=1)
    where: str = ""
    """A condition between axes: points for which it does not hold are not run."""
    evaluations: int = Field(ge=1, le=MOST_EVALUATIONS)
    """Points that are proposed, at most."""
    population: int | None = Field(default=None, ge=2, le=10_000)
    """Points of a generation."""
    seed: int = Field(default=1, ge=0, le=2**32 - 1)
    """Of the search, not of its runs."""

    @field_validator("axes")
    @classmethod
    def _are_bounds(cls, axes: dict[str, Axis]) -> dict[str, Axis]:
        for name, axis in axes.items():
            if isinstance(axis, Span) and (axis.count is not None or axis.step is not None):
                raise ValueError(f"{name}: a search finds its own values: leave count and step out")
            if not isinstance(axis, Span) and len(axis) < 2:
                raise ValueError(f"{name}: there is nothing to choose between")
        return axes

    @model_validator(mode="after")
    def _fits(self) -> Search:
        if self.algorithm == "cma" and len(self.axes) < 2:
            raise ValueError("algorithm: cma needs two axes or more: take ga or pso")
        return self

    @property
    def generation(self) -> int:
        """Points of a generation: an eighth of all, from 4 to 50, where nothing is said."""
        return self.population or max(4, min(50, self.evaluations // 8))


class Seeds(StrictTable):
    """How often each point is run, with seeds that all points have in common."""

    count: int = Field(default=10, ge=1, le=1_000_000)
    first: int = Field(default=1, ge=0, le=LARGEST_SEED // 2)
    fresh: int = Field(default=100, ge=2, le=1_000_000)
    """Seeds that the search has not seen, on which the best is told."""

    @property
    def search_seeds(self) -> range:
        """Those of the search."""
        return range(self.first, self.first + self.count)

    @property
    def fresh_seeds(self) -> range:
        """Those of the answer."""
        first = self.first + max(FRESH_FROM, self.count)
        return range(first, first + self.fresh)


class PointMeasurement(StrictTable):
    """What is measured of a point, in runs that may differ from the others."""

    at: ByAxis[Value] = Field(default_factory=dict)
    """Parameters and options of these runs."""
    ticks: int | None = Field(default=None, ge=1, le=MOST_TICKS)
    """Ticks of these runs; None: as [run] has it."""
    stop: bool = True
    """Whether [stop] is for these runs, too."""


class Objective(PointMeasurement):
    """What is to be the least or the most: the mean of an observable over the seeds."""

    observable: str
    """A column of what is observed; k of [stop]."""
    aim: Literal["least", "most"]


class Constraint(PointMeasurement):
    """What the mean of an observable has to keep to."""

    says: str
    """A comparison with >= or <=, such as `polarisation >= 0.9`."""


class OptimisationFile(StrictTable):
    """A whole file."""

    title: Line = Field(default="", max_length=200)
    run: RunOptions
    stop: Stop | None = None
    search: Search
    replicates: Seeds = Seeds()
    observe: list[Observe] = Field(default_factory=list)
    objective: list[Objective] = Field(min_length=1)
    constraint: list[Constraint] = Field(default_factory=list)
    cluster: Cluster = Cluster()

    @model_validator(mode="after")
    def _fits(self) -> OptimisationFile:
        several = len(self.objective) > 1
        if several != (self.search.algorithm == "nsga2"):
            raise ValueError(
                "algorithm: several objectives need nsga2, one needs ga, pso or cma: there are "
                f"{len(self.objective)} with {self.search.algorithm}"
            )
        return self


CORNERS = 64
"""Corners of the box that are built before anything is run."""


@dataclass(frozen=True)
class Variant:
    """One of the runs that a point has."""

    at: dict[str, Value]
    sweep: Sweep
    """Its run with the default point as its only cell."""
    basis: Basis

    def cell(self, point: Point) -> Cell:
        """The runs of a point. Raises InputError if they cannot be."""
        axes = {**point, **self.at}
        return self.basis.cell(spec_with(self.sweep.base, axes), axes, 0)


@dataclass(frozen=True)
class SearchGoal:
    """An objective: a column of a variant, and the sign with which less is better."""

    name: str
    column: str
    variant: int
    sign: int

    @property
    def aim(self) -> str:
        """Least or most."""
        return "least" if self.sign > 0 else "most"


@dataclass(frozen=True)
class Limit:
    """A constraint: what the mean of a column of a variant has to keep to."""

    says: ObservableBound
    variant: int

    def violation(self, mean: float) -> float:
        """How far a mean is on the wrong side; below 0 on the right one."""
        return self.says.bound - mean if self.says.sign == ">=" else mean - self.says.bound


@dataclass(frozen=True)
class Study:
    """What is to be optimised, and from where it was read."""

    file: OptimisationFile
    places: KeyLocations
    folder: Path
    variants: list[Variant]
    goals: list[SearchGoal]
    limits: list[Limit]
    default: Point
    """What the run has without a search."""
    text: str

    @property
    def title(self) -> str:
        """Its title, or what it searches."""
        aims = ", ".join(f"{goal.aim} {goal.name}" for goal in self.goals)
        return self.file.title or f"{self.file.run.model}: {aims} over {', '.join(self.default)}"

    @property
    def columns(self) -> list[str]:
        """What the runs have values of."""
        names = [name for variant in self.variants for name in variant.sweep.making.columns]
        return list(dict.fromkeys(names))

    def point(self, unit: np.ndarray) -> Point:
        """A point of the unit cube (D,) as values of the axes."""
        axes = self.file.search.axes
        return round_point(
            {
                name: value_between(axis, float(share))
                if isinstance(axis, Span)
                else axis[min(int(share * len(axis)), len(axis) - 1)]
                for (name, axis), share in zip(axes.items(), unit, strict=True)
            }
        )

    def is_allowed(self, point: Point) -> bool:
        """Whether the condition between axes holds. Raises InputError if it cannot be said."""
        where = self.file.search.where
        return not where or Condition(where, list(point)).holds(point)


def read_study(path: Path) -> Study:
    """The study of a TOML file. Raises InputError naming file and line."""
    text = read_text(f"optimisation {str(path)!r}", path)
    return study_of(toml(text, str(path)), KeyLocations(str(path), text), path.parent)


def study_of(values: dict[str, Any], places: KeyLocations, folder: Path) -> Study:
    """The study of values, as TOML has them. Raises InputError, before anything is run."""
    file = check_file(OptimisationFile, values, places)
    demand_package(file.search.algorithm)
    observed = columns_of(file, places, folder)
    everything: list[Objective | Constraint] = [*file.objective, *file.constraint]
    measurements: list[PointMeasurement] = []
    for entry in everything:
        if not any(is_same_run(entry, other) for other in measurements):
            measurements.append(entry)
    names = [column(entry, places) for entry in everything]
    columns_wanted = [
        [
            name
            for name, other in zip(names, everything, strict=True)
            if is_same_run(measurement, other)
        ]
        for measurement in measurements
    ]
    variants = [
        variant(file, measurement, columns, observed, places, folder)
        for measurement, columns in zip(measurements, columns_wanted, strict=True)
    ]
    number = [
        next(k for k, measurement in enumerate(measurements) if is_same_run(measurement, each))
        for each in everything
    ]
    goals = [
        SearchGoal(
            goal_name(objective, name, names), name, k, 1 if objective.aim == "least" else -1
        )
        for objective, name, k in zip(file.objective, names, number, strict=False)
    ]
    rest = number[len(file.objective) :]
    limits = [
        Limit(parse_constraint(constraint, places), k)
        for constraint, k in zip(file.constraint, rest, strict=True)
    ]
    study = Study(
        file, places, folder, variants, goals, limits,
        default_of(variants[0], file), places.text or file_text(values),
    )  # fmt: skip
    check_corners(study)
    return study


def is_same_run(measurement: PointMeasurement, other: PointMeasurement) -> bool:
    """Whether two things are measured of the same runs."""
    return (measurement.at, measurement.ticks, measurement.stop) == (
        other.at,
        other.ticks,
        other.stop,
    )


def column(constraint: Objective | Constraint, places: KeyLocations) -> str:
    """The column that is asked of. Raises InputError."""
    return (
        constraint.observable
        if isinstance(constraint, Objective)
        else parse_constraint(constraint, places).name
    )


def parse_constraint(constraint: Constraint, places: KeyLocations) -> ObservableBound:
    """The comparison of a constraint. Raises InputError."""
    where = places.describe("says", "constraint")
    try:
        says = comparison(constraint.says)
    except InputError as refusal:
        raise InputError(f"{refusal} ({where})") from None
    if says.sign not in (">=", "<="):
        raise InputError(f"says = {constraint.says!r} is not allowed: >= or <= is needed ({where})")
    return says


def goal_name(objective: Objective, name: str, names: list[str]) -> str:
    """What an objective is called: with what is other in its runs, where another has its name."""
    if names.count(name) < 2 or not objective.at:
        return name
    return f"{name} at " + ", ".join(f"{key} = {value}" for key, value in objective.at.items())


def columns_of(file: OptimisationFile, places: KeyLocations, folder: Path) -> dict[str, Observe]:
    """What is observed by its column. Raises InputError."""
    columns: dict[str, Observe] = {}
    for entry in file.observe:
        try:
            columns[measure_of(entry, folder).column] = entry
        except InputError as refusal:
            key = "measure" if entry.measure else "name"
            raise InputError(f"{refusal} ({places.describe(key, 'observe')})") from None
    return columns


def variant(
    file: OptimisationFile,
    measurement: PointMeasurement,
    columns: list[str],
    observed: dict[str, Observe],
    places: KeyLocations,
    folder: Path,
) -> Variant:
    """The runs that some columns are measured of. Raises InputError."""
    stop = file.stop if measurement.stop else None
    observe: list[Observe] = []
    for name in dict.fromkeys(columns):
        if name == K and stop is not None:
            continue
        if name in observed:
            observe.append(observed[name])
        elif name in OBSERVABLES and not OBSERVABLES[name].over:
            observe.append(Observe(name=name))
        else:
            names = [*observed, *([K] if stop else [])]
            raise unknown("column", name, names, places.describe("observable", "objective"))
    for entry in observe:
        if entry.every is not None:
            raise InputError(
                f"when = {entry.when!r} gives no single value that could be the best: leave it out "
                f"({places.describe('when', 'observe')})"
            )
    run = (
        file.run
        if measurement.ticks is None
        else file.run.model_copy(update={"ticks": measurement.ticks})
    )
    seeds = Replicates(count=file.replicates.count, first=file.replicates.first)
    variant_file = SweepFile(
        title=file.title, run=run, stop=stop, observe=observe, replicates=seeds
    )
    base = base_of(variant_file, places, folder)
    making = make_job(variant_file, places, folder, lambda: first_flock(base, [(0, {})], places))
    making.prepare()
    basis = Basis(making, seeds.first)
    try:
        cell = basis.cell(spec_with(base, measurement.at), dict(measurement.at), 0)
    except InputError as refusal:
        where = places.describe(
            name_in_refusal(str(refusal)), "objective.at" if measurement.at else "run"
        )
        raise InputError(f"{refusal} ({where})") from None
    sweep = Sweep(variant_file, places, folder, base, making, [cell], places.text)
    return Variant(dict(measurement.at), sweep, basis)


def default_of(first: Variant, file: OptimisationFile) -> Point:
    """The values that the axes have without a search. Raises InputError for an axis that is
    none."""
    cell = first.sweep.cells[0]
    values = {**cell.identity["spec"], **cell.identity["spec"]["parameters"]}
    for name in file.search.axes:
        where = first.sweep.places.describe(name, "search.axes")
        if name in ("parameters", "ticks", "seed"):
            raise InputError(
                f"axis {name!r} is not allowed: it is no parameter or option ({where})"
            )
        axis = read_axis(name, AxisModels.of_run(cell.spec).of_axis(name))
        if axis.moment or axis.kind:
            values[name] = number_of(cell.spec, name, where)
        if name not in values:
            raise unknown("axis", name, values, where)
        if name in first.at:
            raise InputError(f"axis {name!r} is not allowed: an objective says itself what it is")
        if name in cell.spec.individuals:
            raise InputError(
                f"axis {name!r} is not allowed: agents differ in it "
                f"({cell.spec.individuals[name]}): search {name}.mean and {name}.spread ({where})"
            )
    return {name: values[name] for name in file.search.axes}


def number_of(spec: Spec, axis: str, where: str) -> float:
    """What a run has of an axis over a mean, a spread, or a number of a kind. Or InputError."""
    try:
        value = 0.0 if axis.endswith(".spread") else value_of(spec, axis)
        spec_with(spec, {axis: value})
        if isinstance(value, str):
            raise InputError(
                f"{axis} is not allowed: agents differ in it ({value}): "
                f"search {axis}.mean and {axis}.spread"
            )
        return float(value_of(spec, axis))
    except InputError as refusal:
        raise InputError(f"{refusal} ({where})") from None


def check_corners(study: Study) -> None:
    """Build a run at the corners of the box. Raises InputError naming the axis and its line."""
    axes = study.file.search.axes
    try:
        study.is_allowed(study.default)
    except InputError as refusal:
        raise InputError(f"{refusal} ({study.places.describe('where', 'search')})") from None
    for corner in itertools.islice(itertools.product((0.0, 1.0), repeat=len(axes)), CORNERS):
        point = study.point(np.array(corner))
        if not study.is_allowed(point):
            continue
        for variant in study.variants:
            try:
                variant.cell(point)
            except InputError as refusal:
                word = name_in_refusal(str(refusal))
                table = "search.axes" if word in point else "run"
                point_text = ", ".join(f"{name} = {value!r}" for name, value in point.items())
                at = study.places.describe(word, table)
                raise InputError(f"{refusal} ({at}; a corner of the box: {point_text})") from None


def spec_at(study: Study, point: Point) -> Spec:
    """The run of a point, as its first objective has it."""
    first = study.variants[0]
    return spec_with(first.sweep.base, {**point, **first.at})
