"""A sweep as a value: read from a file or from options, every cell of it checked."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from agents.catalogue import from_file
from agents.flock import Flock
from agents.observables.catalogue import OBSERVABLES, telling_observables
from agents.policies import known_policy
from agents.spec import Options, Spec
from app.strict_table import StrictTable
from app.studies.key_lines import KeyLocations, name_in_refusal
from app.studies.run_axes import read_axis, spec_with
from app.studies.sweeps.designs import Point, find_file, points_of
from app.studies.sweeps.sweep_cells import Basis, Cell
from app.studies.sweeps.sweep_file import (
    MOST_CELLS,
    Condition,
    Observe,
    Record,
    RunOptions,
    SweepFile,
    comparison,
    file_text,
)
from app.studies.sweeps.sweep_job import (
    HEADS,
    RunRequest,
    StopCondition,
    SweepJob,
    SweepMeasure,
    demand_number,
    measure_of,
)
from worlds.input_error import InputError, error_of_lines, needed, unknown
from worlds.number_text import counted
from worlds.text_file import read_text, toml

MOST_FAULTS = 20
"""Different refusals after which no further cell is looked at."""


@dataclass(frozen=True)
class Sweep:
    """What is to be run, and from where it was read."""

    file: SweepFile
    places: KeyLocations
    folder: Path
    """Where files that it names are looked for first."""
    base: Spec
    """The run that all cells share."""
    making: SweepJob
    cells: list[Cell]
    text: str
    """The file, or what a file would be that says the same."""

    @property
    def title(self) -> str:
        """Its title, or what it sweeps over."""
        return self.file.title or f"{self.file.run.model}: {', '.join(self.axes) or 'one cell'}"

    @property
    def axes(self) -> list[str]:
        """What differs between its cells, in the order of the designs."""
        return list(dict.fromkeys(name for cell in self.cells for name in cell.axes))

    def seed(self, cell: Cell, replicate: int) -> int:
        """The seed of a replicate of a cell, which are counted from 0."""
        replicates = self.file.replicates
        first = (
            replicates.first if replicates.seeds == "common" else cell.first_seed + replicates.first
        )
        return first + replicate

    def seeds(self, cell: Cell, replicates: int) -> range:
        """The seeds of the first replicates of a cell."""
        first = self.seed(cell, 0)
        return range(first, first + replicates)

    def run_request(self, cell: Cell, number: int, replicate: int, folder: Path) -> RunRequest:
        """A run as a process is asked for it; `number` is its place in the plan, from 1."""
        for record in self.file.record:
            if replicate < record.replicates and is_recorded(record, cell):
                seed = self.seed(cell, replicate)
                path = folder / "recordings" / f"cell-{number}-seed-{seed}.parquet"
                return RunRequest(cell.spec, str(path.absolute()), record.every)
        return RunRequest(cell.spec)


def is_recorded(record: Record, cell: Cell) -> bool:
    """Whether the runs of a cell are recorded."""
    return not record.where or Condition(record.where, list(cell.axes)).holds(cell.axes)


def read_sweep(path: Path, tell: Callable[[str], Any] | None = None) -> Sweep:
    """The sweep of a TOML file. Raises InputError naming file, line, axis and value."""
    text = read_text(f"sweep {str(path)!r}", path)
    return sweep_of(toml(text, str(path)), KeyLocations(str(path), text), path.parent, tell)


def sweep_of(
    values: dict[str, Any],
    places: KeyLocations,
    folder: Path,
    tell: Callable[[str], Any] | None = None,
) -> Sweep:
    """The sweep of values, as TOML has them. Raises InputError, before anything is run."""
    file = check_file(SweepFile, values, places)
    base = base_of(file, places, folder)
    points = list(all_points(file, places, folder))
    if len(points) > MOST_CELLS:
        raise InputError(f"{len(points)} cells are not allowed: the largest sweep has {MOST_CELLS}")
    making = make_job(file, places, folder, lambda: first_flock(base, points, places))
    making.prepare()
    demand_own_names(points, making, places)
    basis = Basis(making, file.replicates.first)
    cells: list[Cell] = []
    faults: dict[tuple[int, str], str] = {}
    if tell is not None and len(points) > 5000:
        tell(f"checking {len(points)} cells ...")
    for number, (design, point) in enumerate(points, 1):
        try:
            cells.append(basis.cell(spec_with(base, point), point, design))
        except InputError as refusal:
            same = design, str(refusal)
            if same not in faults:
                faults[same] = explain_refusal(str(refusal), design, point, number, places)
            if len(faults) >= MOST_FAULTS:
                break
    if faults:
        raise error_of_lines(list(faults.values()))
    text = places.text or file_text(values)
    sweep = Sweep(file, places, folder, base, making, cells, text)
    check_precision(sweep)
    for record in file.record:
        for cell in cells:
            is_recorded(record, cell)
    if tell is not None:
        tell_redrawn(cells, tell)
    return sweep


def tell_redrawn(cells: list[Cell], tell: Callable[[str], Any]) -> None:
    """Say of the cell where most numbers were drawn again that they were, and of how many more."""
    redrawn = [cell for cell in cells if cell.redrawn]
    if redrawn:
        worst = max(redrawn, key=lambda cell: cell.redrawn)
        more = f" (fewer in {counted(len(redrawn) - 1, 'more cell')})" if redrawn[1:] else ""
        tell(f"flockscope: {worst.warning}{more}")


def explain_refusal(
    refusal: str, design: int, point: Point, number: int, places: KeyLocations
) -> str:
    """A refusal with the place of the axis that it is about, or of the run's own key."""
    word = name_in_refusal(refusal)
    moments = [axis for axis in point if axis.rpartition(".")[0] == word and read_axis(axis).moment]
    word = word if word in point or not moments else moments[0]
    if word in point:
        at = places.describe(word, "design.axes", design)
    else:
        at = places.describe(word, "run" if word in RunOptions.model_fields else "run.parameters")
    point_text = ", ".join(f"{name} = {value!r}" for name, value in point.items())
    return f"{refusal} ({at}; cell {number}: {point_text})" if point_text else f"{refusal} ({at})"


def check_file[File: StrictTable](
    kind: type[File], values: dict[str, Any], places: KeyLocations
) -> File:
    """The file with every key as it may be. Raises InputError naming the line."""
    for axis in values.get("run", {}) if isinstance(values.get("run"), dict) else ():
        if axis == "seed":
            raise InputError(
                "seed: the seeds of a sweep are first and seeds of [replicates] "
                f"({places.describe('seed', 'run')})"
            )
    try:
        return kind(**values)
    except ValidationError as error:
        first = error.errors()[0]
        loc = [part for part in first["loc"] if part not in TAGS]
        keys = [str(part) for part in loc if not isinstance(part, int) and "[" not in str(part)]
        numbers = [part for part in loc if isinstance(part, int)]
        design = numbers[0] if keys[:1] == ["design"] and numbers else None
        where = places.describe(keys[-1] if keys else "", ".".join(keys[:-1]), design)
        cause = first.get("ctx", {}).get("error")
        reason = str(cause) if isinstance(cause, InputError) else needed(first)
        raise InputError(": ".join(filter(None, [".".join(keys), f"{reason} ({where})"]))) from None


TAGS = ("grid", "list", "csv", "latin-hypercube", "sobol", "saltelli", "morris", "Span")
"""What pydantic puts between the keys of a design."""


def base_of(file: SweepFile, places: KeyLocations, folder: Path) -> Spec:
    """The run that all cells share. Raises InputError."""
    run = file.run
    name = run.model
    if name.endswith(".py"):
        name = from_file(str(find_file(name, folder))).name
    world = run.world
    if world is not None and world.endswith(".toml"):
        world = str(find_file(world, folder).absolute())
    options = {key: getattr(run, key) for key in Options.model_fields}
    try:
        for kind in run.kinds:
            if kind.policy:
                known_policy(kind.policy)
        return Spec(
            name,
            agents=run.agents,
            size=run.size,
            dim=run.dim,
            world=world,
            parameters=run.parameters,
            **options,
        ).but(kinds=run.kinds, to=run.to)
    except InputError as refusal:
        where = places.describe(name_in_refusal(str(refusal)), "run")
        raise InputError(f"{refusal} ({where})") from None


def all_points(file: SweepFile, places: KeyLocations, folder: Path) -> Iterator[tuple[int, Point]]:
    """The points of all designs with the number of each; without a design there is one cell."""
    if not file.design:
        yield 0, {}
    for number, design in enumerate(file.design):
        try:
            points = points_of(design, folder)
        except InputError as refusal:
            key = "where" if design.where and repr(design.where) in str(refusal) else "kind"
            at = places.describe(key, "design", number)
            raise InputError(f"{refusal} ({at})") from None
        for axis in points[0] if points else ():
            if axis in ("seed", "parameters", "ticks"):
                where = places.describe(axis, "design.axes", number)
                raise InputError(
                    f"axis {axis!r} is not allowed: it is no parameter or option ({where})"
                )
        yield from ((number, point) for point in points)


def demand_own_names(
    points: list[tuple[int, Point]], making: SweepJob, places: KeyLocations
) -> None:
    """Refuse an axis with the name of another column of the table of runs. Raises InputError."""
    axes = {axis: design for design, point in points for axis in point}
    clash = next((axis for axis in axes if axis in {*HEADS, *making.names}), None)
    if clash is not None:
        where = places.describe(clash, "design.axes", axes[clash])
        raise InputError(
            f"axis {clash!r} is not allowed: the table of runs has another column of that name: "
            f"rename the parameter, or the column ({where})"
        )


def first_flock(base: Spec, points: list[tuple[int, Point]], places: KeyLocations) -> Flock:
    """The flock of the first cell. Raises InputError."""
    design, point = points[0]
    try:
        return Flock(spec_with(base, point).but(seed=1))
    except InputError as refusal:
        raise InputError(explain_refusal(str(refusal), design, point, 1, places)) from None


def make_job(
    file: SweepFile, places: KeyLocations, folder: Path, first: Callable[[], Flock]
) -> SweepJob:
    """How runs are made and measured. Raises InputError."""
    observed = file.observe or default_observe(file, first)
    measures: list[SweepMeasure] = []
    for entry in observed:
        key = "measure" if entry.measure else "name"
        try:
            measures.append(measure_of(entry, folder))
        except InputError as refusal:
            at = places.describe("observe" if "observe" in places.options else key, "observe")
            raise InputError(f"{refusal} ({at})") from None
    twice = [
        measure
        for measure, other in itertools.combinations(measures, 2)
        if measure.column.lower() == other.column.lower()
    ]
    if twice:
        raise InputError(
            f"column {twice[0].column!r} is there twice: give one of them another "
            f"({places.describe('column', 'observe')})"
        )
    for measure in measures:
        if measure.over is not None and measure.over > file.run.ticks:
            raise InputError(
                f"over = {measure.over} is more than ticks = {file.run.ticks}, the ticks that are "
                "run "
                f"({places.describe('over', 'observe')})"
            )
    until = None
    if file.stop is not None:
        where = places.describe("when", "stop")
        try:
            says = comparison(file.stop.when)
            demand_number(says.name)
        except InputError as refusal:
            raise InputError(f"{refusal} ({where})") from None
        until = StopCondition(says, file.stop.hold, file.stop.every)
    return SweepJob(file.run.ticks, tuple(measures), until)


def default_observe(file: SweepFile, first: Callable[[], Flock]) -> list[Observe]:
    """What is observed where nothing is asked for: only when it stops, or what tells of a flock."""
    if file.stop is not None:
        return []
    return [
        Observe(name=name)
        for name in telling_observables(first())
        if not OBSERVABLES[name].is_table
    ]


def check_precision(sweep: Sweep) -> None:
    """Refuse a precision of what is not measured. Raises InputError."""
    precision = sweep.file.replicates.precision
    if precision is not None and precision.observable not in sweep.making.columns:
        where = sweep.places.describe("observable", "replicates.precision")
        raise unknown("column", precision.observable, sweep.making.columns, where)
