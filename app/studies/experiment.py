"""A table or a figure of a paper as cases to run, and the flock of a case."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Literal

import numpy as np

from agents import Flock
from agents.spec import Spec
from app.strict_table import Value
from app.studies.experiment_file import (
    PLAIN,
    START,
    DeclaredClaim,
    ExpectedVerdict,
    Overrides,
    PaperRow,
    PaperSweep,
    PublishedMeasure,
    with_goal,
)
from app.studies.measure import Measure, Settings
from app.studies.run_axes import value_of
from worlds.input_error import unknown
from worlds.layout import world as build_world
from worlds.world import World
from worlds.world_rotation import rotate_places, rotate_world

Way = Literal["", "there", "back"]


@dataclass(frozen=True)
class Case:
    """Runs that differ by their seed only, and where in the paper they are from."""

    spec: Spec
    """The run, but for its seed and for what its row overrides of the world."""
    agents: int
    """N as the paper counts it."""
    row: PaperRow | None = None
    sweep: PaperSweep | None = None
    way: Way = ""
    """Which way a run that goes there and back is going here."""
    tick: int | None = None
    """The tick at which a run that is measured several times is measured here."""
    last: bool = True
    """Whether it is the last of them, which is compared with what was published."""

    @property
    def label(self) -> str:
        """Its name in a table."""
        of = self.row or self.sweep
        return (of.label if of else "") or self.spec.model

    @property
    def own_sweep(self) -> PaperSweep:
        """The sweep that it is a point of. Raises ValueError for a row of a table."""
        if self.sweep is None:
            raise ValueError(f"{self.label} is no point of a sweep")
        return self.sweep

    @property
    def value(self) -> Value | None:
        """The value of the swept parameter or option."""
        return value_of(self.spec, self.sweep.parameter) if self.sweep else None

    @property
    def at(self) -> Value | None:
        """The value of the second parameter of a sweep that has two."""
        two = self.sweep is not None and self.sweep.against
        return value_of(self.spec, two) if two else None

    def published(self, measure: str) -> PublishedMeasure | None:
        """What the paper prints of a measure."""
        return self.row.published.get(measure) if self.row and self.last else None


@dataclass(frozen=True)
class Experiment:
    """A table or a figure as cases to run."""

    name: str
    title: str
    source: str
    picture: str
    runs: int
    settings: Settings
    measures: list[Measure]
    """Those to report, the main one first."""
    expected: dict[str, ExpectedVerdict]
    not_compared: dict[str, str]
    notes: dict[str, str]
    cases: list[Case]
    said: list[DeclaredClaim]
    """What the paper claims."""

    @property
    def paths(self) -> list[list[int]]:
        """The cases, by number, that each run goes through.

        One, or those of a sweep there and back, or a row's at all of its ticks.
        """
        groups: list[list[int]] = []
        for k, case in enumerate(self.cases):
            last = self.cases[groups[-1][-1]] if groups else None
            if last is not None and continues_run(last, case):
                groups[-1].append(k)
            else:
                groups.append([k])
        return groups

    def select(self, models: list[str], agents: list[int]) -> Experiment:
        """Only some models (or labels) and sizes; empty lists keep all.

        Raises InputError for unknown ones.
        """
        named = {name for case in self.cases for name in (case.spec.model, case.label)}
        for kind, requested, available in (
            ("model", models, named),
            ("agents", agents, {case.agents for case in self.cases}),
        ):
            for value in requested:
                if value not in available:
                    names = [str(name) for name in sorted(available)]
                    raise unknown(kind, str(value), names, self.name)
        kept_cases = [
            case
            for case in self.cases
            if (not models or case.spec.model in models or case.label in models)
            and (not agents or case.agents in agents)
        ]
        return replace(self, cases=kept_cases)


def continues_run(last: Case, case: Case) -> bool:
    """Whether a case is the next of the same run."""
    if case.tick is not None:
        return last.row is case.row and last.tick is not None and last.tick < case.tick
    same = last.sweep is case.sweep and (last.agents, last.at) == (case.agents, case.at)
    return case.way != "" and same and (last.way, case.way) != ("back", "there")


def flock_of(case: Case, seed: int) -> Flock:
    """The flock of a case at tick 0. Raises InputError."""
    spec, row = case.spec.but(seed=seed), case.row
    overrides = row.mission if row else PLAIN
    if spec.size is None:
        is_bare = row is not None and not row.obstacles
        name = overrides.scene or spec.world
        spec = spec.but(world=world_of(name, spec.dim, is_bare, overrides))
    if overrides.turned:
        return make_rotated_flock(spec)
    return Flock(spec, start=overrides.ranks.start(case.agents, seed) if overrides.ranks else None)


def make_rotated_flock(spec: Spec) -> Flock:
    """The flock of one start in a scene that the seed turns. Raises InputError."""
    flock = Flock(spec.but(seed=START))
    rng = np.random.default_rng(spec.seed)
    angle = float(rng.uniform(0.0, 360.0))
    middle = np.array(flock.world.low) + 0.5 * np.array(flock.world.size)
    start = {
        "position": rotate_places(flock.position, angle, middle),
        "heading": rotate_places(flock.heading, angle, np.zeros(2)),
        "speed": flock.speed,
        "informed": flock.informed,
    }
    return Flock(spec.but(world=rotate_world(flock.world, angle, rng)), start=start)


@cache
def world_of(name: str, dim: int | None, is_bare: bool, overrides: Overrides) -> World:
    """The world of a layout in the layout's own size; `is_bare` without its obstacles.

    Raises InputError if the overrides change a part of the mission that the world does not have.
    """
    world = with_goal(build_world(name, dim), overrides)
    return replace(world, obstacles=(), random=None) if is_bare else world
