"""What was measured of runs as one table, a row for each of their ticks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from agents.individuals import Distribution
from agents.models.model import Model
from agents.observables.catalogue import find_observable
from agents.spec import Options
from app.viewer.measuring.observable_curves import ObservableHistory
from app.viewer.measuring.observable_format import observable_words
from app.viewer.measuring.run_conditions import BY_HAND
from worlds.world import World

TICKS = "ticks"
"""The unit of time of a model that only counts ticks."""


def unit(name: str, models: Iterable[Model]) -> str:
    """The unit of an observable where these models have one and the same, else in general; "1"."""
    text = find_observable(name).unit
    own = {model.in_units(text) for model in models}
    return own.pop() if len(own) == 1 else text


def observable_title(name: str, models: Iterable[Model]) -> str:
    """An observable in words, with its unit if it is no pure number and not named for it.

    >>> names = "polarisation", "mean-neighbours", "groups"
    >>> tuple(observable_title(name, ()) for name in names)
    ('polarisation', 'mean neighbours (agents)', 'groups')
    """
    unit_text = unit(name, models)
    return (
        observable_words(name)
        if unit_text in ("1", observable_words(name))
        else f"{observable_words(name)} ({unit_text})"
    )


def table(
    runs: Sequence[tuple[str, ObservableHistory]], names: Sequence[str]
) -> tuple[list[str], list[list[object]]]:
    """Header and rows: a run after the other, each by its label, at the ticks of its own.

    A value stands only where it was measured, what is counted in every row; nan elsewhere. Time is
    in the unit of the run's model, and there is none where that counts ticks. The last columns are
    the conditions under which each tick was made.
    """
    models = [run.conditions.model for _, run in runs]
    units = list(dict.fromkeys(run.conditions.unit for _, run in runs))
    clocks = [unit for unit in units if unit != TICKS]
    header = ["run", "model", "seed", "tick", *(f"time ({unit})" for unit in clocks)]
    header += [observable_title(name, models) for name in names]
    conditions = conditions_of([run for _, run in runs])
    used_names = set(header)
    header += [f"parameter {name}" if name in used_names else name for name in conditions]
    rows: list[list[object]] = []
    for label, run in runs:
        of, ticks = run.conditions, ticks_of(run, names)
        none = np.full(len(ticks), np.nan)
        times = [ticks * of.dt if unit == of.unit else none for unit in clocks]
        columns = np.transpose([ticks, *times, *(values_at(run, name, ticks) for name in names)])
        made_so = conditions_at(run, ticks, conditions)
        rows += [
            [label, of.model.name, of.seed, *row, *more]
            for row, more in zip(columns.tolist(), made_so, strict=True)
        ]
    return header, rows


def conditions_of(runs: Iterable[ObservableHistory]) -> list[str]:
    """The names of all conditions of some runs, but for the seed; nobody moved by hand is none."""
    steps = [(name, step) for run in runs for name, step in run.history.steps.items()]
    names = dict.fromkeys(name for name, _ in steps if name not in ("seed", BY_HAND))
    by_hand = any(value for name, step in steps if name == BY_HAND for _, value in step)
    return [*names, BY_HAND] if by_hand else list(names)


def conditions_at(
    run: ObservableHistory, ticks: np.ndarray, names: Sequence[str]
) -> list[list[object]]:
    """The conditions of these names under which each of some ticks (K,) of a run was made.

    Worlds of one name that differ are numbered. What a run does not have is None.
    """
    worlds: list[World] = []
    settings = []
    for stretch in run.history.stretches:
        values = stretch.conditions.values
        if stretch.conditions.world not in worlds:
            worlds.append(stretch.conditions.world)
        number = 1 + worlds.index(stretch.conditions.world)
        world = stretch.conditions.world.name + (f" #{number}" if number > 1 else "")
        settings.append([*(world if name == "world" else value_of(values, name) for name in names)])
    return [settings[place] for place in run.history.stretch_indices(ticks)]


def value_of(values: Mapping[str, object], name: str) -> object:
    """The value of a condition, which of an option that was not chosen is its default.

    A distribution is written as on a command line, as `normal(3, 0.5)`.
    """
    if name in values or name not in Options.model_fields:
        value = values.get(name)
        return str(value) if isinstance(value, Distribution) else value
    return Options.model_fields[name].default


def ticks_of(run: ObservableHistory, names: Iterable[str]) -> np.ndarray:
    """The ticks (K,) at which anything of it was measured or counted."""
    tick_arrays = [np.empty(0), *(run.points(name)[0] for name in names)]
    ticks = np.unique(np.concatenate(tick_arrays))
    return ticks[ticks == np.round(ticks)]  # Without those just before a step.


def values_at(run: ObservableHistory, name: str, ticks: np.ndarray) -> np.ndarray:
    """An observable at some ticks (K,), nan where it was not measured."""
    at, values = run.points(name)
    if not len(at):
        return np.full(len(ticks), np.nan)
    if find_observable(name).events is not None:
        return np.interp(ticks, at, values)
    place = np.minimum(np.searchsorted(at, ticks), len(at) - 1)
    return np.where(at[place] == ticks, values[place], np.nan)
