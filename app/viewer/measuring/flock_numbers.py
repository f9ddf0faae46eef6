"""Everything that the monitors know of a flock, in full: name, value and unit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from agents.models.model import Model
from agents.observables.catalogue import OBSERVABLES, find_observable, kind_observables
from app.viewer.measuring.background_worker import BackgroundWorker
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.observable_format import observable_words
from worlds.input_error import InputError

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
    result = {"tick": Number(tick, "ticks")}
    if unit != "ticks":
        result["time"] = Number(tick * flock.dt, unit)
    result["agents"] = Number(len(flock.ids), "agents")
    for name in (*OBSERVABLES, *kind_observables(flock)):
        if name in readings.values:
            result[observable_words(name)] = number_of(name, readings.values[name], model)
    result |= mission(readings, model.in_units("length")) | dict(more)
    for layer, count in enumerate(readings.layers.tolist(), start=1):
        result[f"layer {layer}"] = Number(count, "agents")
    if readings.unknown:
        result["in no layer"] = Number(readings.unknown, "agents")
    for place, size in enumerate(readings.sizes[:GROUPS].tolist(), start=1):
        result[f"group {place}"] = Number(size, "agents")
    return result


def number_of(name: str, value: float, model: Model) -> Number:
    """The value of an observable, with its unit as a model has it."""
    return Number(value, model.in_units(find_observable(name).unit))


def mission(readings: FlockReadings, length: str) -> dict[str, Number]:
    """How a flock does on its way, and among what is solid."""
    kinds = {
        "through": ("arrived", "1"),
        "least-gap": ("closest pair so far", length),
        "least-clearance": ("closest to an obstacle so far", length),
        "inside": ("collisions", "agents"),
    }
    values = readings.values
    return {
        words: Number(values[key], unit) for key, (words, unit) in kinds.items() if key in values
    }


def rows(flocks: list[dict[str, Number]]) -> list[list[object]]:
    """A table of one flock or two: name, the value of each, unit; nan for what one lacks."""
    names = dict.fromkeys(name for flock in flocks for name in flock)
    result: list[list[object]] = []
    for name in names:
        present = [flock[name] for flock in flocks if name in flock]
        units = dict.fromkeys(number.unit for number in present)
        values = [flock[name].value if name in flock else math.nan for flock in flocks]
        result.append([name, *values, " and ".join(units)])
    return result


# What formation saves in joules: a share of what an aircraft needs that flies alone.

SAVES = tuple(name for name, observable in OBSERVABLES.items() if observable.saves_power)
"""The observables that say what share of their power, in percent, agents save."""
STEP = 0.25
"""Speeds are rounded to it, m/s: a trim takes seconds."""


class EnergySavings:
    """Energy per metre of the thesis's aircraft in trim, found aside, once for each speed."""

    def __init__(self) -> None:
        self.known: dict[float, float | None] = {}
        """Speed (m/s) -> J/m; None where it cannot fly level."""
        self.aside = BackgroundWorker()
        self.sought = 0.0

    def energy_alone(self, speed: float) -> float | None:
        """J/m of an aircraft alone at about a speed (m/s); None until, or unless, it is known."""
        speed = round(speed / STEP) * STEP
        done = self.aside.finished()
        if done is not None:
            self.known[self.sought] = done.result()
        if speed not in self.known and self.aside.idle:
            self.sought = speed
            self.aside.begin(lambda: energy_in_trim(speed))
        return self.known.get(speed)

    def savings(self, readings: FlockReadings) -> tuple[float, float] | None:
        """What a flock saves at the speed its body cruises at, and what one needs alone, J/m."""
        share = next((readings.values[name] for name in SAVES if name in readings.values), None)
        speed = getattr(readings.flock.parameters, "v0", None)
        if speed is None or share is None:
            return None
        alone = self.energy_alone(speed)
        return None if alone is None else (0.01 * share * alone, alone)

    def describe(self, readings: FlockReadings) -> str:
        """The same in words."""
        saving = self.savings(readings)
        return "–" if saving is None else f"{saving[0]:.3f} of {saving[1]:.2f}"


def energy_in_trim(speed: float) -> float | None:
    """J/m in trim at a speed (m/s); None where the aircraft cannot fly level."""
    from agents.flight.trim import trim

    try:
        return trim(speed=speed).energy_per_metre
    except InputError:
        return None
