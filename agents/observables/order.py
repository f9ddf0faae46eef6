"""Measure how far a flock agrees on a heading, and how far it is spread in space and velocity."""

from __future__ import annotations

import math

import numpy as np

from agents.observables.array_checks import (
    box,
    column,
    drop_bad_rows,
    headings,
    length,
    units,
    vectors,
)


def polarisation(heading: np.ndarray) -> float:
    """Polarisation: the length of the mean heading (Vicsek et al. 1995, v_a).

    Parameters
    ----------
    heading: (N, dim) unit vectors, dim 2 or 3; rows that are no numbers are left out.

    Returns
    -------
    A number in [0, 1]: 1 all alike, near 0 for random headings; 0 for an empty flock.

    Raises InputError for what are no unit vectors, and warns of rows left out
    (`agents.observables.array_checks`, as all that measures arrays).

    >>> polarisation(np.array([[1.0, 0.0], [-1.0, 0.0]]))
    0.0
    """
    heading = headings(heading)
    if len(heading) == 0:
        return 0.0
    mean = np.add.reduce(heading) / len(heading)
    return min(1.0, math.sqrt(mean.dot(mean)))


def direction(heading: np.ndarray) -> float:
    """Angle between the mean heading and the x axis, in [0, 180] degrees.

    `heading`: (N, dim) unit vectors, dim 2 or 3; rows that are no numbers are left out, with a
    warning. nan for nobody, and where headings cancel to within rounding errors. Raises InputError.

    >>> direction(np.array([[0.0, 1.0], [-1.0, 0.0]]))
    135.0
    """
    heading = headings(heading)
    if len(heading) == 0:
        return math.nan
    mean = np.add.reduce(heading) / len(heading)
    if math.sqrt(mean.dot(mean)) <= 4 * len(heading) * EXACT:
        return math.nan
    across = math.sqrt(mean[1:].dot(mean[1:]))
    return math.degrees(math.atan2(across, float(mean[0])))


FEWEST = 3
"""Agents below which a rank correlation says nothing."""


def fast_in_front(
    position: np.ndarray, velocity: np.ndarray, size: np.ndarray, images: np.ndarray
) -> float:
    """Spearman's rank correlation of speeds with places along the mean velocity, in [-1, 1].

    `position` (N, dim), length, `velocity` (N, dim), length/time; `size` (dim,) sides of the box
    > 0, `images` (dim,) bool. nan for fewer than three agents, where all are equally fast, and
    where they go no way. Rows of which a number is missing are left out, with a warning. Raises
    InputError.

    >>> in_a_row = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    >>> faster_in_front = np.array([[1.0, 0.0], [2.0, 0.0], [9.0, 0.0]])
    >>> fast_in_front(in_a_row, faster_in_front, np.ones(2), np.zeros(2, bool))
    1.0
    """
    from scipy.stats import rankdata

    position, velocity = vectors("position", position), vectors("velocity", velocity)
    _, position, velocity = drop_bad_rows(position=position, velocity=velocity)
    size, images = box(size, images, position.shape[1])
    if len(position) < FEWEST:
        return math.nan
    speed, way = np.linalg.norm(velocity, axis=1), velocity.mean(axis=0)
    fastest = float(speed.max())
    if np.linalg.norm(way) <= 4 * len(velocity) * EXACT * fastest:
        return math.nan
    offset = position - middle(position, size, images)
    offset = offset - np.where(images, size * np.round(offset / size), 0.0)
    # The length of a vector is rounded: who is as fast as another has the same rank.
    ranks = rankdata(np.round(speed / fastest, 12)), rankdata(offset @ way)
    if min(map(np.ptp, ranks)) == 0.0:
        return math.nan
    return round(float(np.corrcoef(*ranks)[0, 1]), 12)  # 1, not 1 + 2e-16


# Angular momentum: how much a group mills about its centre (Couzin et al. 2002, (5)).

EXACT = 2.0**-52
"""Relative rounding error of a coordinate."""


def centre(position: np.ndarray, size: np.ndarray, images: np.ndarray) -> np.ndarray:
    """The group's centre (dim,), length; along axes with images the mean on the circle.

    `position` (N, dim), `size` (dim,) sides of the box > 0, `images` (dim,) bool. nan for nobody;
    positions that are no numbers are left out, with a warning. Raises InputError.
    """
    _, position = drop_bad_rows(position=vectors("position", position))
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
    _, position, heading = drop_bad_rows(position=position, heading=heading)
    units(heading)
    size, images = box(size, images, position.shape[1])
    if len(position) == 0:
        return 0.0
    offset = position - middle(position, size, images)
    offset = offset - np.where(images, size * np.round(offset / size), 0.0)
    largest = float(np.max(np.abs(position)))
    along = outward_directions(offset, rounding(len(position), np.array(largest), size, images))
    if position.shape[1] == 2:
        turning = abs(along[:, 0] @ heading[:, 1] - along[:, 1] @ heading[:, 0]) / len(along)
    else:
        turning = np.linalg.norm(np.cross(along, heading).mean(axis=0))
    return min(1.0, float(turning))


def outward_directions(offset: np.ndarray, error) -> np.ndarray:
    """Unit vectors along `offset` (N, dim), length; zeros where it is not longer than `error`."""
    length = np.linalg.norm(offset, axis=1, keepdims=True)
    return np.divide(offset, length, out=np.zeros_like(offset), where=length > error)


def rounding(n, largest: np.ndarray, size: np.ndarray, images: np.ndarray):
    """How far the centre of n agents can be off by rounding alone, length.

    `largest` is their largest coordinate without its sign; `n` and it broadcast. Each addition errs
    by a share of the sum, and along an axis with images so do the sine and the cosine of the box.
    """
    return (64 + n) * EXACT * np.maximum(largest, np.max(size[images], initial=0.0))


# How an order parameter fluctuates over a run: susceptibility and Binder's cumulant.


def susceptibility(series: np.ndarray, n: float) -> float:
    """chi = N (<phi^2> - <phi>^2) of an order parameter (Chaté et al. 2008).

    Parameters
    ----------
    series: (K,) values of the order parameter, one for each observed tick of a steady run; ticks
        without a number are left out, with a warning.
    n: number of agents, >= 0; a mean if it changed.

    Returns
    -------
    A number >= 0, at most N/4 for a series within [0, 1]; nan for an empty series. It is largest
    where the flock is about to order. Raises InputError.

    >>> susceptibility(np.array([0.0, 1.0, 0.0, 1.0]), 100)
    25.0
    """
    n = length("n", n)
    _, series = drop_bad_rows(series=column("series", series))
    return float(n * np.var(series)) if len(series) else math.nan


def binder(series: np.ndarray) -> float:
    """Binder's cumulant U = 1 - <phi^4> / (3 <phi^2>^2) of an order parameter (Binder 1981).

    `series` is (K,); ticks without a number are left out, with a warning. At most 2/3, which it is
    for a series that does not change; 1/3 for headings at random in the plane and 4/9 in space,
    both for many agents; below 0 where the flock jumps between order and disorder, of which the
    second is more common. nan for an empty series, or where phi is 0 throughout. Raises InputError.

    >>> round(binder(np.array([0.7, 0.7, 0.7])), 12)
    0.666666666667
    """
    series = np.abs(drop_bad_rows(series=column("series", series))[1])
    if not series.any():
        return math.nan
    square = np.square(series / series.max())
    return float(1.0 - np.mean(square**2) / (3.0 * np.mean(square) ** 2))


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
