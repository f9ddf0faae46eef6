"""How far a flock is spread out, in space and in velocity."""

from __future__ import annotations

import math

import numpy as np

from agents.observables.array_checks import box, drop_bad_rows, vectors
from agents.observables.order import middle


def gyration_radius(position: np.ndarray, size: np.ndarray, images: np.ndarray) -> float:
    """Root of the mean square distance of the agents from their centre, length.

    `position` (N, dim), length; `size` (dim,) sides of the box > 0, `images` (dim,) bool: along
    such axes the centre is the mean on the circle and distances go to the nearest image. 0 for a
    lone agent and for nobody. Rows that are no numbers are left out, with a warning. Or InputError.

    >>> corners = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 4.0], [0.0, 4.0]])
    >>> gyration_radius(corners, np.ones(2), np.zeros(2, bool))
    2.5
    """
    _, position = drop_bad_rows(position=vectors("position", position))
    size, images = box(size, images, position.shape[1])
    if len(position) < 2:
        return 0.0
    offset = position - middle(position, size, images)
    offset = offset - np.where(images, size * np.round(offset / size), 0.0)
    return math.sqrt((offset**2).sum(axis=1).mean())


def velocity_spread(velocity: np.ndarray) -> float:
    """Root of the mean square difference of the velocities from their mean, length/time.

    `velocity` (N, dim). 0 where all agree on a velocity, and for nobody. Rows that are no numbers
    are left out, with a warning. Raises InputError.

    >>> velocity_spread(np.array([[3.0, 4.0], [-3.0, -4.0]]))
    5.0
    """
    _, velocity = drop_bad_rows(velocity=vectors("velocity", velocity))
    if len(velocity) == 0:
        return 0.0
    return math.sqrt(((velocity - velocity.mean(axis=0)) ** 2).sum(axis=1).mean())
