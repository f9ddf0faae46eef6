"""Level flights with a load: at the speed of least power, or at one speed for all."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from agents.flight.aircraft import Aircraft, demand_possible
from agents.flight.trim import SPEEDS, Trim, trim
from app.flight.request import SPEED, FlightRequest
from app.flight.trim_report import as_value
from worlds.input_error import InputError

STRIDE = 0.4
"""Between two speeds of the search for the least power, m/s."""
LEAST_STRIDE = 0.1
SECONDS = 3600.0
"""In an hour."""


class Battery(NamedTuple):
    """What the shafts are driven by."""

    energy: float
    """Wh."""
    efficiency: float
    """Share of it that comes to the shafts."""

    def hours(self, power: float) -> float:
        """How long it drives shafts that take a power, W."""
        return self.energy * self.efficiency / power


def load_aircraft(aircraft: Aircraft, load: float, origin: str = "") -> Aircraft:
    """The aircraft with a load, kg, spread over its body. Raises InputError if that is too
    heavy."""
    fields = aircraft.model_dump() | {"mass": aircraft.mass + load}
    heaviest = Aircraft.model_fields["mass"]
    most = max(item.le for item in heaviest.metadata if hasattr(item, "le"))
    if fields["mass"] > most:
        raise InputError(
            f"{origin or 'load'} {1000.0 * load:g} g is outside "
            f"[0, {1000.0 * (most - aircraft.mass):g}] g with mass = {aircraft.mass:g} kg"
        )
    craft = Aircraft(**fields)
    demand_possible(craft)
    return craft


def compute_loads(
    request: FlightRequest,
    loads: list[float],
    battery: Battery,
    speed: float | None,
    at: Callable[[float], None],
) -> tuple[list[dict[str, Any]], list[float]]:
    """Values of the flights with loads (kg, rising), and the loads without a level flight.

    `speed` in m/s; None: that of the least power for each load. Raises InputError if there is none.
    """
    rows, missing = [], []
    near: Trim | None = None
    for done, load in enumerate(loads):
        at(done / len(loads))
        craft = load_aircraft(request.aircraft, load)
        trim = (
            cheapest(request, craft, near)
            if speed is None
            else first_trim(request, craft, speed, near)
        )
        if trim is None:
            missing.append(load)
            continue
        near = trim
        rows.append(load_values(trim, load, battery))
    if not rows:
        raise InputError(
            "no level flight was found with any load of "
            f"{', '.join(f'{1000.0 * load:g}' for load in loads)} g: try another speed, frequency "
            "or twist"
        )
    return rows, missing


def load_values(trim: Trim, load: float, battery: Battery) -> dict[str, Any]:
    """A flight with a load as JSON has it."""
    hours = battery.hours(trim.power)
    return {
        "load": 1000.0 * load,
        "mass": trim.aircraft.mass,
        **as_value(trim),
        "endurance": hours,
        "range": hours * SECONDS * trim.speed / 1000.0,
    }


def flight(request: FlightRequest, craft: Aircraft, speed: float, near: Trim | None) -> Trim | None:
    """The level flight at a speed, m/s, found from a known one; None if it is not found so."""
    if not SPEEDS[0] <= speed <= SPEEDS[1]:
        return None
    try:
        return trim(craft, speed, frequency=request.frequency, twist=request.twist, near=near)
    except InputError:
        return None


def first_trim(
    request: FlightRequest, craft: Aircraft, speed: float, near: Trim | None
) -> Trim | None:
    """The same, from the flight with the load before or, if that does not lead there, from none."""
    result = None if near is None else flight(request, craft, speed, near)
    return result or flight(request, craft, speed, None)


def cheapest(request: FlightRequest, craft: Aircraft, near: Trim | None) -> Trim | None:
    """The level flight of the least power; None if there is none at the speeds that are tried.

    Speeds are tried faster and slower in strides that halve: power over speed is a U.
    """
    best = first_flight(request, craft, near)
    stride = STRIDE
    trims: dict[float, Trim | None] = {} if best is None else {best.speed: best}
    while best is not None and stride >= LEAST_STRIDE:
        for speed in (best.speed + stride, best.speed - stride):
            if speed not in trims:
                trims[speed] = flight(request, craft, speed, best)
        flights = [trim for trim in trims.values() if trim is not None]
        better = min(flights, key=lambda trim: trim.power)
        if better is best:
            stride *= 0.5
        best = better
    return best


def first_flight(request: FlightRequest, craft: Aircraft, near: Trim | None) -> Trim | None:
    """A level flight to begin with, at the speed of the load before or faster."""
    speed = SPEED if near is None else near.speed
    while speed <= SPEEDS[1]:
        trim = first_trim(request, craft, speed, near)
        if trim is not None:
            return trim
        speed += STRIDE
    return None
