"""Keeps the zones around an agent in their order while somebody moves a slider."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from agents.flock import Flock
from agents.models.declare import Parameters
from worlds.input_error import InputError


def radii(flock: Flock, parameters: Parameters) -> list[float]:
    """Outer radii of the zones of a flock's rule, from the inside out, length."""
    return [zone.radius(parameters) for zone in flock.model.rule.zones]


def in_order(radii: list[float]) -> bool:
    """Whether no zone ends inside of the one before it."""
    return all(inner <= outer for inner, outer in pairwise(radii))


def allowed(flock: Flock, name: str, value: Any) -> Any:
    """The value nearest to the wanted one that keeps the zones in order.

    A zone that would pass another one ends where that one does. Zones that are out of order
    already, as a spec may have them, are left alone. Raises InputError where no value will do.
    """
    now = flock.parameters
    before = radii(flock, now)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    wanted = now.model_copy(update={name: value})
    if not before or not in_order(before) or in_order(radii(flock, wanted)):
        return value
    for other in sorted(before, key=lambda radius: abs(radius - value)):
        if in_order(radii(flock, now.model_copy(update={name: other}))):
            return other
    raise InputError(f"{name} = {value:g} would put the zones out of order: nothing is changed")


def stopped(flock: Flock, name: str, value: float) -> str:
    """What is told when a zone stops at another one."""
    others = (
        f"{zone.name} ends at {value:g}"
        for zone in flock.model.rule.zones
        if zone.radius(flock.parameters) == value
    )
    return f"{name} stops at {value:g}: {', '.join(others)}, and zones keep their order"
