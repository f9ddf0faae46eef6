"""The file in which a laboratory writes down its runs, and from which it reads them again.

It is text, a JSON object a line, and is only ever added to: a run as it ends, its new name, that it
was deleted. So a kill loses at most the run that was going on, and two laboratories may share one.
"""

from __future__ import annotations

import errno
import json
import os
import secrets
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from agents.catalogue import model as find_model
from agents.flock_world import find_world, is_built_in
from agents.individuals import Distribution, split_individuals
from agents.kinds import as_kinds, kind_table
from agents.models.declare import checked
from agents.motion.motion import demand_kinds
from agents.observables.catalogue import is_observable
from agents.spec import CompleteSpec, relations, values_of, values_of_kinds
from app.results_folder import demand_runs
from app.viewer.gallery.saved_scene import scene_of
from app.viewer.measuring.kept_runs import LONGEST_NAME, MOST_RUNS, KeptRun
from app.viewer.measuring.observable_curves import ObservableHistory, Points
from app.viewer.measuring.run_conditions import (
    MOST,
    SEVERAL,
    ConditionHistory,
    RunConditions,
    Stretch,
)
from worlds.input_error import InputError, shorten
from worlds.number_text import counted
from worlds.world import World

FORMAT = 1
HEAD = {"flockscope": "runs", "format": FORMAT}
"""The first line of a file."""
LARGEST = 256 * 2**20
"""Bytes of a file of this machine that are read."""
MOST_POINTS = 5_000
"""Points of a curve."""
DIGITS = 9
"""Figures of a value that are written down."""


def line_of(values: Mapping[str, Any]) -> bytes:
    """A line of the file."""
    return json.dumps(values, separators=(", ", ": ")).encode() + b"\n"


def spec_of(one: RunConditions) -> CompleteSpec:
    """The run that begins under some conditions; a start that was given is a random one.

    To see whether the name of a world is enough takes up to a tenth of a second.
    """
    world, sides = one.world, set(one.world.size)
    where: dict[str, Any] = {"world": world, "size": None}
    if len(sides) == 1 and is_built_in(world, one.seed):
        where = {"world": world.name, "size": float(world.size[0])}
    values = {name: value for name, value in one.parameters.items() if value is not SEVERAL}
    kinds = {"kinds": one.kinds.kinds, "to": one.kinds.to}
    return one.asked.with_parameters(
        values, **where, **kinds, layout=None, dim=world.dim, start="random", versions={}
    )


def run_values(run: KeptRun, key: str) -> dict[str, Any]:
    """A run as JSON has it; `key` says which it is, whatever its number."""
    history = run.course.history
    stretches: list[dict[str, Any]] = []
    world: World | None = None
    for stretch in history.stretches:
        one = stretch.conditions
        row: dict[str, Any] = {"begin": stretch.begin}
        if one.world != world:  # the first has its spec so, which says everything else too
            row["spec"] = tomllib.loads(spec_of(one).to_toml())
            row["world"] = one.world.name  # a scene calls it otherwise where it is built in
            world = one.world
        parameters = {
            name: value.to_value() if isinstance(value, Distribution) else value
            for name, value in one.parameters.items()
        }
        row |= {"agents": one.agents, "parameters": parameters, "by hand": one.by_hand}
        if one.kinds.kinds:
            row["kinds"] = values_of_kinds(one.kinds.kinds)
            row["to"] = values_of(one.kinds.to)
        stretches.append(row)
    curves = {
        name: [rounded(at), rounded(values)] for name, (at, values) in run.course.curves.items()
    }
    return {
        "key": key,
        "run": run.number,
        "name": run.name,
        "tick": run.course.tick,
        "dt": run.course.conditions.dt,
        "stretches": stretches,
        "curves": curves,
    }


def rounded(values: np.ndarray) -> list[float]:
    """Numbers in so many figures, whole ones without a point."""
    numbers = (float(f"{value:.{DIGITS}g}") for value in values.tolist())
    return [int(number) if number.is_integer() else number for number in numbers]


def runs_as_bytes(runs: Iterable[KeptRun]) -> bytes:
    """A whole file of runs."""
    oldest_first = sorted(runs, key=lambda run: run.number)
    lines = (line_of(run_values(run, secrets.token_hex(8))) for run in oldest_first)
    return line_of(HEAD) + b"".join(lines)


@dataclass(frozen=True)
class ReadRuns:
    """What was found in a file."""

    runs: tuple[KeptRun, ...]
    """The latest first."""
    keys: Mapping[int, str]
    """By number, how the file calls a run."""
    skipped: tuple[str, ...] = ()
    """What was left out, and why."""

    def told(self, name: str) -> str:
        """What was read of a file, and what was left out, in a line."""
        said = f"{counted(len(self.runs), 'run')} of {name}"
        if not self.skipped:
            return f"{said}: see Runs."
        more = f" (and {len(self.skipped) - 1} more)" if len(self.skipped) > 1 else ""
        return f"{said}; left out: {self.skipped[0]}{more}"


def read_runs(name: str, data: bytes) -> ReadRuns:
    """The runs in the bytes of a file, whoever wrote it. Raises InputError.

    What cannot be read of it is left out and told: a line that was cut as the computer died, a run
    of a model that is not here.
    """
    lines = data.split(b"\n")
    head = parsed(lines[0])
    if not isinstance(head, dict) or head.get("flockscope") != "runs":
        raise InputError(f"{name} is no file of runs: its first line says what it is")
    if head.get("format") != FORMAT:
        raise InputError(
            f"{name} has the format {shorten(head.get('format'))}: this flockscope reads {FORMAT}"
        )
    rows: dict[str, dict[str, Any]] = {}
    skipped: list[str] = []
    for number, line in enumerate(lines[1:], 2):
        if not line.strip():
            continue
        row = parsed(line)
        key = row.get("key") if isinstance(row, dict) else None
        if not isinstance(row, dict) or not isinstance(key, str) or len(key) > 64:
            if row != HEAD:  # another laboratory may have begun the file at the same time
                skipped.append(f"line {number} is damaged")
        elif row.get("deleted"):
            rows.pop(key, None)
        elif "stretches" in row:
            rows[key] = row
        elif key in rows:
            rows[key]["name"] = row.get("name")
    if len(rows) > MOST_RUNS:
        skipped.append(f"{len(rows) - MOST_RUNS} older runs: {MOST_RUNS} are listed")
    runs: list[KeptRun] = []
    keys: dict[int, str] = {}
    for key, row in list(rows.items())[-MOST_RUNS:]:
        try:
            run = run_of(row, len(runs) + 1, name)
        except InputError as refusal:
            skipped.append(f"run {shorten(row.get('run'))}: {refusal}")
            continue
        runs.append(run)
        keys[run.number] = key
    return ReadRuns(tuple(reversed(runs)), keys, tuple(skipped))


def parsed(line: bytes) -> Any:
    """A line as JSON, None if it is none."""
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None


def run_of(row: Mapping[str, Any], number: int, origin: str) -> KeptRun:
    """A run of its values, under another number. Raises InputError."""
    stretches, curves = row.get("stretches"), row.get("curves")
    if not isinstance(stretches, list) or not 1 <= len(stretches) <= MOST:
        raise InputError(f"stretches is no list of 1 to {MOST} entries")
    name = name_of(row, "name")
    dt = read_number(row, "dt", above=0.0)
    made: list[Stretch] = []
    for one in stretches:
        if not isinstance(one, dict):
            raise InputError("a stretch is no object")
        made.append(stretch_of(one, made[-1] if made else None, dt, origin))
    history = ConditionHistory(tuple(made))
    tick = int(read_number(row, "tick"))
    return KeptRun(number, ObservableHistory(history, tick, curves_of(curves)), name)


def stretch_of(one: Mapping[str, Any], before: Stretch | None, dt: float, origin: str) -> Stretch:
    """A stretch of its values and of what was before it. Raises InputError."""
    values = one.get("spec")
    if before is None or values is not None:
        if not isinstance(values, dict):
            raise InputError("the first stretch has no spec")
        spec = scene_of({"run": values}, origin).spec
        world = replace(find_world(spec, find_model(spec.model)), name=name_of(one, "world"))
    else:
        spec, world = before.conditions.asked, before.conditions.world
    begin = int(read_number(one, "begin"))
    if before is not None and (begin <= before.begin or spec.model != before.conditions.model.name):
        raise InputError(f"begin = {begin} is not allowed: it follows {before.begin}")
    return Stretch(begin, conditions_of(one, spec, world, dt))


def conditions_of(
    one: Mapping[str, Any], spec: CompleteSpec, world: World, dt: float
) -> RunConditions:
    """The conditions of a stretch. Raises InputError."""
    model, given = find_model(spec.model), one.get("parameters")
    if not isinstance(given, dict):
        raise InputError("parameters is no object")
    known = {name: value for name, value in given.items() if value is not SEVERAL}
    shared, individuals = split_individuals(known)
    parameters = checked(model.parameters, shared).model_dump() | individuals
    parameters |= {name: SEVERAL for name, value in given.items() if value is SEVERAL}
    kinds = kind_table(as_kinds(one.get("kinds", [])), relations(one.get("to", {})))
    demand_kinds(model, checked(model.parameters, shared), kinds, spec, world.dim)
    return RunConditions(
        model,
        spec.seed,
        int(read_number(one, "agents")),
        world,
        spec.chosen,
        parameters,
        dt,
        spec,
        one.get("by hand") is True,
        kinds,
    )


def name_of(values: Mapping[str, Any], key: str) -> str:
    """A short text. Raises InputError."""
    name = values.get(key) or ""
    if not isinstance(name, str) or len(name) > LONGEST_NAME or not name.isprintable():
        raise InputError(f"{key} = {shorten(name)} is no text of at most {LONGEST_NAME} letters")
    return name


def read_number(values: Mapping[str, Any], key: str, above: float = -1.0) -> float:
    """A finite number above another one. Raises InputError."""
    value = values.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not above < value < 1e15:
        raise InputError(f"{key} = {shorten(value)} is no number that a run can have")
    return float(value)


def curves_of(values: Any) -> dict[str, Points]:
    """The curves of a run by observable; those that are not known here are left out. Raises
    InputError."""
    if not isinstance(values, dict):
        raise InputError("curves is no object")
    curves = {}
    for name, pair in values.items():
        if not is_observable(name):
            continue
        try:
            at, points = (np.array(column, float) for column in pair)
        except (ValueError, TypeError):
            raise InputError(f"the curve of {name} is no two lists of numbers") from None
        same = at.ndim == points.ndim == 1 and len(at) == len(points) <= MOST_POINTS
        if not same or not np.isfinite(points).all() or not np.all(np.diff(at) > 0):
            raise InputError(f"the curve of {name} is none: ticks that grow, and a value for each")
        if len(at):
            curves[name] = at, points
    return curves


class RunsFile:
    """A file of runs: those that are in it, and where runs are written down as they end.

    What cannot be written is told once, and nothing is written any more. Raises InputError for what
    is there and cannot be read.
    """

    def __init__(self, path: Path):
        self.path = path
        self.tell: Callable[[str], object] = lambda _: None
        self.failed = False
        self.found = ReadRuns((), {})
        """What was there."""
        demand_runs(path)
        if path.exists():
            if path.stat().st_size > LARGEST:
                raise InputError(
                    f"runs {str(path)!r} has more than {LARGEST:,} bytes: name another file"
                )
            if data := path.read_bytes():
                self.found = read_runs(str(path), data)
        self.keys = dict(self.found.keys)

    def add(self, run: KeptRun) -> None:
        """Write down a run."""
        key = self.keys.setdefault(run.number, secrets.token_hex(8))
        self.write(run_values(run, key))

    def change(self, run: KeptRun) -> None:
        """Write down what a run is called."""
        self.write({"key": self.keys[run.number], "name": run.name})

    def delete(self, number: int) -> None:
        """Write down that a run was deleted."""
        self.write({"key": self.keys.pop(number), "deleted": True})

    def write(self, values: Mapping[str, Any]) -> None:
        """Add a line; one call of the system, so that lines of two laboratories do not mix."""
        if self.failed:
            return
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            line = line_of(values)
            with open(self.path, "a+b", buffering=0) as file:
                size = file.seek(0, os.SEEK_END)
                if not size:
                    line = line_of(HEAD) + line
                else:
                    file.seek(size - 1)
                    if file.read(1) != b"\n":
                        line = b"\n" + line  # what was before was cut by a kill
                if file.write(line) != len(line):
                    raise OSError(errno.ENOSPC, "the disk is full")
        except (OSError, ValueError) as error:
            self.failed = True
            reason = getattr(error, "strerror", None) or error
            self.tell(f"The runs are kept no more in {self.path}: {reason}")
