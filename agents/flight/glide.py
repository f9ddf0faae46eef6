"""Flight with wings held still, towed level: the drag that flapping must make up for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import root

from agents.flight.aircraft import Aircraft
from agents.flight.flight_motion import Controls, level
from agents.flight.kinematics import Flapping
from agents.flight.power import readings
from worlds.input_error import InputError


@dataclass(frozen=True)
class Glide:
    """Steady level flight at a speed, the wings held flat and a tow rope along the flight."""

    speed: float
    """m/s."""
    pitch: float
    """Angle of attack, rad."""
    tail: float
    """rad, nose up."""
    drag: float
    """Pull of the rope, N."""
    state: np.ndarray
    """(SIZE,)."""


def glide(craft: Aircraft, speed: float) -> Glide:
    """The glide in which lift is weight and nothing pitches. Raises InputError if there is none.

    >>> made = glide(Aircraft(), 4.0)
    >>> f"{Aircraft().weight / made.drag:.1f}"
    '7.2'
    """

    def felt(unknown: np.ndarray):
        pitch, tail = unknown
        controls = Controls(Flapping(0.0, 0.0), float(tail))
        return readings(craft, controls, 0.0, level(speed, float(pitch)))

    def left(unknown: np.ndarray) -> list[float]:
        made = felt(unknown)
        return [made.lift / craft.weight - 1.0, made.pitching / craft.weight]

    made = root(left, np.array([0.1, -0.05]), tol=1e-12)
    if not made.success or not np.abs(made.x).max() < 0.7:
        raise InputError(f"the aircraft cannot glide at {speed:g} m/s: its wings stall")
    pitch, tail = (float(one) for one in made.x)
    return Glide(speed, pitch, tail, -float(felt(made.x).thrust), level(speed, pitch))
