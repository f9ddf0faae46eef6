"""One run of an experiment: a flock from its start to what the experiment waits for."""

from __future__ import annotations

import hashlib
import inspect
import json
import math
import time
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from agents import Flock
from agents.engine.cache import fingerprint as feed
from agents.spec import Spec, versions
from app.studies.experiment import Case
from app.studies.kinds import Settings
from app.studies.kinds.kind_settings import Number
from app.studies.overrides import PLAIN, START, Overrides, with_goal
from app.studies.runs.database import FIXED
from app.studies.runs.run_outcome import Outcome
from worlds.layout import world
from worlds.world import World
from worlds.world_rotation import turned, turned_places


@dataclass(frozen=True)
class Trial:
    """What makes a run: its cases and its seed.

    There are several cases where the run goes through several values of a parameter, in that order.
    """

    cases: tuple[Case, ...]
    seed: int


@dataclass(frozen=True)
class Result:
    """What a run has given in one of its cases."""

    measures: dict[str, Number | None]
    """By name; None where the run has none, such as k_con of a run that was given up."""
    seconds: float
    astray: str = ""
    """The first agent that was seen where it cannot be, in words; empty if none was."""


def flock_of(case: Case, seed: int) -> Flock:
    """The flock of a case at tick 0. Raises InputError."""
    spec, row = case.spec.but(seed=seed), case.row
    overrides = row.mission if row else PLAIN
    if spec.size is None:
        bare = row is not None and not row.obstacles
        name = overrides.scene or spec.world
        spec = spec.but(world=world_of(name, spec.dim, bare, overrides))
    if overrides.turned:
        return turned_flock(spec)
    return Flock(spec, start=overrides.ranks.start(case.agents, seed) if overrides.ranks else None)


def turned_flock(spec: Spec) -> Flock:
    """The flock of one start in a scene that the seed turns. Raises InputError."""
    flock = Flock(spec.but(seed=START))
    rng = np.random.default_rng(spec.seed)
    angle = float(rng.uniform(0.0, 360.0))
    middle = np.array(flock.world.low) + 0.5 * np.array(flock.world.size)
    start = {
        "position": turned_places(flock.position, angle, middle),
        "heading": turned_places(flock.heading, angle, np.zeros(2)),
        "speed": flock.speed,
        "informed": flock.informed,
    }
    return Flock(spec.but(world=turned(flock.world, angle, rng)), start=start)


@cache
def world_of(name: str, dim: int | None, bare: bool, overrides: Overrides) -> World:
    """The world of a layout in the layout's own size; `bare` without its obstacles.

    Raises InputError if the overrides change a part of the mission that the world does not have.
    """
    found = with_goal(world(name, dim), overrides)
    return replace(found, obstacles=(), random=None) if bare else found


def run_trial(trial: Trial, settings: Settings) -> list[Result]:
    """Run a flock to the end of each of its cases."""
    begun = time.perf_counter()
    flock = flock_of(trial.cases[0], trial.seed)
    astray: list[str] = []

    def look() -> None:
        found = None if astray else flock.stray()
        if found is not None:
            astray.append(str(found))

    results: list[Result] = []
    for case in trial.cases:
        if results:  # it has begun with the parameters of the first
            flock.set(**case.spec.parameters)
        measures = settings.run(flock, look)
        ended = time.perf_counter()
        look()
        results.append(Result(measures, ended - begun, "".join(astray)))
        begun = ended
    return results


NAN = "nan"
"""What stands for nan in a store, where SQLite would keep nothing."""


@dataclass(frozen=True)
class Trials:
    """How the runs of an experiment are made; one is asked for by the number of its path."""

    paths: tuple[tuple[Case, ...], ...]
    settings: Settings

    def prepare(self) -> None:
        """There is nothing to prepare."""

    def run(self, path: int, seed: int) -> Outcome:
        """Make a run; what it gave in its later cases is the rest."""
        results = run_trial(Trial(self.paths[path], seed), self.settings)
        first, *rest = [outcome_of(one) for one in results]
        return first._replace(rest=tuple(rest))


def column_of(measure: str) -> str:
    """The column of a measure in the store, where another may have its name already."""
    return f"{measure}_measured" if measure in FIXED else measure


def outcome_of(result: Result) -> Outcome:
    """A result as the store keeps it."""
    measures = {
        column_of(name): NAN if isinstance(value, float) and math.isnan(value) else value
        for name, value in result.measures.items()
    }
    return Outcome("ok", measures, seconds=result.seconds, astray=result.astray)  # type: ignore[arg-type]


def result_of(outcome: Outcome, settings: Settings) -> Result:
    """What the store kept as a result."""
    found = {one.name: outcome.values[column_of(one.name)] for one in settings.measures}
    measures = {name: math.nan if one == NAN else one for name, one in found.items()}
    return Result(measures, outcome.seconds, outcome.astray)


def fingerprint(case: Case, settings: Settings) -> str:
    """A hash of what a case's numbers depend on beside model, agents, parameters and seed.

    The world and the criterion, the way that a run has come, the versions, the compiled loop with
    all that it reaches, what measures it, and how a flock starts.
    """
    flock = flock_of(case, 0)
    shared = settings.model_dump(exclude={"parameters", "words"}) | {"size": case.spec.size}
    if case.sweep and case.way:
        shared |= {"way": case.way, "values": case.sweep.values}
    if case.tick is not None:
        shared |= {"tick": case.tick}
    if case.row and case.row.mission != PLAIN:
        shared |= {"mission": case.row.mission.model_dump()}
    shared |= case.spec.chosen
    digest = hashlib.sha256(json.dumps([shared, versions()], sort_keys=True).encode())
    digest.update(json.dumps(flock.parameters.model_dump(), sort_keys=True).encode())
    digest.update(inspect.getsource(type(settings)).encode())
    digest.update(flock.loop.cache_folder.name.encode())
    seen: set[int] = set()
    for kernel in settings.measured_by:
        feed(kernel, digest, seen)
    for array in flock.engine.surroundings:
        digest.update(np.asarray(array).tobytes())
    digest.update(flock.position.tobytes())
    digest.update(flock.heading.tobytes())
    return digest.hexdigest()[:12]
