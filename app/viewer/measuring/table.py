"""What was measured of runs as one table, a row for each of their ticks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from agents.models.model import Model
from agents.observables.catalogue import OBSERVABLES
from app.viewer.measuring.course import Course
from app.viewer.measuring.measured import words

TICKS = "ticks"
"""The unit of time of a model that only counts ticks."""


def unit(name: str, models: Iterable[Model]) -> str:
    """The unit of an observable where these models have one and the same, else in general; "1"."""
    found = OBSERVABLES[name].unit
    own = {model.in_units(found) for model in models}
    return own.pop() if len(own) == 1 else found


def titled(name: str, models: Iterable[Model]) -> str:
    """An observable in words, with its unit if it is no pure number and not named for it.

    >>> titled("polarisation", ()), titled("mean-neighbours", ()), titled("groups", ())
    ('polarisation', 'mean neighbours (agents)', 'groups')
    """
    found = unit(name, models)
    return words(name) if found in ("1", words(name)) else f"{words(name)} ({found})"


def table(
    runs: Sequence[tuple[str, Course]], names: Sequence[str]
) -> tuple[list[str], list[list[object]]]:
    """Header and rows: a run after the other, each by its label, at the ticks of its own.

    A value stands only where it was measured, what is counted in every row; nan elsewhere. Time is
    in the unit of the run's model, and there is none where that counts ticks.
    """
    models = [run.conditions.model for _, run in runs]
    units = list(dict.fromkeys(run.conditions.unit for _, run in runs))
    clocks = [unit for unit in units if unit != TICKS]
    header = ["run", "model", "seed", "tick", *(f"time ({unit})" for unit in clocks)]
    header += [titled(name, models) for name in names]
    rows: list[list[object]] = []
    for label, run in runs:
        of, ticks = run.conditions, ticks_of(run, names)
        none = np.full(len(ticks), np.nan)
        times = [ticks * of.dt if unit == of.unit else none for unit in clocks]
        columns = np.transpose([ticks, *times, *(values_at(run, name, ticks) for name in names)])
        rows += [[label, of.model.name, of.seed, *row] for row in columns.tolist()]
    return header, rows


def ticks_of(run: Course, names: Iterable[str]) -> np.ndarray:
    """The ticks (K,) at which anything of it was measured or counted."""
    found = [np.empty(0), *(run.points(name)[0] for name in names)]
    ticks = np.unique(np.concatenate(found))
    return ticks[ticks == np.round(ticks)]  # Without those just before a step.


def values_at(run: Course, name: str, ticks: np.ndarray) -> np.ndarray:
    """An observable at some ticks (K,), nan where it was not measured."""
    at, values = run.points(name)
    if not len(at):
        return np.full(len(ticks), np.nan)
    if OBSERVABLES[name].events is not None:
        return np.interp(ticks, at, values)
    place = np.minimum(np.searchsorted(at, ticks), len(at) - 1)
    return np.where(at[place] == ticks, values[place], np.nan)
