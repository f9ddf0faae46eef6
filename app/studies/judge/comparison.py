"""A measured mean beside a published one: agrees, differs, or more runs would decide."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from app.studies.experiment_file import PublishedMeasure
from app.studies.judge.claim_verdict import decide, least_runs
from app.studies.judge.judge import (
    CONFIDENCE,
    FEWEST_RUNS,
    PUBLISHED_RUNS,
    ConfidenceInterval,
    MeanEstimate,
    RunRanges,
    estimate_mean,
    likely_good,
    likely_interval,
    mean_interval,
    ranges_of,
    scale_estimate,
    share_difference,
    subtract_published,
    typical_spread,
)
from worlds.number_text import counted

TOLERANCE = 1.0
"""Standard deviations of a single run within which means count as the same, once it is sure that
they are no further apart."""
NOTE = (
    "differs: the means are told apart at 99 % (t, corrected for skewness); agrees: at 99 % they "
    "are less than a standard deviation of one run apart; undecided, n: about n runs would decide; "
    "fewer than five runs, and equal runs, decide nothing; a run that was given up counts as its "
    "limit or more"
)
SPREAD_NOTE = (
    "the paper gives no spread, so that the one measured here stands for its 100 runs too; z and "
    "d: measured less published mean, in standard errors and in standard deviations of a run"
)
WELCH_NOTE = (
    "published runs are compared as runs, each sample with its own spread, the smaller sample with "
    "that of the larger where it is less (Welch); z and d: measured less published mean, in "
    "standard errors and in standard deviations of a run"
)
ComparisonWord = Literal["agrees", "differs", "undecided", "by construction"]


@dataclass(frozen=True)
class MeanComparison:
    """A measured and a published mean; NaN stands for what a sample without spread does not say."""

    word: ComparisonWord
    difference: float
    """Measured less published mean; of runs given up: at least."""
    interval: tuple[float, float] = (math.nan, math.nan)
    """Of the difference, 99 %; infinite where nothing is known."""
    z: float = math.nan
    """The difference in standard errors."""
    effect: float = math.nan
    """The difference in standard deviations of a run: Cohen's d."""
    needed: int | None = None
    """Of an undecided one: runs that would decide it, about; None if that is not known."""
    why: str = ""
    """What keeps it undecided, other than the number of runs; or why it cannot but agree."""
    p: float = 1.0
    """The chance, at most, with which runs give this word where it is false; 1 if undecided."""

    def __str__(self) -> str:
        return self.word if self.needed is None else f"{self.word}, {self.needed}"


def compare(values: RunRanges, published: PublishedMeasure) -> MeanComparison | None:
    """How measured runs stand beside what was published; None without runs or a mean."""
    comparison = compare_means(values, published)
    why = published.by_construction
    if comparison is None or not why or comparison.word == "differs":
        return comparison
    return replace(comparison, word="by construction", needed=None, why=why, p=1.0)


def compare_means(values: RunRanges, published: PublishedMeasure) -> MeanComparison | None:
    """The same, whatever can come out."""
    mean = published.average
    if mean is None or values.runs == 0 or np.isinf(values.least).any():
        return None
    difference = float(values.estimate.mean) - mean
    published_values = np.array(published.values, float)
    comparison = MeanComparison("undecided", difference, needed=FEWEST_RUNS)
    if values.runs > 1 and not values.open_runs:
        z, effect = effect_sizes(values, published_values, mean)
        comparison = replace(comparison, z=z, effect=effect)
    if values.runs < FEWEST_RUNS:
        return comparison
    tolerance = TOLERANCE * float(typical_spread(values.least))

    def word_at(confidence: float) -> ComparisonWord:
        return difference_word(
            difference_limits(values, published_values, mean, confidence), tolerance
        )

    word, p = decide(word_at)
    limits = difference_limits(values, published_values, mean, CONFIDENCE)
    needed, why = (
        (None, "")
        if word != "undecided"
        else describe_lack(values, published_values, mean, tolerance)
    )
    interval = float(limits.low), float(limits.high)
    return replace(comparison, word=word, interval=interval, needed=needed, why=why, p=p)


def effect_sizes(
    values: RunRanges, published_values: np.ndarray, mean: float
) -> tuple[float, float]:
    """The difference in standard errors, z, and in standard deviations of a run, Cohen's d."""
    found = difference_of(values.estimate, published_values, mean)
    own_deviation = float(values.least.std(ddof=1))
    other = float(published_values.std(ddof=1)) if published_values.size > 1 else own_deviation
    scale, error = math.sqrt(0.5 * (own_deviation**2 + other**2)), float(found.error)
    difference = float(found.mean)
    z = difference / error if error > 0.0 else math.nan
    return z, difference / scale if scale > 0.0 else math.nan


def difference_word(limits: ConfidenceInterval, tolerance: float) -> ComparisonWord:
    """What a difference says."""
    if limits.low > 0.0 or limits.high < 0.0:
        return "differs"
    return "agrees" if -tolerance < limits.low and limits.high < tolerance else "undecided"


def difference_of(
    estimate: MeanEstimate, published_values: np.ndarray, mean: float
) -> MeanEstimate:
    """Our mean less a published one; of published runs (R,), or none but their mean."""
    if published_values.size < 2:
        return subtract_published(estimate, mean, runs=published_values.size or None)
    return subtract_published(
        estimate,
        mean,
        float(estimate_mean(published_values).error) * math.sqrt(published_values.size),
        published_values.size,
    )


def difference_limits(
    values: RunRanges, published_values: np.ndarray, mean: float, confidence: float
) -> ConfidenceInterval:
    """What the difference lies between."""
    if values.binary and published_values.size and not values.open_runs:
        low, high = values.bounds
        middle = 0.5 * (low + high)
        good, other = int((values.least > middle).sum()), int((published_values > middle).sum())
        found = share_difference(good, values.runs, other, published_values.size, confidence)
        return ConfidenceInterval((high - low) * found.low, (high - low) * found.high)
    difference = difference_of(values.estimate, published_values, mean)
    if float(difference.error) == 0.0 or values.binary:
        return bounded_difference(values, published_values, mean, confidence)
    limits = mean_interval(difference, confidence)
    if values.rare:
        ours = values.estimate, values.interval(confidence)
        limits = allow_for_rare(limits, difference, *ours, confidence)
    if not values.open_runs:
        return limits
    most = values.bounds[1]
    return ConfidenceInterval(
        limits.low, np.asarray(most - mean if published_values.size == 0 else math.inf)
    )


def allow_for_rare(
    limits: ConfidenceInterval,
    difference: MeanEstimate,
    estimate: MeanEstimate,
    interval: tuple[float, float],
    confidence: float = CONFIDENCE,
) -> ConfidenceInterval:
    """Limits of a difference that allow for runs at a bound which were not seen.

    `interval` of our mean allows for them; by what it is wider, so is the difference.
    """
    plain_low, plain_high = map(float, mean_interval(estimate, confidence))

    def width(half: float, allowed: float, usual: float) -> float:
        return math.sqrt(half**2 + max(0.0, allowed**2 - usual**2))

    mean, middle = float(estimate.mean), float(difference.mean)
    low, high = interval
    return ConfidenceInterval(
        np.asarray(middle - width(middle - float(limits.low), mean - low, mean - plain_low)),
        np.asarray(middle + width(float(limits.high) - middle, high - mean, plain_high - mean)),
    )


def bounded_difference(
    values: RunRanges, published_values: np.ndarray, mean: float, confidence: float
) -> ConfidenceInterval:
    """The same by the bounds of the measure, where no spread is known.

    Published runs of a bounded measure have a standard deviation of sqrt((m - low) (high - m)) at
    most (Bhatia and Davis 2000). Without bounds nothing is known.
    """
    low, high = values.bounds
    our_low, our_high = values.interval(confidence)
    own_mean = float(values.estimate.mean)
    if published_values.size > 1:
        same = ranges_of(published_values)
        their_low, their_high = RunRanges(same.least, same.most, values.bounds).interval(confidence)
        below, above = mean - their_low, their_high - mean
    else:
        most = (
            math.sqrt(max((mean - low) * (high - mean), 0.0))
            if math.isfinite(high - low)
            else math.inf
        )
        published = MeanEstimate(
            np.asarray(mean),
            np.asarray(most / math.sqrt(published_values.size or PUBLISHED_RUNS)),
            np.asarray(PUBLISHED_RUNS - 1.0),
            np.asarray(0.0),
            np.asarray(0.0),
        )
        limits = (
            mean_interval(published, confidence)
            if most > 0.0
            else ConfidenceInterval(published.mean, published.mean)
        )
        below, above = mean - float(limits.low), float(limits.high) - mean
    difference = own_mean - mean
    return ConfidenceInterval(
        np.asarray(difference - math.hypot(own_mean - our_low, above)),
        np.asarray(difference + math.hypot(our_high - own_mean, below)),
    )


def describe_lack(
    values: RunRanges, published_values: np.ndarray, mean: float, tolerance: float
) -> tuple[int | None, str]:
    """Runs that would decide a comparison, about, or else what keeps it undecided."""
    if values.open_runs:
        return None, values.open_words
    if values.are_equal and not values.binary:
        return None, "all runs are equal"

    def decides(runs: int) -> bool:
        if values.binary:
            good, (low, high) = likely_good(values, runs), values.bounds
            sample = np.repeat([low, high], [runs - good, good])
            likely = replace(values, least=sample, most=sample)
            limits = difference_limits(likely, published_values, mean, CONFIDENCE)
        else:
            estimate = scale_estimate(values.estimate, values.runs, runs)
            difference = difference_of(estimate, published_values, mean)
            limits = mean_interval(difference)
            if values.rare:
                low, high = map(float, likely_interval(values, runs))
                limits = allow_for_rare(limits, difference, estimate, (low, high))
        return difference_word(limits, tolerance) != "undecided"

    needed = least_runs(decides, values.runs)
    if needed is None and published_values.size:
        return None, f"the paper gives {counted(published_values.size, 'run')}"
    return needed, ""


def runs_to_agree(published: PublishedMeasure) -> int | None:
    """Runs with which equal means can be told to agree; None if too few runs were published."""
    published_count = len(published.values)

    def decides(runs: int) -> bool:
        unit, none = np.asarray(1.0), np.asarray(0.0)
        estimate = MeanEstimate(none, unit / math.sqrt(runs), unit * (runs - 1.0), none, none)
        spread = None if published_count < 2 else 1.0
        difference = subtract_published(estimate, 0.0, spread, published_count or None)
        return difference_word(mean_interval(difference), TOLERANCE) == "agrees"

    return least_runs(decides, FEWEST_RUNS)
