"""The curve that a sweep has of a question: found in the stores, or the sweep that makes it."""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tomlkit
from pydantic import ConfigDict, Field, ValidationError

from agents.flock import Flock
from agents.spec import CompleteSpec
from app.classroom.collect.differences import RunIdentity, differences, on_one_line
from app.classroom.collect.hand_in import ResultGroup
from app.classroom.collect.question import Question
from app.classroom.collect.question_choices import spread
from app.classroom.collect.run_cost import look_radius
from app.strict_table import Line, StrictTable
from app.studies.charts.run_group import is_number, varied_axes
from app.studies.key_lines import KeyLocations
from app.studies.run_axes import AGENTS, read_axis
from app.studies.runs.store_reader import StoreReader
from app.studies.sweeps.checked_sweep import Sweep, sweep_of
from app.studies.sweeps.sweep_table import groups_of, places_of, spec_at
from app.viewer.lab.sweeps.stored_sweeps import MOST_SHOWN, named_in
from app.viewer.lab.sweeps.sweep_request import (
    allowed,
    demand,
    most_agents,
    proposed_span,
    run_table,
)
from worlds.input_error import InputError, first_input_error
from worlds.text_file import toml
from worlds.world import World

VALUES = 12
"""Of a curve for a question to which students choose their values."""
TENFOLD = 10.0
"""From this ratio of the ends on its values rise by equal ratios: most happens at small ones."""
RUNS = 20
"""Of each of its values."""
LONGEST, MOST_DIFFERENCES = 500, 100
"""Letters of a line in the file of a curve, and lines on how its runs differ."""
CurveLine = Annotated[Line, Field(min_length=1, max_length=LONGEST)]
FIRST_SEED = 10_001
"""Beyond the seeds that students are given: a curve of the class's own runs would tell nothing."""


@dataclass(frozen=True)
class ClassCurve:
    """Mean and interval of a measure by the value of a parameter, of many runs each."""

    name: str
    """Of the sweep."""
    groups: tuple[ResultGroup, ...]
    """Rising."""
    differs: tuple[str, ...]
    """How its runs are not those of the class's scene, in words."""

    @property
    def values(self) -> list[float]:
        """Of the parameter, rising."""
        return [group.value for group in self.groups]

    @property
    def runs(self) -> int:
        """Runs that it is made of."""
        return sum(group.runs for group in self.groups)

    def to_toml(self) -> str:
        """The curve as the file of a class has it; floats come back to the bit."""
        groups = [
            {
                "value": float(group.value),
                "results": [float(result) for result in group.values],
                "gave_up": group.gave_up,
                "broken": group.broken,
            }
            for group in self.groups
        ]
        return tomlkit.dumps({"sweep": self.name, "differs": list(self.differs), "groups": groups})


class CurveGroupTable(StrictTable):
    """The runs of one value in the file of a curve."""

    model_config = ConfigDict(strict=True)

    value: float
    results: list[float] = Field(max_length=MOST_SHOWN)
    gave_up: int = Field(ge=0, le=MOST_SHOWN)
    broken: int = Field(ge=0, le=MOST_SHOWN)


class CurveTable(StrictTable):
    """The file of a curve."""

    model_config = ConfigDict(strict=True)

    sweep: CurveLine
    differs: list[CurveLine] = Field(max_length=MOST_DIFFERENCES)
    groups: list[CurveGroupTable] = Field(max_length=MOST_SHOWN)


def curve_from_toml(text: str, origin: str) -> ClassCurve:
    """The curve in a text that `to_toml` wrote. Raises InputError."""
    try:
        table = CurveTable(**toml(text, origin))
    except ValidationError as error:
        raise first_input_error(error, origin) from None
    values = [group.value for group in table.groups]
    if values != sorted(set(values)):
        raise InputError(f"{origin}: the values of groups do not rise")
    groups = tuple(
        ResultGroup(one.value, one.value, one.value, tuple(one.results), one.gave_up, one.broken)
        for one in table.groups
    )
    return ClassCurve(table.sweep, groups, tuple(table.differs))


def curve_of(folder: Path, question: Question, scene: CompleteSpec) -> ClassCurve:
    """The curve of a stored sweep. Raises InputError if it is not one of this question."""
    kept, name = StoreReader(folder), folder.name
    state = kept.state
    if state.get("kind") != "sweep" or state.get("runs", 0) > MOST_SHOWN:
        raise InputError(f"{name} is no sweep of at most {MOST_SHOWN:,} runs")
    cells = kept.cells
    demand_same(name, [cell["identity"] for cell in cells.values()], question)
    _, found = groups_of(kept, question.column)
    others = [axis for axis in varied_axes(found) if axis != question.parameter]
    if others:
        raise InputError(f"{name} is swept over {others[0]} too")
    if not all(is_number(one.axes.get(question.parameter)) for one in found):
        raise InputError(f"{name} is not swept over {question.parameter}")
    groups = []
    for one in sorted(found, key=lambda one: float(one.axes[question.parameter])):
        value = float(one.axes[question.parameter])
        results = tuple(one.values)
        groups.append(ResultGroup(value, value, value, results, one.gave_up, one.broken))
    place = places_of(kept)[found[0].number]
    spec = spec_at(kept, place, 1)
    meant = question.with_value(scene.with_values(seed=1), float(found[0].axes[question.parameter]))
    differs = differences(
        RunIdentity.of(Flock(spec)), RunIdentity.of(Flock(meant)), [question.parameter]
    )
    return ClassCurve(on_one_line(name, LONGEST), tuple(groups), differs)


def demand_same(name: str, identities: Sequence[dict[str, Any]], question: Question) -> None:
    """Refuse a sweep of another model, or that measures something else. Raises InputError."""
    making = question.making
    until = making.until and [*making.until.says, making.until.hold, making.until.every]
    measured = [[one.column, one.name, one.every, one.over] for one in making.measures]
    for identity in identities:
        if identity["spec"]["model"] != question.model:
            raise InputError(f"{name} is not a sweep of {question.model}")
        if identity["ticks"] != making.ticks or identity["stop"] != until:
            raise InputError(
                f"{name} has other runs than {question.ticks} ticks, or stops otherwise"
            )
        if not all(one in identity["observe"] for one in measured):
            raise InputError(f"{name} does not measure {question.column}")


def find_curve(results: Path, question: Question, scene: CompleteSpec) -> ClassCurve | None:
    """The curve of the newest stored sweep of a question, one like the class's scene before others.

    It reads stores, which takes a while: not on every look.
    """
    found: list[ClassCurve] = []
    for name in named_in(results):
        try:
            found.append(curve_of(results / name, question, scene))
        except (InputError, OSError, KeyError, ValueError, sqlite3.Error):
            continue
    return min(found, key=lambda one: len(one.differs), default=None)


@dataclass(frozen=True)
class CurveAsked:
    """The sweep that makes the curve of a question, as the laboratory's sweeps are begun."""

    question: Question
    scene: CompleteSpec
    runs: int = RUNS

    @property
    def name(self) -> str:
        """What its folder is called, if there is none of that name yet."""
        return f"{self.question.model}-{self.question.parameter}"

    def axis(self) -> list[float]:
        """The values that are run: those given, or some over the range that a slider spans."""
        question = self.question
        if question.values:
            return [round(one) if question.is_whole else one for one in question.values]
        if question.parameter == AGENTS:
            (low, high), now = allowed(question.model, AGENTS), question.value_of(self.scene)
            low, high = max(low, now / 4), min(high, 4 * now)
        else:
            axis = read_axis(question.parameter, question.model_of(question.parameter))
            low, high = proposed_span(self.scene, axis, look_radius(self.scene))
        made = spread(low, high, VALUES, question.is_whole, log=0.0 < TENFOLD * low <= high)
        return [round(one) if question.is_whole else one for one in made]

    def values(self) -> dict[str, Any]:
        """What a sweep's file says, world.toml beside it. Raises InputError beyond a page's
        bounds."""
        question, axis = self.question, self.axis()
        agents = most_agents(self.scene, {question.parameter: axis})
        demand(len(axis), self.runs, agents, question.ticks)
        said: dict[str, Any] = {
            "title": question.title,
            "run": run_table(self.scene, question.ticks, {question.parameter}),
        }
        one = question.measure
        if one.until:
            said["stop"] = {"when": one.until, "hold": one.hold}
        said["design"] = [{"kind": "grid", "axes": {question.parameter: axis}}]
        said["replicates"] = {"count": self.runs, "first": FIRST_SEED}
        if one.observe:
            over = {"over": one.over} if one.over else {}
            said["observe"] = [{"name": one.observe} | over]
        return said

    def to_toml(self) -> str:
        """The file, for `flockscope sweep run FILE.toml`. Raises InputError."""
        return tomlkit.dumps(self.values())

    def world(self) -> str:
        """What stands in world.toml; nothing where the world is a built-in one."""
        return self.scene.world.to_toml() if isinstance(self.scene.world, World) else ""

    def sweep(self, folder: Path) -> Sweep:
        """The sweep, every cell of it checked; world.toml is looked for in a folder. Or
        InputError."""
        return sweep_of(self.values(), KeyLocations(self.name), folder)
