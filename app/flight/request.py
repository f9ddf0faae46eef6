"""What a flight command is asked for, checked before anything is computed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.settings import assignment
from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents.flight.aircraft import Aircraft

SPEED, FREQUENCY, TWIST = 3.5, 1.5, 20.0
"""Of the flight that the reading of the thesis measured: m/s, Hz, deg."""


@dataclass(frozen=True)
class FlightRequest:
    """A flight that is asked for."""

    aircraft: Aircraft
    frequency: float
    """Hz."""
    twist: float
    """Of the wing tip, rad."""


def check_range(option: str, value: float, low: float, high: float, unit: str) -> float:
    """The value, if it is in [low, high]. Raises InputError naming the option."""
    if not low <= value <= high:
        raise InputError(f"{option} {value:g} {unit} is outside [{low:g}, {high:g}] {unit}")
    return value


def check_speed(option: str, speed: float) -> float:
    """A speed in m/s that a trim takes. Raises InputError."""
    from agents.flight.trim import SPEEDS

    return check_range(option, speed, *SPEEDS, "m/s")


def request(frequency: float, twist: float, settings: list[str] | None) -> FlightRequest:
    """The aircraft with its settings, and how its wings beat (Hz, deg). Raises InputError."""
    from agents.flight.aircraft import Aircraft, demand_possible
    from agents.flight.trim import FREQUENCIES, TWISTS
    from agents.models.declare import checked

    check_range("--frequency", frequency, *FREQUENCIES, "Hz")
    check_range("--twist", twist, math.degrees(TWISTS[0]), math.degrees(TWISTS[1]), "deg")
    values = dict(assignment(setting) for setting in settings or [])
    craft = checked(Aircraft, values, "--set")
    assert isinstance(craft, Aircraft)
    demand_possible(craft, "--set")
    return FlightRequest(craft, frequency, math.radians(twist))
