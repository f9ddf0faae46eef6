"""What the picture has to know of agents that are cars, beside places and headings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from agents.flock import Flock

HELD = 0.5
"""A car that has not got on for so long is stuck, s."""


@dataclass(frozen=True)
class Cars:
    """Cars at one tick. Arrays are copies that nobody writes to any more."""

    length: float
    """Of the body, length."""
    width: float
    """Of the body, length."""
    steering: np.ndarray
    """(N,) angle of the front wheels, rad, to the left positive; 0 for cars without."""
    stuck: np.ndarray
    """(N,) bool: something has kept them from getting on, or they are backing out of it."""
    predator: np.ndarray
    """(N,) bool: cars that hunt the others."""


def cars(flock: Flock) -> Cars | None:
    """What is to be known of a flock of cars; None for a flock of anything else.

    What a body tells of itself counts from its first move on.
    """
    model, count, parameters = flock.model, len(flock.ids), flock.parameters
    vehicle = model.body.vehicle
    if vehicle is None:
        return None

    def signal(name: str) -> np.ndarray:
        return np.array(flock.signal(name)) if name in model.columns else np.zeros(count)

    ready = signal(vehicle.fresh) == 0.0
    stuck = np.where(ready, signal(vehicle.stuck), 0.0)
    return Cars(
        length=float(getattr(parameters, "length", vehicle.length)),
        width=float(getattr(parameters, "width", vehicle.width)),
        steering=np.where(ready, signal(vehicle.steering), 0.0),
        stuck=(stuck > HELD) | (stuck < 0.0),
        predator=signal(model.rule.hunters) == 1.0,
    )
