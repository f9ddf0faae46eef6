"""The observables as the laboratory has them: which of them a flock has, and how they are told."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from agents.models.model import Model
from agents.observables.catalogue import OBSERVABLES
from agents.observables.observable import Range, everywhere
from worlds.world import World

UNKNOWN = "–"
QUICK = tuple(name for name, one in OBSERVABLES.items() if one.quick)
"""Measured many times a second, whether shown or not."""
COUNTED = tuple(name for name, one in OBSERVABLES.items() if one.events is not None)
"""Known to the tick: not measured now and then, but counted."""
STEADY = tuple(name for name, one in OBSERVABLES.items() if one.card is not None and not one.quick)
"""Measured a few times a second, whether shown or not."""


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


def scale(name: str) -> Range:
    """Between what values an observable lies that is a number.

    >>> print(scale("polarisation"), scale("groups"))
    [0, 1] [0, N]
    """
    found = OBSERVABLES[name].range
    assert isinstance(found, Range)
    return found


def told(name: str, value: float | None) -> str:
    """A value of an observable in few figures, with its unit if that is short.

    >>> told("polarisation", 0.98765), told("groups", 12.0), told("drag-saved", -3.456)
    ('0.988', '12', '-3.5 %')
    """
    if value is None or math.isnan(value):
        return UNKNOWN
    if math.isinf(value):
        return "far"
    if scale(name).is_share:
        return f"{value:.3f}"
    if unit(name) == "%":
        return f"{value:.1f} %"
    return f"{value:.0f}" if float(value).is_integer() else f"{value:.3g}"


def cards(
    part: str, world: World, values: Mapping[str, float], model: Model | None = None
) -> dict[str, str]:
    """The cards of a part of the monitors, label -> text.

    Of what every flock has, those that are not known yet too.
    """
    shown = {}
    for name, one in OBSERVABLES.items():
        card, value = one.card, values.get(name)
        if card is None or card.part != part:
            continue
        if model is not None and card.of is not None and not card.of(model):
            continue
        if value is None and one.applies is not everywhere:
            continue
        label = card.label if isinstance(card.label, str) else card.label(world)
        known = value is not None and math.isfinite(value) and card.form
        shown[label] = f"{value:{card.form}}".replace("%", " %") if known else told(name, value)
    return shown


def offered(flock: Any) -> tuple[str, ...]:
    """The observables that are one number at one tick and say something about a flock, in order."""
    return tuple(
        name
        for name, one in OBSERVABLES.items()
        if one.over is None and not one.is_table and one.applies(flock)
    )


def over_a_run() -> tuple[str, ...]:
    """The observables that are measured over a run."""
    return tuple(name for name, one in OBSERVABLES.items() if one.over is not None)
