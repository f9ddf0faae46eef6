"""Lanes: how far those who pass each other keep apart sideways, along the x axis."""

from __future__ import annotations

import math

import numpy as np

from agents.observables.array_checks import box, drop_bad_rows, units, vectors
from worlds.input_error import InputError


def lane_order(
    position: np.ndarray,
    heading: np.ndarray,
    size: np.ndarray,
    images: np.ndarray,
    width: float | None = None,
) -> float:
    """Lane order: the mean of ((n+ - n-) / (n+ + n-))^2 over the strips about each agent.

    Of the agents in a strip along x of a width about an agent, itself among them, n+ head for +x
    and n- for -x. So Nowak and Schadschneider 2012 measure it in the rows of a grid; Dzubiella et
    al. 2002 have it per agent.

    Parameters
    ----------
    position: (N, dim), length. heading: (N, dim), unit vectors. size: (dim,) sides of the box > 0,
    images: (dim,) bool, axes along which agents are seen across the seam. In space strips stand
    upright: the height of agents makes no difference.
    width: of a strip, length > 0; by default half the mean distance of agents, sqrt(A / N) / 2 of a
    box of area A.

    Returns
    -------
    A number in [0, 1]: 1 where each strip has one direction only, about 1 / n where n agents of a
    strip are mixed by chance; 1 for a lone agent, 0 for none. Rows of which a number is missing are
    left out, with a warning. Raises InputError.

    >>> places = np.array([[1.0, 1.0], [4.0, 1.0], [2.0, 8.0], [7.0, 8.0]])
    >>> ways = np.array([[1.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [-1.0, 0.0]])
    >>> lane_order(places, ways, np.array([10.0, 10.0]), np.zeros(2, bool))
    1.0
    """
    position, heading = vectors("position", position), vectors("heading", heading)
    _, position, heading = drop_bad_rows(position=position, heading=heading)
    units(heading)
    size, images = box(size, images, position.shape[1])
    n = len(position)
    if n == 0:
        return 0.0
    width = 0.5 * math.sqrt(size[0] * size[1] / n) if width is None else width
    if not 0.0 < width < math.inf:
        raise InputError(f"width = {width} is not allowed: a finite length > 0 is needed")
    low, high, sums = strips(position[:, 1], heading[:, 0] >= 0.0, size[1], images[1], width)
    difference, number = sums[:, high] - sums[:, low]
    return float(np.mean((difference / number) ** 2))


def strips(y: np.ndarray, forward: np.ndarray, side: float, image: bool, width: float):
    """Where the strip about each y (N,) begins and ends in running sums, and these sums (2, M).

    The sums are of +1 and -1 for those that are `forward` or not, and of 1 for each, in the order
    of y.
    """
    sign = np.where(forward, 1.0, -1.0)
    half = 0.5 * width
    if image:
        y, half = y % side, min(half, np.nextafter(0.5 * side, 0.0))
        along = np.concatenate([y - side, y, y + side])
        sign = np.tile(sign, 3)
    else:
        along = y
    order = np.argsort(along, kind="stable")
    along, sign = along[order], sign[order]
    sums = np.zeros((2, len(along) + 1))
    np.cumsum(sign, out=sums[0, 1:])
    sums[1] = np.arange(len(along) + 1)
    return (
        np.searchsorted(along, y - half, side="left"),
        np.searchsorted(along, y + half, side="right"),
        sums,
    )
