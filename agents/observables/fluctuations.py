"""How an order parameter fluctuates over a run: susceptibility and Binder's cumulant."""

from __future__ import annotations

import math

import numpy as np

from agents.observables.array_checks import column, length, together


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
    _, series = together(series=column("series", series))
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
    series = np.abs(together(series=column("series", series))[1])
    if not series.any():
        return math.nan
    square = np.square(series / series.max())
    return float(1.0 - np.mean(square**2) / (3.0 * np.mean(square) ** 2))
