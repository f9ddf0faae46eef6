"""What runs say of a mean: one interval for every kind of claim.

A claim is about the mean of a measure over all runs that could be made; the runs that were made are
a sample of them. In this order:

1. a run that was given up is known to lie within limits and no more: the low limit of the mean
   comes from the least values that the runs can have, the high limit from the largest;
2. equal runs say nothing of the spread: only declared bounds of the measure give an interval;
3. successes (0 or 1) are counted: the exact binomial interval;
4. all else, whole numbers too: the wider, on each side, of Student's t and of the t that Hall 1992
   corrected for skewness, both with fewer degrees of freedom than a normal law would give.

All functions work along the last axis, on one sample (R,) or on many at once (M, R), so that
`benchmarks/studies/judge.py` can count how often they are wrong. Sources: Johnson 1978 (J. Am.
Stat. Assoc. 73, 536), Hall 1992 (J. R. Stat. Soc. B 54, 221), Welch 1947 (Biometrika 34, 28), Zhou
and Dinh 2005 (Biostatistics 6, 187), Clopper and Pearson 1934 (Biometrika 26, 404), Zou and Donner
2008 (Stat. Med. 27, 1693), Manski 1989 (J. Hum. Resour. 24, 343), Holm 1979 (Scand. J. Stat. 6,
65).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from worlds.number_text import counted

CONFIDENCE = 0.99
"""Of a word that is said of one claim alone."""
INTERVAL_CONFIDENCE = 0.95
"""Of the interval of a mean that is shown beside it."""
FEWEST_RUNS = 5
"""Runs below which no word is said of a mean."""
PUBLISHED_RUNS = 100
"""Runs behind a published mean where the paper does not say how many."""
KURTOSIS = 2.5
"""Excess kurtosis that runs are taken to have. The variance of s^2 then is that of a normal sample
with (R - 1) / (1 + KURTOSIS / 2) degrees of freedom. By simulation: the least at which 95 %
intervals of lognormal(1) runs cover 93 % from five runs on, with a margin."""
WIDEST = 2.0
"""How much wider the correction for skewness may make a side. Without this cap 78 %, not 96 %, of
effects of one standard deviation are seen in 100 lognormal(1) runs; few false words come of it."""
EQUAL = 1e-9
"""Spread, as a share of the largest value, up to which runs count as equal: rounding."""


class MeanEstimate(NamedTuple):
    """A mean, or a difference of means, with what its interval needs; each an array (...,)."""

    mean: np.ndarray
    error: np.ndarray
    """Standard error; 0 where the runs are equal."""
    freedom: np.ndarray
    """Degrees of freedom of the standard error if the runs were normal."""
    skewness: np.ndarray
    """Of the mean, not of a run: third cumulant over the cube of the error."""
    lean: np.ndarray
    """Covariance of the mean with the square of its error, over the cube of the error. It equals
    the skewness where all of the error is estimated from the sample that gives the mean."""


class ConfidenceInterval(NamedTuple):
    """What a mean lies between at some confidence; infinite where nothing is known. Arrays."""

    low: np.ndarray
    high: np.ndarray


def estimate_mean(values: np.ndarray, scale: float = 0.0) -> MeanEstimate:
    """The mean of independent runs (..., R), finite, R >= 1.

    `scale`: the largest of the numbers that they are differences of, whose rounding they carry.

    >>> estimate_mean(np.array([1.0, 2.0, 3.0])).mean
    array(2.)
    """
    values = np.asarray(values, float)
    runs = values.shape[-1]
    mean = np.asarray(values.mean(axis=-1))
    off = values - mean[..., None]
    squares = np.square(off).sum(axis=-1)
    equal = np.ptp(values, axis=-1) <= EQUAL * np.maximum(np.abs(values).max(axis=-1), scale)
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.where(equal, 0.0, np.sqrt(squares / (runs * (runs - 1.0))))
        skewness = np.where(equal, 0.0, (off**3).sum(axis=-1) / squares**1.5)
    return MeanEstimate(mean, error, np.full(mean.shape, runs - 1.0), skewness, skewness)


def typical_spread(values: np.ndarray) -> np.ndarray:
    """What "within one standard deviation of a run" is judged by, values (..., R) -> (...,).

    The lesser of the standard deviation and sqrt(pi / 2) mean absolute deviations, which are the
    same for a normal law: a few far runs would else make any two means agree.
    """
    off = np.abs(values - np.mean(values, axis=-1, keepdims=True))
    deviation = np.sqrt(np.square(off).sum(axis=-1) / max(off.shape[-1] - 1, 1))
    return np.minimum(deviation, math.sqrt(0.5 * math.pi) * off.mean(axis=-1))


def subtract_means(a: MeanEstimate, b: MeanEstimate) -> MeanEstimate:
    """The difference a - b of two independent samples (Welch 1947; Zhou and Dinh 2005).

    A sample of equal runs, or of fewer runs than the other, is given no smaller spread than the
    other: a few skewed runs often show a small one by chance.
    """
    runs_a, runs_b = a.freedom + 1.0, b.freedom + 1.0
    variance_a, variance_b = a.error**2 * runs_a, b.error**2 * runs_b
    larger = np.maximum(variance_a, variance_b)
    lacking_a, lacking_b = (
        (a.error == 0.0) | (runs_a < runs_b),
        (b.error == 0.0) | (runs_b < runs_a),
    )
    part_a = np.where(lacking_a, larger, variance_a) / runs_a
    part_b = np.where(lacking_b, larger, variance_b) / runs_b
    error = np.sqrt(part_a + part_b)
    with np.errstate(divide="ignore", invalid="ignore"):
        freedom = error**4 / (part_a**2 / a.freedom + part_b**2 / b.freedom)
        skewness = (a.skewness * part_a**1.5 - b.skewness * part_b**1.5) / error**3
    freedom = np.where(error > 0.0, freedom, 1.0)
    skewness = np.where(error > 0.0, skewness, 0.0)
    return MeanEstimate(a.mean - b.mean, error, freedom, skewness, skewness)


def subtract_published(
    estimate: MeanEstimate,
    mean: float | np.ndarray,
    deviation: float | np.ndarray | None = None,
    runs: int | None = None,
) -> MeanEstimate:
    """Our mean less a published one, whose runs are taken to be as skewed as ours.

    `deviation`: of the published runs; where it is not known ours stands for it, so that the error
    depends on our runs alone. `runs`: how many were published, or `PUBLISHED_RUNS`.
    """
    count = runs or PUBLISHED_RUNS
    ratio = np.sqrt((estimate.freedom + 1.0) / count)
    error = (
        estimate.error * ratio if deviation is None else np.asarray(deviation) / math.sqrt(count)
    )
    error = np.broadcast_to(error, np.shape(estimate.error))
    freedom = np.full(np.shape(estimate.error), max(count - 1.0, 1e-3))
    skewness = estimate.skewness * ratio
    other = MeanEstimate(np.asarray(mean, float), error, freedom, skewness, skewness)
    difference = subtract_means(estimate, other)
    if deviation is not None:
        return difference
    with np.errstate(divide="ignore", invalid="ignore"):
        lean = np.where(
            difference.error > 0.0, estimate.skewness * estimate.error / difference.error, 0.0
        )
    return difference._replace(freedom=estimate.freedom, lean=lean)


def mean_interval(estimate: MeanEstimate, confidence: float = CONFIDENCE) -> ConfidenceInterval:
    """What the mean lies between; infinite for runs that are equal or of which there is one.

    Hall's y = t + a t^2 + a^2 t^3 / 3 + b has no skewness to first order; solved for t it is
    ((1 + 3 a (y - b))^(1/3) - 1) / a. For a mean of skewness k, a = k / 3 and b = k / 6.
    """
    from scipy.special import stdtrit

    freedom = np.maximum(estimate.freedom / (1.0 + 0.5 * KURTOSIS), 1e-3)
    y = stdtrit(freedom, 0.5 * (1.0 + confidence))
    a = (3.0 * estimate.lean - estimate.skewness) / 6.0
    b = 0.5 * estimate.lean - a
    straight = np.abs(a) < 1e-6  # then t = y - b is the limit, and 0 / 0 is not
    a = np.where(straight, 1.0, a)
    below = np.where(straight, y - b, (np.cbrt(1.0 + 3.0 * a * (y - b)) - 1.0) / a)
    above = np.where(straight, y + b, (1.0 - np.cbrt(1.0 - 3.0 * a * (y + b))) / a)
    below, above = (np.clip(side, y, WIDEST * y) for side in (below, above))
    has_error = estimate.error > 0.0
    low = np.where(has_error, estimate.mean - below * estimate.error, -np.inf)
    high = np.where(has_error, estimate.mean + above * estimate.error, np.inf)
    return ConfidenceInterval(low, high)


def bounded_interval(
    least: np.ndarray,
    most: np.ndarray,
    bounds: tuple[float, float] = (-math.inf, math.inf),
    confidence: float = CONFIDENCE,
    *,
    rare: bool = False,
    scale: float = 0.0,
) -> ConfidenceInterval:
    """What the mean of runs lies between, of which each lies within [least, most], (..., R).

    An infinite limit of a run makes that side infinite, unless the measure has `bounds`, which no
    run is outside of. With q = (alpha / 2)^(1 / R): if more than a share 1 - q of all runs were
    unlike the R that were made, none of them would be missed more often than alpha / 2. So equal
    runs of value v have a mean of at least q v + (1 - q) bound. `rare`: allow for such runs always
    at a finite bound, as for crashes, which a few runs may not show.

    >>> low, high = bounded_interval(np.ones(20), np.ones(20), (0.0, 1.0))
    >>> round(float(low), 3), float(high)
    (0.767, 1.0)
    """
    least, most = np.maximum(least, bounds[0]), np.minimum(most, bounds[1])
    share = (0.5 * (1.0 - confidence)) ** (1.0 / least.shape[-1])
    low = low_limit(least, bounds[0], share, confidence, rare, scale)
    high = -low_limit(-most, -bounds[1], share, confidence, rare, scale)
    return ConfidenceInterval(low, high)


def low_limit(
    values: np.ndarray, bound: float, share: float, confidence: float, rare: bool, scale: float
) -> np.ndarray:
    """The low limit of the mean of values (..., R) of which none is below a bound."""
    unknown = np.isinf(values).any(axis=-1)
    estimate = estimate_mean(np.where(unknown[..., None], 0.0, values), scale)
    low = mean_interval(estimate, confidence).low
    return np.where(unknown, -np.inf, bounded_low(estimate, low, bound, share, rare))


def bounded_low(
    estimate: MeanEstimate, low: np.ndarray, bound: float, share: float, rare: bool
) -> np.ndarray:
    """The low limit of a mean, if no run is below a bound, of that without a bound."""
    mean = np.asarray(estimate.mean, float)
    floor = (
        share * mean + (1.0 - share) * bound
        if math.isfinite(bound)
        else np.full_like(mean, -np.inf)
    )
    is_rare = rare and math.isfinite(bound)
    low = np.where(estimate.error == 0.0, floor, np.minimum(low, floor) if is_rare else low)
    return np.maximum(low, bound)


def share_interval(
    good: int | np.ndarray, runs: int, confidence: float = CONFIDENCE
) -> ConfidenceInterval:
    """What the share of all runs lies between if `good` of `runs` > 0 are so (exact).

    >>> low, high = share_interval(100, 100)
    >>> float(low) == 0.005 ** (1 / 100), float(high)
    (True, 1.0)
    """
    from scipy.special import betaincinv

    good = np.asarray(good, float)
    tail = 0.5 * (1.0 - confidence)
    low = np.where(good > 0, betaincinv(np.maximum(good, 1.0), runs - good + 1.0, tail), 0.0)
    missing = np.maximum(runs - good, 1.0)
    high = np.where(good < runs, betaincinv(good + 1.0, missing, 1.0 - tail), 1.0)
    return ConfidenceInterval(low, high)


def share_difference(
    good: int, runs: int, other_good: int, other_runs: int, confidence: float = CONFIDENCE
) -> ConfidenceInterval:
    """What the first share less the second lies between (Zou and Donner 2008)."""
    share, other = good / runs, np.asarray(other_good) / other_runs
    a = share_interval(good, runs, confidence)
    b = share_interval(other_good, other_runs, confidence)
    low = share - other - np.hypot(share - a.low, b.high - other)
    high = share - other + np.hypot(a.high - share, other - b.low)
    return ConfidenceInterval(low, high)


def survives_holm(p_values: np.ndarray, alpha: float = 1.0 - CONFIDENCE) -> np.ndarray:
    """Which of several words, of p-values (K,), are all true in 1 - alpha of all tables (bool).

    >>> survives_holm(np.array([0.004, 0.3, 0.002]))
    array([ True, False,  True])
    """
    p_values = np.asarray(p_values, float)
    order = np.argsort(p_values)
    passed = p_values[order] <= alpha / np.arange(order.size, 0, -1)
    survives = np.empty(order.size, bool)
    survives[order] = np.logical_and.accumulate(passed)
    return survives


def confidence_of_look(first: int = 10, most: int = 160) -> float:
    """The confidence of each word said at first, 2 first, 4 first ... most runs while they come in.

    >>> round(confidence_of_look(), 3)
    0.998
    """
    looks = int(math.log2(most / first) + 1e-9) + 1
    return 1.0 - (1.0 - CONFIDENCE) / looks


@dataclass(frozen=True)
class RunRanges:
    """What runs have given, (R,): a value each, or the range that a run given up is known to be in.

    Sums and differences keep what is known: `b.minus(a)`, run by run, `a.times(-1.0).plus(3.0)`.
    """

    least: np.ndarray
    most: np.ndarray
    bounds: tuple[float, float] = (-math.inf, math.inf)
    """What no run at all is outside of."""
    binary: bool = False
    """Whether each run gives one of the two bounds and nothing between: successes are counted."""
    rare: bool = False
    """Whether a few runs may be far from all others, so that a small sample may show none."""
    scale: float = 0.0
    """The largest of the numbers that these are differences of."""

    @property
    def runs(self) -> int:
        """R."""
        return self.least.size

    @property
    def open_runs(self) -> int:
        """Runs of which only a range is known."""
        return int((self.least < self.most).sum())

    @property
    def estimate(self) -> MeanEstimate:
        """The mean of the least values, finite ones."""
        return estimate_mean(self.least, self.scale)

    @property
    def are_limited(self) -> bool:
        """Whether there are open runs, and of each it is known how long it lasted at least.

        Of a run without a value no more is known than the bounds of the measure.
        """
        least = self.least[self.least != self.most]
        return bool(least.size) and bool((np.isfinite(least) & (least > self.bounds[0])).all())

    @property
    def open_words(self) -> str:
        """How many runs are open, and why."""
        how = "given up" if self.are_limited else "without a value"
        return f"{self.open_runs} of {counted(self.runs, 'run')} {how}"

    @property
    def are_equal(self) -> bool:
        """Whether there is no spread in what is known."""
        return self.open_runs == 0 and not bool(self.estimate.error > 0.0)

    def interval(self, confidence: float = CONFIDENCE) -> tuple[float, float]:
        """What the mean over all runs that could be made lies between."""
        if self.runs == 0:
            return self.bounds
        if self.binary and self.open_runs == 0:
            low, high = self.bounds
            good = int((self.least > 0.5 * (low + high)).sum())
            share = share_interval(good, self.runs, confidence)
            return low + (high - low) * float(share.low), low + (high - low) * float(share.high)
        limits = bounded_interval(
            self.least, self.most, self.bounds, confidence, rare=self.rare, scale=self.scale
        )
        return float(limits.low), float(limits.high)

    def subtract(self, other: RunRanges) -> RunRanges:
        """What these have more than others, run by run."""
        (low, high), (other_low, other_high) = self.bounds, other.bounds
        return RunRanges(
            self.least - other.most,
            self.most - other.least,
            (low - other_high, high - other_low),
            rare=self.rare or other.rare,
            scale=max(self.scale, other.scale, largest(self.least), largest(other.least)),
        )

    def times(self, factor: float) -> RunRanges:
        """Each times a factor that is not 0."""
        ends = factor * self.least, factor * self.most
        bounds = factor * self.bounds[0], factor * self.bounds[1]
        scale = abs(factor) * max(self.scale, largest(self.least))
        if factor < 0.0:
            ends, bounds = ends[::-1], bounds[::-1]
        return RunRanges(*ends, bounds, self.binary, self.rare, scale)

    def add(self, value: float) -> RunRanges:
        """Each and a value."""
        bounds = self.bounds[0] + value, self.bounds[1] + value
        scale = max(self.scale, largest(self.least), abs(value))
        least, most = self.least + value, self.most + value
        return RunRanges(least, most, bounds, self.binary, self.rare, scale)


def largest(values: np.ndarray) -> float:
    """The largest size of a finite one of values (R,); 0 where there is none."""
    sizes = np.abs(values[np.isfinite(values)])
    return float(sizes.max()) if sizes.size else 0.0


def ranges_of(values: Sequence[float | None] | np.ndarray, limit: float | None = None) -> RunRanges:
    """Runs of an unbounded measure; None: given up, at least at `limit` where there is one."""
    least = [
        (-math.inf if limit is None else limit) if value is None else value for value in values
    ]
    most = [math.inf if value is None else value for value in values]
    return RunRanges(np.array(least, float), np.array(most, float))


def likely_interval(
    values: RunRanges, runs: int, confidence: float = CONFIDENCE
) -> ConfidenceInterval:
    """The interval that so many runs like these, all of which ended, would give."""
    low, high = values.bounds
    if values.binary:
        limits = share_interval(likely_good(values, runs), runs, confidence)
        return ConfidenceInterval(low + (high - low) * limits.low, low + (high - low) * limits.high)
    estimate = scale_estimate(values.estimate, values.runs, runs)
    below = mean_interval(estimate, confidence)
    share = (0.5 * (1.0 - confidence)) ** (1.0 / runs)
    mirrored = estimate._replace(mean=-estimate.mean)
    return ConfidenceInterval(
        bounded_low(estimate, below.low, low, share, values.rare),
        -bounded_low(mirrored, -below.high, -high, share, values.rare),
    )


def likely_good(values: RunRanges, runs: int) -> int:
    """Successes that so many runs like these, which are counted, would have."""
    low, high = values.bounds
    return round(runs * (float(values.least.mean()) - low) / (high - low))


def scale_estimate(estimate: MeanEstimate, runs: int, others: int) -> MeanEstimate:
    """An estimate of `runs` runs as it would be of so many others like them."""
    ratio = math.sqrt(runs / others)
    return MeanEstimate(
        estimate.mean,
        estimate.error * ratio,
        np.full(np.shape(estimate.mean), others - 1.0),
        estimate.skewness * ratio,
        estimate.lean * ratio,
    )
