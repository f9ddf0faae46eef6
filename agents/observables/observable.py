"""What an observable is: one measured quantity with its unit and range."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np

from worlds.refusal import Refusal

SERIES = "polarisation"
"""The observable whose series over a run the fluctuations are taken of."""


@dataclass(frozen=True)
class Observable:
    """One measured quantity."""

    name: str
    title: str
    unit: str
    range: str
    measure: Callable[[Any], Any]
    """Takes an `agents.snapshot.Snapshot` of the agents that have not crashed."""
    over: Callable[[np.ndarray, float], float] | None = None
    """If it is measured over a run: takes the series of SERIES (K,) and the number of agents."""
    is_table: bool = False
    """Whether it gives a dictionary and not a number."""
    needs_links: bool = False
    """Whether it needs the list of all pairs within reach, which is long in a crowd."""


def over_a_run(
    name: str, title: str, unit: str, range: str, over: Callable[[np.ndarray, float], float]
) -> Observable:
    """An observable of a series; a flock at one tick does not have it, and it says so."""

    def refuse(_: Any) -> NoReturn:
        raise Refusal(
            f"{name} is measured over a run, not at one tick: use agents.series.follow, or --over "
            "TICKS on the command line"
        )

    return Observable(name, title, unit, range, refuse, over)
