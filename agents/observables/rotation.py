"""Angular momentum: how much a group mills about its centre (Couzin et al. 2002, (5))."""

from __future__ import annotations

import numpy as np

from agents.observables.array_checks import box, together, units, vectors

EXACT = 2.0**-52
"""Relative rounding error of a coordinate."""


def centre(position: np.ndarray, size: np.ndarray, images: np.ndarray) -> np.ndarray:
    """The group's centre (dim,), length; along axes with images the mean on the circle.

    `position` (N, dim), `size` (dim,) sides of the box > 0, `images` (dim,) bool. nan for nobody;
    positions that are no numbers are left out, with a warning. Raises InputError.
    """
    _, position = together(position=vectors("position", position))
    size, images = box(size, images, position.shape[1])
    if len(position) == 0:
        return np.full(position.shape[1], np.nan)
    return middle(position, size, images)


def middle(position: np.ndarray, size: np.ndarray, images: np.ndarray) -> np.ndarray:
    """`centre` of arrays that are checked, of at least one agent."""
    turn = 2.0 * np.pi * position / size
    round_ = np.arctan2(np.sin(turn).mean(axis=0), np.cos(turn).mean(axis=0)) % (2.0 * np.pi)
    return np.where(images, round_ / (2.0 * np.pi) * size, position.mean(axis=0))


def angular_momentum(
    position: np.ndarray, heading: np.ndarray, size: np.ndarray, images: np.ndarray
) -> float:
    """|1/N sum of r_ic x u_i| in [0, 1], r_ic the direction from the group's centre to agent i.

    `position` (N, dim), length, and `heading` (N, dim), unit vectors; `size` (dim,) sides of the
    box > 0, `images` (dim,) bool. An agent at the centre, to within rounding errors, adds nothing:
    so a lone agent has 0, and an empty group too. Rows of which a number is missing are left out,
    with a warning. Raises InputError.

    >>> ring = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    >>> round_the_centre = np.array([[0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, 0.0]])
    >>> angular_momentum(ring, round_the_centre, np.ones(2), np.zeros(2, bool))
    1.0
    """
    position, heading = vectors("position", position), vectors("heading", heading)
    _, position, heading = together(position=position, heading=heading)
    units(heading)
    size, images = box(size, images, position.shape[1])
    if len(position) == 0:
        return 0.0
    apart = position - middle(position, size, images)
    apart = apart - np.where(images, size * np.round(apart / size), 0.0)
    largest = float(np.max(np.abs(position)))
    along = outward(apart, rounding(len(position), np.array(largest), size, images))
    if position.shape[1] == 2:
        turning = abs(along[:, 0] @ heading[:, 1] - along[:, 1] @ heading[:, 0]) / len(along)
    else:
        turning = np.linalg.norm(np.cross(along, heading).mean(axis=0))
    return min(1.0, float(turning))


def outward(apart: np.ndarray, error) -> np.ndarray:
    """Unit vectors along `apart` (N, dim), length; zeros where it is not longer than `error`."""
    far = np.linalg.norm(apart, axis=1, keepdims=True)
    return np.divide(apart, far, out=np.zeros_like(apart), where=far > error)


def rounding(n, largest: np.ndarray, size: np.ndarray, images: np.ndarray):
    """How far the centre of n agents can be off by rounding alone, length.

    `largest` is their largest coordinate without its sign; `n` and it broadcast. Each addition errs
    by a share of the sum, and along an axis with images so do the sine and the cosine of the box.
    """
    return (64 + n) * EXACT * np.maximum(largest, np.max(size[images], initial=0.0))
