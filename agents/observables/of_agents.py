"""What is measured of each agent of a flock: numbers that the laboratory can colour by."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from worlds.plug_ins import plug_ins


@dataclass(frozen=True)
class OfAgents:
    """One number for each agent."""

    name: str
    title: str
    unit: str
    measure: Callable[[Any], np.ndarray]
    """Takes a flock, gives (N,) floats; NaN where an agent has none."""


def neighbours(flock: Any) -> np.ndarray:
    """How many agents are within reach of each, (N,)."""
    return np.bincount(flock.links().ravel(), minlength=len(flock.ids)).astype(float)


BUILT_IN = {
    colouring.name: colouring
    for colouring in (OfAgents("neighbours", "Agents within reach of each", "agents", neighbours),)
}


def colouring_of_entry(_: str, entry: object) -> tuple[str, OfAgents]:
    """The colouring that an entry point brings. Raises TypeError if it is none."""
    if not isinstance(entry, OfAgents):
        raise TypeError(f"an OfAgents is needed, not {type(entry).__name__}")
    return entry.name, entry


OF_AGENTS = BUILT_IN | plug_ins("flockscope.colourings", colouring_of_entry, BUILT_IN)
"""All of them: the built-in ones, then those of other packages, which replace none of these."""


ON_ITS_WAY = " sent "
"""In the names of a car's commands that have not arrived yet."""


OWN = "own "
"""Before the name of a parameter that differs from agent to agent: the number that each has."""


def own_name(parameter: str) -> str:
    """What the agents' own numbers of a parameter are called, beside what else is measured of them.

    >>> own_name("s")
    'own s'
    """
    return OWN + parameter


def measurable(columns: tuple[str, ...], individuals: Iterable[str] = ()) -> tuple[str, ...]:
    """What each agent of a flock has a number of: its own of the parameters `individuals`,
    `OF_AGENTS`, and its model's `columns`.

    >>> measurable(("speed", "steering sent 1"))[-1]
    'speed'
    """
    own = (name for name in columns if ON_ITS_WAY not in name)
    return tuple(dict.fromkeys([*map(own_name, individuals), *OF_AGENTS, *own]))


def measured(flock: Any, name: str) -> np.ndarray | None:
    """The number of each agent by name, (N,); None for what this flock does not have."""
    if name in OF_AGENTS:
        values = np.asarray(OF_AGENTS[name].measure(flock), dtype=float)
        return values if values.shape == (len(flock.ids),) else None
    if name.startswith(OWN):
        column = flock.own.get(name.removeprefix(OWN))
        return None if column is None else column.copy()
    return flock.signal(name) if name in flock.model.columns else None
