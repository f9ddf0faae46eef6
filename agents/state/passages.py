"""Who has entered a running flock through its sources, and who has left it through its exits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from worlds.input_error import InputError

LARGEST = 2**53
"""No tick and no identity is larger, so that each is exact as a float too."""


@dataclass(frozen=True, eq=False)
class Passages:
    """Passages of agents through the gates of a world, in the order of ticks; (M,) each."""

    tick: np.ndarray
    """The tick at whose end the agent came or went, int."""
    id: np.ndarray
    """Its identity, int."""
    gate: np.ndarray
    """The number of the source or exit in the mission, from 0 on, int."""
    place: np.ndarray
    """Where the agent was then, (M, dim), length."""
    is_known: bool = True
    """Whether these are all there were: not in a recording that a kill has cut off."""

    @classmethod
    def none(cls, dim: int, is_known: bool = True) -> Self:
        """Nobody's."""
        nobody = np.empty(0, np.int64)
        return cls(nobody, nobody, nobody, np.empty((0, dim)), is_known)

    def __len__(self) -> int:
        return len(self.tick)

    def with_more(self, tick: int, ids: np.ndarray, gate: np.ndarray, place: np.ndarray) -> Self:
        """These and those of agents (K,) at a later tick."""
        return type(self)(
            np.append(self.tick, np.full(len(ids), tick)),
            np.append(self.id, ids),
            np.append(self.gate, gate),
            np.concatenate([self.place, place]),
            self.is_known,
        )

    def until(self, tick: int) -> Self:
        """Those up to a tick, itself among them."""
        return self.select(np.arange(np.searchsorted(self.tick, tick, side="right")))

    def select(self, rows: np.ndarray) -> Self:
        """Some of them, by an index or a mask."""
        return replace(
            self,
            tick=self.tick[rows],
            id=self.id[rows],
            gate=self.gate[rows],
            place=self.place[rows],
        )

    def counts(self, gates: int) -> np.ndarray:
        """How many passed each of so many gates, (gates,) int."""
        return np.bincount(self.gate, minlength=gates)[:gates]

    def to_table(self) -> dict[str, list]:
        """As JSON has them; floats come back to the bit."""
        return {
            "tick": self.tick.tolist(),
            "id": self.id.tolist(),
            "gate": self.gate.tolist(),
            "place": self.place.tolist(),
        }

    @classmethod
    def from_table(cls, table: Any, dim: int, gates: int, origin: str) -> Self:
        """Those of a file, from `to_table`. Raises InputError for what they cannot be."""
        fault = InputError(f"{origin} holds passages of agents that cannot be")
        if not isinstance(table, Mapping) or not {"tick", "id", "gate", "place"} <= set(table):
            raise fault
        columns = []
        for name, least_above in (("tick", LARGEST), ("id", LARGEST), ("gate", gates)):
            numbers = table[name]
            if not isinstance(numbers, list) or not all(type(n) is int for n in numbers):
                raise fault
            if any(not 0 <= number < least_above for number in numbers):
                raise fault
            columns.append(np.array(numbers, np.int64))
        tick, ids, gate = columns
        try:
            place = np.array(table["place"], float).reshape(len(table["place"]), dim)
        except (TypeError, ValueError):
            raise fault from None
        if not len(tick) == len(ids) == len(gate) == len(place) or not np.isfinite(place).all():
            raise fault
        if (np.diff(tick) < 0).any():
            raise fault
        return cls(tick, ids, gate, place)
