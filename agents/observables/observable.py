"""What an observable is: one measured quantity with its unit and range."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, NoReturn

import numpy as np

from worlds.input_error import InputError

SERIES = "polarisation"
"""The observable whose series over a run the fluctuations are taken of."""


@dataclass(frozen=True)
class Range:
    """Between what numbers a quantity lies.

    >>> print(Range(0.0, 1.0), Range(0.0, limit="N"), Range())
    [0, 1] [0, N] [-inf, inf]
    """

    low: float = -math.inf
    high: float = math.inf
    limit: str = ""
    """The upper end in words, if it goes with the number N of agents or is a fraction."""

    def __str__(self) -> str:
        return f"[{self.low:g}, {self.limit or f'{self.high:g}'}]"

    @property
    def is_share(self) -> bool:
        """Whether it is that of a share, from 0 to 1."""
        return (self.low, self.high) == (0.0, 1.0)


SHARE, LENGTH, COUNT = Range(0.0, 1.0), Range(0.0), Range(0.0, limit="N")


@dataclass(frozen=True)
class Table:
    """The range of what is a dictionary: what its keys are, and the ranges of what stands there."""

    key: str
    columns: tuple[Range, ...]

    def __str__(self) -> str:
        return f"{self.key} -> {', '.join(map(str, self.columns))}"


def everywhere(_: Any) -> bool:
    """Of every flock."""
    return True


def nowhere(_: Any) -> bool:
    """Of no flock."""
    return False


@dataclass(frozen=True)
class MonitorCard:
    """How the laboratory's monitors show an observable, which they then measure unasked."""

    label: str | Callable[[Any], str]
    """Its few words there, or what makes them of a world."""
    form: str = ""
    """How its value is written, as `format` has it; by default as in the key of a plot."""
    part: Literal["flock", "way", "team"] = "flock"
    """Among what it stands: the numbers of any flock, how far a mission is, how those on it do."""
    of: Callable[[Any], bool] | None = None
    """Takes an `agents.models.model.Model`: whether its flocks have the card. None: all, which
    therefore need no switch for the number."""


@dataclass(frozen=True)
class Observable:
    """One measured quantity, and what others have to know of it. Raises TypeError."""

    name: str
    title: str
    unit: str
    range: Range | Table
    measure: Callable[[Any], Any]
    """Takes an `agents.snapshot.Snapshot` of the agents that have not crashed; a number, or with a
    `Table` for its range a dictionary."""
    over: Callable[[np.ndarray, float], float] | None = None
    """If it is measured over a run: takes the series of SERIES (K,) and the number of agents."""
    needs_links: bool = False
    """Whether it needs the list of all pairs within reach, which is long in a crowd."""
    quick: bool = False
    """Whether it takes no longer than a look at each agent, and may be measured often."""
    events: Callable[[Any], np.ndarray] | None = None
    """If it counts what happens in a flock: the ticks (M,) of that, in order."""
    applies: Callable[[Any], bool] = everywhere
    """Of which flocks in their worlds it says anything, now or later."""
    tells: Callable[[Any], bool] = nowhere
    """Of which flocks it is among the few that tell how they do, whatever their model declares."""
    beside: str = ""
    """The observable whose chart it may share."""
    card: MonitorCard | None = None
    saves_power: bool = False
    """Whether it is how much of its power an agent saves, in percent."""
    compiled: Any = None
    """The same as a compiled loop, for a page that runs by itself; see
    `agents.observables.of_rows`."""
    in_page: Callable[[Any], bool] = everywhere
    """Of which flocks, of those that have it, a page measures it: each loop makes it larger."""

    def __post_init__(self) -> None:
        if not isinstance(self.range, Range | Table):
            raise TypeError(f"observable {self.name!r}: its range is no Range and no Table")

    @property
    def is_table(self) -> bool:
        """Whether it gives a dictionary and not a number."""
        return isinstance(self.range, Table)


def over_a_run(
    name: str, title: str, unit: str, range: Range, over: Callable[[np.ndarray, float], float]
) -> Observable:
    """An observable of a series; a flock at one tick does not have it, and it says so."""

    def refuse(_: Any) -> NoReturn:
        raise InputError(
            f"{name} is measured over a run, not at one tick: use flockscope.follow, or --over "
            "TICKS on the command line"
        )

    return Observable(name, title, unit, range, refuse, over)
