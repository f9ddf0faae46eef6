"""Everything that the monitors know of a flock, in full: name, value and unit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from agents.models.model import Model
from agents.observables.catalogue import OBSERVABLES
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.observable_format import words

GROUPS = 100
"""Groups whose sizes are told, the largest first."""


class Number(NamedTuple):
    """A value and its unit; 1 for a pure number."""

    value: float
    unit: str


def numbers(readings: FlockReadings, more: Mapping[str, Number]) -> dict[str, Number]:
    """What is known of a flock now, by name; nan for what is not known. `more` is added to it."""
    flock, tick = readings.flock, readings.tick
    model, unit = flock.model, flock.model.body.unit
    found = {"tick": Number(tick, "ticks")}
    if unit != "ticks":
        found["time"] = Number(tick * flock.dt, unit)
    found["agents"] = Number(len(flock.ids), "agents")
    for name in OBSERVABLES:
        if name in readings.values:
            found[words(name)] = observed(name, readings.values[name], model)
    found |= mission(readings, model.in_units("length")) | dict(more)
    for layer, count in enumerate(readings.layers.tolist(), start=1):
        found[f"layer {layer}"] = Number(count, "agents")
    if readings.unknown:
        found["in no layer"] = Number(readings.unknown, "agents")
    for place, size in enumerate(readings.sizes[:GROUPS].tolist(), start=1):
        found[f"group {place}"] = Number(size, "agents")
    return found


def observed(name: str, value: float, model: Model) -> Number:
    """The value of an observable, with its unit as a model has it."""
    return Number(value, model.in_units(OBSERVABLES[name].unit))


def mission(readings: FlockReadings, length: str) -> dict[str, Number]:
    """How a flock does on its way, and among what is solid."""
    kinds = {
        "through": ("arrived", "1"),
        "least-gap": ("closest pair so far", length),
        "least-clearance": ("closest to an obstacle so far", length),
        "inside": ("collisions", "agents"),
    }
    known = readings.values
    return {words: Number(known[key], unit) for key, (words, unit) in kinds.items() if key in known}


def rows(flocks: list[dict[str, Number]]) -> list[list[object]]:
    """A table of one flock or two: name, the value of each, unit; nan for what one lacks."""
    names = dict.fromkeys(name for flock in flocks for name in flock)
    made: list[list[object]] = []
    for name in names:
        known = [flock[name] for flock in flocks if name in flock]
        units = dict.fromkeys(number.unit for number in known)
        values = [flock[name].value if name in flock else math.nan for flock in flocks]
        made.append([name, *values, " and ".join(units)])
    return made
