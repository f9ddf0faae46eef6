"""Runs in which a flock gathers and agents may crash: the thesis, chapters 5 and 6, figure 3.7."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field, field_validator

from agents.observables.groups import group_labels, group_sizes
from agents.observables.neighbours import links
from agents.observables.order import polarisation
from app.studies.kinds.kind_settings import (
    PERCENT,
    RARE,
    RARE_PERCENT,
    SUCCESS,
    Measure,
    Number,
    Settings,
)

if TYPE_CHECKING:
    from agents import Flock


class GatheringSettings(Settings):
    """When a flock is looked at, and which crashes are late."""

    kind: ClassVar[str] = "gathering"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("at_0", "at 0", "Crashes at tick 0", "agents", whole=True, bounds=RARE),
        Measure("early", "early", "Crashes later, but not late", "agents", whole=True, bounds=RARE),
        Measure("late", "late", "Late crashes", "agents", whole=True, bounds=RARE),
        Measure(
            "crashed",
            "crashed",
            "Agents that crash after tick 0, of those that flew then",
            "%",
            "nobody flew",
            bounds=RARE_PERCENT,
        ),
        Measure("groups", "groups", "Groups of those that fly", "groups", whole=True),
        Measure(
            "one",
            "one",
            "Runs in which all that fly are one group",
            "%",
            whole=True,
            bounds=SUCCESS,
        ),
        Measure(
            "largest",
            "largest",
            "Those that fly that are in the largest group",
            "%",
            bounds=PERCENT,
        ),
        Measure("p", "p", "Polarisation of those that fly", "1"),
    )

    looks: list[int] = Field(min_length=1)
    """Ticks at which a run is looked at, each later than the one before; crashes so far count."""
    late: int = Field(100, ge=0)
    """Tick after which a crash is late."""
    words: dict[str, str] = Field(default_factory=dict)
    """What the paper sees, by tick."""

    @field_validator("looks")
    @classmethod
    def _rise(cls, looks: list[int]) -> list[int]:
        if any(b <= a for a, b in pairwise([0, *looks])):
            raise ValueError("looks must be above 0 and rise")
        return looks

    @field_validator("words")
    @classmethod
    def _at_ticks(cls, words: dict[str, str]) -> dict[str, str]:
        if not all(tick.isdigit() for tick in words):
            raise ValueError("words need ticks")
        return words

    @property
    def stops(self) -> list[int]:
        """The looks."""
        return self.looks

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Run to the next look."""
        tick = next(tick for tick in self.looks if tick > flock.tick)
        between()
        flock.run(tick - flock.tick)
        return self.measured(flock)

    def measured(self, flock: Flock) -> dict[str, Number | None]:
        """The measures of a flock as it stands."""
        when = flock.crashes.tick
        up = flock.active
        sizes = group_sizes(groups_of(flock))
        return {
            "at_0": int((when == 0).sum()),
            "early": int(((when > 0) & (when <= self.late)).sum()),
            "late": int((when > self.late).sum()),
            "crashed": share_crashed(when, len(up)),
            "groups": len(sizes),
            "one": 100 * int(len(sizes) == 1),
            "largest": 100.0 * float(sizes[0] / up.sum()) if len(sizes) else None,
            "p": polarisation(flock.heading[up]) if up.any() else None,
        }

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """Those of one look."""
        return self.looks[-1] / len(self.looks)


def share_crashed(when: np.ndarray, agents: int) -> float | None:
    """Of agents that flew after tick 0, those that crashed later, %; `when`: ticks of crashes."""
    flew = agents - int((when == 0).sum())
    return 100.0 * float((when > 0).sum() / flew) if flew else None


def groups_of(flock: Flock) -> np.ndarray:
    """The group of each agent that flies, int (M,), 0 the largest: nearer than d_a hang together.

    d_a is the radius of the zone of attraction, as the thesis's model has it.
    """
    position = flock.position[flock.active]
    d_a = flock.parameters.d_a  # type: ignore[attr-defined]
    return group_labels(len(position), links(position, d_a, flock.world.size, flock.world.images))
