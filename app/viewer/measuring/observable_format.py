"""The observables as the laboratory has them: which of them a flock has, and how they are told."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from agents.models.model import Model
from agents.observables.catalogue import OBSERVABLES, find_observable, kind_observables
from agents.observables.observable import Range, everywhere
from worlds.world import World

UNKNOWN = "–"
NOTHING, LITTLE, MUCH = 1e-9, 1e-4, 1e7
"""Below the first a number is rounding, beyond the others it is written with its power of ten."""
QUICK = tuple(name for name, observable in OBSERVABLES.items() if observable.quick)
"""Measured many times a second, whether shown or not."""
COUNTED = tuple(name for name, observable in OBSERVABLES.items() if observable.events is not None)
"""Known to the tick: not measured now and then, but counted."""
STEADY = tuple(
    name
    for name, observable in OBSERVABLES.items()
    if observable.card is not None and not observable.quick
)
"""Measured a few times a second, whether shown or not."""


def observable_words(name: str) -> str:
    """An observable in words.

    >>> observable_words("angular-momentum")
    'angular momentum'
    """
    return name.replace("-", " ")


def unit(name: str) -> str:
    """The unit of an observable for people; nothing for a pure number or for a count.

    >>> unit("drag-saved"), unit("groups")
    ('%', '')
    """
    text = find_observable(name).unit
    return text if text in ("%", "length") else ""


def scale(name: str) -> Range:
    """Between what values an observable lies that is a number.

    >>> print(scale("polarisation"), scale("groups"))
    [0, 1] [0, N]
    """
    limits = find_observable(name).range
    assert isinstance(limits, Range)
    return limits


def format_observable(name: str, value: float | None) -> str:
    """A value of an observable in few figures, with its unit if that is short.

    >>> values = {"polarisation": 0.98765, "groups": 12.0, "drag-saved": -3.456}
    >>> tuple(format_observable(name, value) for name, value in values.items())
    ('0.988', '12', '-3.5 %')
    """
    if value is None or not math.isfinite(value):
        return format_short(math.nan if value is None else value)
    if scale(name).is_share:
        return f"{value:.3f}"
    return f"{value:.1f} %" if unit(name) == "%" else format_short(value)


def format_short(value: float) -> str:
    """A number in three figures or so; what only rounding has left of nothing is nothing.

    >>> tuple(map(format_short, (6.52e-14, 0.01234, 1234.5, 216035.0, 3.2e9, math.inf)))
    ('0', '0.0123', '1\u202f234', '216\u202f035', '3.2e+09', 'far')
    """
    if math.isnan(value):
        return UNKNOWN
    if math.isinf(value):
        return "far"
    if abs(value) < NOTHING:
        return "0"
    if not LITTLE <= abs(value) < MUCH:
        return f"{value:.2g}"
    return format_thousands(round(value)) if abs(value) >= 100.0 else f"{value:.3g}"


def format_thousands(number: int) -> str:
    """A number with its thousands apart."""
    return f"{number:,}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def cards(
    part: str, world: World, values: Mapping[str, float], model: Model | None = None
) -> dict[str, str]:
    """The cards of a part of the monitors, label -> text.

    Of what every flock has, those that are not known yet too.
    """
    texts = {}
    for name, observable in OBSERVABLES.items():
        card, value = observable.card, values.get(name)
        if card is None or card.part != part:
            continue
        if model is not None and card.of is not None and not card.of(model):
            continue
        if value is None and observable.applies is not everywhere:
            continue
        label = card.label if isinstance(card.label, str) else card.label(world)
        is_known = value is not None and math.isfinite(value) and card.form
        texts[label] = (
            f"{value:{card.form}}".replace("%", " %")
            if is_known
            else format_observable(name, value)
        )
    return texts


def offered_observables(flock: Any) -> tuple[str, ...]:
    """The observables that are one number at one tick and say something about a flock, in order:
    last those of each of its kinds."""
    of_all = (
        name
        for name, observable in OBSERVABLES.items()
        if observable.over is None and not observable.is_table and observable.applies(flock)
    )
    return (*of_all, *kind_observables(flock))


def run_observables() -> tuple[str, ...]:
    """The observables that are measured over a run."""
    return tuple(name for name, observable in OBSERVABLES.items() if observable.over is not None)
