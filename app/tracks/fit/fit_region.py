"""Which values of the parameters the frames cannot tell from the best: a paired bootstrap.

The cost of a cell is compared with that of the best cell frame by frame: the noise of a frame,
which raises both alike, drops out. "Within 5 % of the best cost" is no region: it grows with the
floor of the noise, and not with ignorance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.tracks.fit.fitted_parameter import FittedParameter

RESAMPLES = 1000
CONFIDENCE = 0.95
AT_ONCE = 2000
"""Cells of which the resamples are held in memory."""


def resampled_means(values: np.ndarray, seed: int = 0, resamples: int = RESAMPLES) -> np.ndarray:
    """Means of values (..., F) over frames that are drawn again and again, (resamples, ...)."""
    frames = values.shape[-1]
    draws = np.random.default_rng(seed).multinomial(
        frames, np.full(frames, 1.0 / frames), resamples
    )
    return np.tensordot(draws / frames, values, axes=(1, -1))


def mean_interval(values: np.ndarray, seed: int = 0) -> tuple[float, float]:
    """The interval of the mean of values (F,) by bootstrap, at 95 %."""
    means = resampled_means(values, seed)
    low, high = np.quantile(means, [0.5 - CONFIDENCE / 2, 0.5 + CONFIDENCE / 2])
    return float(low), float(high)


def cells_like_best(costs: np.ndarray, best: int, seed: int = 0) -> np.ndarray:
    """Which cells the frames cannot tell from the best, (C,) bool, of costs (C, F).

    A cell is among them if the 95 % interval of its cost minus that of the best reaches down to 0.
    Cells without costs (NaN) are not.
    """
    is_like = np.zeros(len(costs), bool)
    for begin in range(0, len(costs), AT_ONCE):
        some = costs[begin : begin + AT_ONCE] - costs[best]
        low = np.quantile(resampled_means(some, seed), 0.5 - CONFIDENCE / 2, axis=0)
        is_like[begin : begin + AT_ONCE] = low <= 0.0
    is_like[best] = True
    return is_like


@dataclass(frozen=True)
class ParameterRegion:
    """What the frames tell of one parameter."""

    name: str
    unit: str
    best: float
    low: float
    high: float
    """The least and the largest value in the region."""
    is_open_below: bool
    is_open_above: bool
    """Whether the region ends where the values tried do, and so may go on."""
    is_told: bool
    """Whether it has both ends, and is no more than half of what was tried."""

    def describe(self) -> str:
        """What is told of it, in words: `dr_o 2 to 5`, `dr_a not told (8 to 16 and above)`."""
        ends = f"{self.low:g}" if self.low == self.high else f"{self.low:g} to {self.high:g}"
        ends += " and below" if self.is_open_below else ""
        ends += " and above" if self.is_open_above else ""
        return f"{self.name} {ends}" if self.is_told else f"{self.name} not told ({ends})"


def parameter_regions(
    parameters: Sequence[FittedParameter], points: np.ndarray, is_like: np.ndarray, best: int
) -> tuple[ParameterRegion, ...]:
    """What a region of cells says of each parameter; points (C, D), is_like (C,) bool."""
    regions = []
    for column, parameter in enumerate(parameters):
        inside = points[is_like, column]
        low, high = float(inside.min()), float(inside.max())
        first, last = parameter.range
        is_open_below = low == first and not parameter.is_floor
        is_open_above = high == last and not parameter.is_ceiling
        span = sum(low <= value <= high for value in parameter.values)
        is_told = not (is_open_below or is_open_above) and 2 * span <= len(parameter.values)
        regions.append(
            ParameterRegion(
                *(parameter.name, parameter.unit, float(points[best, column]), low, high),
                *(is_open_below, is_open_above, is_told),
            )
        )
    return tuple(regions)


def has_moved(
    parameters: Sequence[FittedParameter],
    first: Sequence[ParameterRegion],
    second: Sequence[ParameterRegion],
) -> bool:
    """Whether the bests of two windows are further apart than the regions allow.

    The best of one has to lie in the region of the other, give or take a step of the grid: else
    what is found hangs on how the tracks were smoothed.
    """

    def is_outside(parameter: FittedParameter, value: float, region: ParameterRegion) -> bool:
        values = np.array(parameter.values)
        step = float(np.diff(values).max()) if len(values) > 1 else 0.0
        return not region.low - step <= value <= region.high + step

    return any(
        is_outside(parameter, b.best, a) and is_outside(parameter, a.best, b)
        for parameter, a, b in zip(parameters, first, second, strict=True)
    )
