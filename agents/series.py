"""Observables of a flock over a run: a series of each, and what is measured of the series."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from agents.observables.catalogue import OBSERVABLES
from agents.observables.observable import SERIES
from agents.option import whole_number
from worlds.input_error import InputError, unknown

if TYPE_CHECKING:
    from agents.flock import Flock


@dataclass(frozen=True)
class Series:
    """Observables over a run, one value for each of K observed ticks."""

    tick: np.ndarray
    """(K,) int, rising."""
    agents: np.ndarray
    """Agents that had not crashed, (K,) int."""
    values: dict[str, np.ndarray]
    """Each observable by its name, (K,) float."""

    def over(self, name: str) -> float:
        """An observable of the whole series, such as `susceptibility`. Raises InputError.

        The number of agents is its mean over the series.
        """
        take = OBSERVABLES[name].over if name in OBSERVABLES else None
        if take is None:
            names = [observable.name for observable in OBSERVABLES.values() if observable.over]
            raise unknown("observable over a run", name, names)
        if SERIES not in self.values:
            raise InputError(
                f"{name} is measured from a series of {SERIES}, which was not observed"
            )
        return take(self.values[SERIES], float(self.agents.mean()) if len(self.agents) else 0.0)


class Follower:
    """Collects observables of a running flock at the ticks at which it is called."""

    def __init__(self, flock: Flock, names: Iterable[str]):
        """`names` as `needed` makes them. Raises InputError."""
        self.flock = flock
        self.names = needed(names)
        self.rows: list[list[float]] = []

    def note_values(self) -> None:
        """Note what is observed now."""
        flock = self.flock
        values = [float(flock.observe(name)) for name in self.names]
        self.rows.append([flock.tick, flock.active.sum(), *values])

    @property
    def series(self) -> Series:
        """What has been noted so far."""
        tick, agents, *columns = np.array(self.rows).reshape(-1, 2 + len(self.names)).T
        values = dict(zip(self.names, columns, strict=True))
        return Series(tick.astype(int), agents.astype(int), values)


def needed(names: Iterable[str]) -> list[str]:
    """The observables of which a series is needed, each once.

    Those that are measured over a run stand for the series that they are measured from. Raises
    InputError for an unknown name, or for a table, which has no series.

    >>> needed(["groups", "binder", "susceptibility"])
    ['groups', 'polarisation']
    """
    needed_names: dict[str, None] = {}
    for name in names:
        if name not in OBSERVABLES:
            raise unknown("observable", name, OBSERVABLES)
        observable = OBSERVABLES[name]
        if observable.is_table:
            raise InputError(f"{name} is a table, not a number: it has no series over a run")
        needed_names[SERIES if observable.over else name] = None
    return list(needed_names)


def follow(flock: Flock, ticks: int, names: Iterable[str] = (SERIES,), every: int = 1) -> Series:
    """Run a flock, looking at it every `every` ticks.

    Parameters
    ----------
    ticks: >= 0. Observed are the ticks `every`, 2 `every`, ... from now on; the last may be run
        without being observed.
    names: observables; of those that are measured over a run, the series that they need.
    every: >= 1.

    Raises InputError for an unknown name or for what is out of range, before anything runs.

    >>> from flockscope import Flock
    >>> series = follow(Flock("vem", agents=50, rng=1, eta=3.0), 200)
    >>> 0.0 < series.over("susceptibility") < 50 / 4
    True
    """
    follower = Follower(flock, names)
    ticks, every = whole_number("ticks", ticks, 0), whole_number("every", every, 1)
    for _ in range(ticks // every):
        flock.run(every)
        follower.note_values()
    flock.run(ticks % every)
    return follower.series
