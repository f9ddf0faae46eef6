"""The runs of a laboratory, kept as in a notebook: each is a row that one may name, lay under the
plots, open again and take along.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

from agents.models.model import Model
from agents.observables.catalogue import OBSERVABLES
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.observable_curves import ObservableHistory
from app.viewer.measuring.observable_table import TICKS, observable_title, value_of
from app.viewer.measuring.run_conditions import BY_HAND
from worlds.input_error import InputError

MOST_RUNS = 500
"""Runs that are kept; of more, the oldest leave the list."""
MOST_SHOWN = 3
"""Runs of one model that are laid under its plots; of more, the oldest are left out."""
LONGEST_NAME = 60
"""Letters of a run's name."""


@dataclass(frozen=True, eq=False)
class KeptRun:
    """A run that is over."""

    number: int
    """From 1 on, in the order in which they ended."""
    course: ObservableHistory
    name: str = ""
    is_shown: bool = False
    """Whether it is laid under the plots."""

    @property
    def model(self) -> Model:
        """Its model."""
        return self.course.conditions.model

    @property
    def label(self) -> str:
        """What it is called, as no other is."""
        return f"run {self.number}{f', {self.name}' if self.name else ''}"

    @property
    def ticks(self) -> int:
        """How long it was."""
        return self.course.tick - self.course.history.stretches[0].begin

    @cached_property
    def measures(self) -> dict[str, float]:
        """What each observable came to at the end, by name."""
        return {name: float(values[-1]) for name, (_, values) in self.course.curves.items()}


class RunStorage(Protocol):
    """Where runs are written down as they end, and what is changed of them."""

    def add(self, run: KeptRun) -> None: ...
    def change(self, run: KeptRun) -> None: ...
    def delete(self, number: int) -> None: ...


class KeptRuns:
    """Keeps runs that are over; the latest is laid under the plots by itself, if `lays_last`.

    A run that repeats another one to the bit (seed, parameters and all that was changed) has the
    row of that one, and is the longer of the two. Any thread may call it.
    """

    def __init__(self, rows: Sequence[KeptRun] = (), storage: RunStorage | None = None) -> None:
        self.rows: tuple[KeptRun, ...] = tuple(rows)
        """The latest first; replaced as a whole."""
        self.storage = storage
        self.going: tuple[FlockReadings, ...] = ()
        self.next = 1 + max((run.number for run in rows), default=0)
        """The number of the next row."""
        self.lays_last = True
        self.laid: set[int] = set()
        """Numbers of those that were laid under the plots by themselves."""
        self.dropped = 0
        """Rows that have left the list because there were too many."""
        self.lock = threading.RLock()

    def follow(self, runs: Sequence[FlockReadings]) -> None:
        """Keep those that went on until now and do so no more; `runs` do."""
        for run in self.going:
            if all(run is not now for now in runs):
                self.keep(ObservableHistory.of(run))
        self.going = tuple(runs)

    def close(self) -> None:
        """Keep those that go on: the laboratory ends."""
        self.follow(())

    def keep(self, course: ObservableHistory) -> None:
        """Keep a run, if there is anything to be seen of it."""
        if not any(len(at) > 1 for at, _ in course.curves.values()):
            return
        course = course.at_end()
        with self.lock:
            same = self.same_as(course)
            if same is not None:
                longer = course if course.tick >= same.course.tick else same.course
                kept = replace(same, course=longer)
                self.rows = (kept, *(run for run in self.rows if run is not same))
                if longer is course and self.storage is not None:
                    self.storage.add(kept)
            else:
                kept = KeptRun(self.next, course)
                self.add(kept)
            if self.lays_last:
                self.lay_last(kept)

    def same_as(self, course: ObservableHistory) -> KeptRun | None:
        """The run of which another one is a repetition."""
        for run in self.rows:
            if run.model is course.conditions.model and run.course.history == course.history:
                return run
        return None

    def add(self, run: KeptRun) -> None:
        """Add a row, and write it down."""
        with self.lock:
            self.next = max(self.next, run.number + 1)
            self.dropped += max(0, len(self.rows) + 1 - MOST_RUNS)
            self.rows = (run, *self.rows)[:MOST_RUNS]
            if self.storage is not None:
                self.storage.add(run)

    def take(self, others: Sequence[KeptRun]) -> None:
        """Add the runs of a file, oldest first, with numbers that follow ours."""
        with self.lock:
            for run in sorted(others, key=lambda run: run.number):
                self.add(replace(run, number=self.next, is_shown=False))

    def lay_last(self, last: KeptRun) -> None:
        """Lay a run under the plots in the place of its model's that lay there by itself."""
        mine = {run.number for run in self.rows if run.model is last.model}
        before = self.laid & mine
        self.laid = (self.laid - before) | {last.number}
        self.rows = tuple(
            replace(run, is_shown=run.number == last.number)
            if run.number in before | {last.number}
            else run
            for run in self.rows
        )

    def find(self, number: int) -> KeptRun:
        """A run by its number. Raises InputError."""
        for run in self.rows:
            if run.number == number:
                return run
        raise InputError(f"there is no run {number}: it has been deleted")

    def put(self, run: KeptRun) -> None:
        """Put a run in the place of the one of its number."""
        self.rows = tuple(run if old.number == run.number else old for old in self.rows)

    def show(self, number: int, is_shown: bool) -> None:
        """Lay a run under the plots, or do so no more. Raises InputError."""
        with self.lock:
            self.laid.discard(number)
            self.put(replace(self.find(number), is_shown=is_shown))

    def rename(self, number: int, name: str) -> None:
        """Give a run a name; empty: none. Raises InputError."""
        name = " ".join(name.split())
        if len(name) > LONGEST_NAME or not name.isprintable():
            raise InputError(f"name = {name[:80]!r} is not allowed: at most {LONGEST_NAME} letters")
        with self.lock:
            run = replace(self.find(number), name=name)
            self.put(run)
            if self.storage is not None:
                self.storage.change(run)

    def delete(self, number: int) -> None:
        """Keep a run no more. Raises InputError."""
        with self.lock:
            gone = self.find(number)
            self.rows = tuple(run for run in self.rows if run is not gone)
            if self.storage is not None:
                self.storage.delete(number)

    def runs_of(self, model: Model) -> list[KeptRun]:
        """The runs of a model, the latest first."""
        return [run for run in self.rows if run.model is model]

    def shown_of(self, model: Model) -> list[KeptRun]:
        """Those of a model that are laid under its plots, the latest first."""
        return [run for run in self.runs_of(model) if run.is_shown][:MOST_SHOWN]


# What tells runs apart, and all of them as one table.


def differing_names(runs: Sequence[KeptRun]) -> list[str]:
    """What differs among runs, or was changed in one of them: seed, world, agents, parameters."""
    histories = [run.course.history for run in runs]
    names = dict.fromkeys(name for history in histories for name in history.steps)
    return [
        name
        for name in names
        if any(len(history.steps.get(name, ())) > 1 for history in histories)
        or any(first_value(run, name) != first_value(runs[0], name) for run in runs[1:])
    ]


def first_value(run: KeptRun, name: str) -> object:
    """The value with which a run began."""
    steps = run.course.history.steps.get(name)
    return None if steps is None else steps[0][1]


def runs_table(runs: Sequence[KeptRun]) -> dict[str, list[object]]:
    """All runs as columns, a row for each in the order of their numbers.

    Conditions are those with which a run began; `changed` says what was changed while it ran.
    Observables are what they came to at its end; nothing where a run was not measured so.
    """
    runs = sorted(runs, key=lambda run: run.number)
    models = [run.model for run in runs]
    conditions = [
        name
        for name in dict.fromkeys(n for run in runs for n in run.course.conditions.values)
        if name not in ("seed", "agents", "world", BY_HAND)
    ]
    names = dict.fromkeys([*OBSERVABLES, *(name for run in runs for name in run.measures)])
    measured = [name for name in names if any(name in run.measures for run in runs)]
    table: dict[str, list[object]] = {
        "run": [run.number for run in runs],
        "name": [run.name for run in runs],
        "model": [model.name for model in models],
        "seed": [run.course.conditions.seed for run in runs],
        "agents": [run.course.conditions.agents for run in runs],
        "world": [run.course.conditions.world.name for run in runs],
        "ticks": [run.ticks for run in runs],
    }
    for unit in dict.fromkeys(run.course.conditions.unit for run in runs):
        if unit != TICKS:
            table[f"time ({unit})"] = [
                run.ticks * run.course.conditions.dt if run.course.conditions.unit == unit else None
                for run in runs
            ]
    for name in conditions:
        key = f"parameter {name}" if name in table else name
        table[key] = [value_of(run.course.conditions.values, name) for run in runs]
    table["changed"] = [", ".join(run.course.history.changes()) for run in runs]
    for name in measured:
        title = observable_title(name, models)
        table[title if title not in table else f"observable {title}"] = [
            run.measures.get(name) for run in runs
        ]
    return table
