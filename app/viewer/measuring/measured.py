"""The observables as the laboratory has them: which of them a flock has, and how they are told."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from agents.observables.catalogue import OBSERVABLES

SAVED = ("drag-saved", "energy-saved")
"""What follows from the measures of each agent within the pass."""
QUICK = (
    "polarisation",
    "consistency",
    "angular-momentum",
    "goal-distance",
    *SAVED,
)
"""As cheap as a look at each agent: measured many times a second, whether shown or not."""
GRAPH = ("mean-neighbours", "groups", "largest-group", "following")
"""From the flock's graph: measured a few times a second, whether shown or not."""
CRASHES = "crashes"
"""Known to the tick: not measured now and then, but counted."""


@dataclass(frozen=True)
class Scale:
    """Between what values an observable lies; None where there is no bound to draw."""

    low: float | None
    high: float | None

    @property
    def is_share(self) -> bool:
        """Whether it is a share, from 0 to 1."""
        return (self.low, self.high) == (0.0, 1.0)


def words(name: str) -> str:
    """An observable in words.

    >>> words("angular-momentum")
    'angular momentum'
    """
    return name.replace("-", " ")


def unit(name: str) -> str:
    """The unit of an observable for people; nothing for a pure number or for a count.

    >>> unit("drag-saved"), unit("groups")
    ('%', '')
    """
    found = OBSERVABLES[name].unit
    return found if found in ("%", "length") else ""


def scale(name: str) -> Scale:
    """The scale of an observable, from its declared range.

    >>> scale("polarisation"), scale("groups")
    (Scale(low=0.0, high=1.0), Scale(low=0.0, high=None))
    """
    low, _, high = OBSERVABLES[name].range.strip("[]()").partition(",")
    return Scale(bound(low), bound(high))


def bound(text: str) -> float | None:
    """An end of a range; None where it is not a finite number.

    >>> bound("0"), bound(" N"), bound("-inf")
    (0.0, None, None)
    """
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def told(name: str, value: float | None) -> str:
    """A value of an observable in few figures, with its unit if that is short.

    >>> told("polarisation", 0.98765), told("groups", 12.0), told("drag-saved", -3.456)
    ('0.988', '12', '-3.5 %')
    """
    if value is None or math.isnan(value):
        return "–"
    if math.isinf(value):
        return "far"
    if scale(name).is_share:
        return f"{value:.3f}"
    if unit(name) == "%":
        return f"{value:.1f} %"
    return f"{value:.0f}" if float(value).is_integer() else f"{value:.3g}"


def says(flock: Any, name: str) -> bool:
    """Whether an observable says anything about a flock in its world, now or later."""
    world, mission = flock.world, flock.world.mission
    match name:
        case "goal-distance":
            return mission is not None and (mission.goal is not None or mission.path is not None)
        case "following":
            return bool(flock.informed.any())
        case "obstacle-distance" | "inside-obstacles":
            return world.is_solid
        case "crashes":
            return flock.can_crash
        case "drag-saved" | "energy-saved":
            return "saved" in flock.model.columns
    return True


def offered(flock: Any) -> tuple[str, ...]:
    """The observables that are one number at one tick and say something about a flock, in order."""
    return tuple(
        name
        for name, one in OBSERVABLES.items()
        if one.over is None and not one.is_table and says(flock, name)
    )


def over_a_run() -> tuple[str, ...]:
    """The observables that are measured over a run."""
    return tuple(name for name, one in OBSERVABLES.items() if one.over is not None)
