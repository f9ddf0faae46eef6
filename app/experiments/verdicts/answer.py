"""What runs say of a claim, on one scale: it holds, it does not hold, or more runs would decide.

Each word but "undecided" is wrong in at most one case of a hundred. Means are judged by Student's
t, which knows how little a few runs say of their own spread; shares of runs by the exact binomial
bound of Clopper and Pearson 1934.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

CONFIDENCE = 0.99
"""Of every answer."""
NEARLY_ALL = 0.9
"""No number of runs shows that something is so in every run: it is taken to be so if no run breaks
it and at least this share of all runs, at 99 % confidence, does not either."""
MOST = 10**6
"""Runs beyond which a claim counts as one that runs cannot decide."""

ANSWERS_NOTE = (
    "claims are answered at 99 %: of means by Student's t, seed by seed; of shares of runs by the "
    "exact binomial bound; what is said of every run holds if no run breaks it and 9 of 10 of all "
    "runs or more, at 99 %, do not either"
)

Word = Literal["holds", "does not hold", "undecided", "by construction"]


@dataclass(frozen=True)
class Answer:
    """What the runs say of a claim."""

    word: Word
    needed: int | None = None
    """Of an undecided one: runs that would decide it, about; None if none would, or if the spread
    of the runs is not known yet."""

    def __str__(self) -> str:
        if self.word != "undecided":
            return self.word
        if self.needed is None:
            return "undecided"
        return f"undecided (about {self.needed} runs would decide)"


HOLDS, DOES_NOT, UNDECIDED = Answer("holds"), Answer("does not hold"), Answer("undecided")


def interval(values: np.ndarray, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Interval that holds the mean, by Student's t, values (R,) -> (low, high).

    Endless below two values; a point where all are equal.
    """
    if values.size < 2:
        return -math.inf, math.inf
    half = (
        quantile(values.size - 1, confidence) * float(values.std(ddof=1)) / math.sqrt(values.size)
    )
    return float(values.mean()) - half, float(values.mean()) + half


def quantile(freedom: float, confidence: float = CONFIDENCE) -> float:
    """Student's t that is exceeded on either side in a share 1 - confidence of all cases."""
    from scipy.stats import t

    return float(t.ppf(0.5 * (1.0 + confidence), freedom))


def mean_above(margins: np.ndarray, of: int = 1) -> Answer:
    """Whether the mean of margins (R,), of which each run gives one, is above 0.

    `of`: how many such questions are asked at once; each is then answered more strictly, so that
    the whole keeps its confidence (Bonferroni). A few equal margins of whole numbers may be equal
    by chance: where there is no spread the signs are counted.
    """
    wrong = (1.0 - CONFIDENCE) / of
    low, high = interval(margins, 1.0 - wrong)
    if low == high and 0.5**margins.size > wrong:
        return Answer("undecided", least(lambda n: 0.5**n <= wrong))
    if low > 0.0:
        return HOLDS
    if high < 0.0 or low == high:
        return DOES_NOT
    return Answer("undecided", runs_for(margins, of))


def mean_within(values: np.ndarray, target: float, bound: float, of: int = 1) -> Answer:
    """Whether the mean of values (R,) is no further than a bound from a target.

    `of` as in `mean_above`. It holds where the whole interval is within the bound, and does not
    where all of it is outside.
    """
    low, high = interval(values, 1.0 - (1.0 - CONFIDENCE) / of)
    if low >= target - bound and high <= target + bound:
        return HOLDS
    if low > target + bound or high < target - bound:
        return DOES_NOT
    if values.size < 2:
        return UNDECIDED
    off = float(values.mean()) - target
    edge = bound if off >= 0.0 else -bound
    return Answer("undecided", runs_for(values - target - edge, of))


def runs_for(margins: np.ndarray, of: int = 1) -> int | None:
    """Runs with which a mean like that of margins (R,) is told from 0, about; None if unknown."""
    if margins.size < 2 or margins.mean() == 0.0:
        return None
    ratio = float(margins.std(ddof=1) / abs(margins.mean()))
    confidence = 1.0 - (1.0 - CONFIDENCE) / of
    return least(lambda n: quantile(n - 1, confidence) * ratio < math.sqrt(n))


def least(decides: Callable[[int], bool], start: int = 2) -> int | None:
    """The least number of runs from `start` on that decides, as far as more never decide less.

    >>> least(lambda n: n * n > 1000)
    32
    """
    high = start
    while not decides(high):
        high *= 2
        if high > MOST:
            return None
    low = max(start - 1, high // 2)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if decides(middle) else (middle, high)
    return high


def share_of_runs(good: int, runs: int, share: float, of: int = 1) -> Answer:
    """Whether something is so in at least a share of all runs, if it is in `good` of `runs`.

    With share = 1 a single run that breaks it shows that it does not hold; `NEARLY_ALL` says when
    it does.
    """
    if share == 1.0:
        if good < runs:
            return DOES_NOT
        share = NEARLY_ALL
    low, high = bounds_of_share(good, runs, of)
    if low >= share:
        return HOLDS
    if high < share:
        return DOES_NOT
    return Answer("undecided", runs_for_share(good / runs if runs else 1.0, share, of))


def bounds_of_share(good: int, runs: int, of: int = 1) -> tuple[float, float]:
    """Bounds of the share of all runs, each exceeded in at most one case of a hundred (exact).

    >>> bounds_of_share(100, 100)[0] == 0.01 ** (1 / 100)
    True
    """
    from scipy.stats import beta

    wrong = (1.0 - CONFIDENCE) / of
    low = wrong ** (1.0 / runs) if good == runs > 0 else 0.0
    if 0 < good < runs:
        low = float(beta.ppf(wrong, good, runs - good + 1))
    high = 1.0 if good == runs else float(beta.ppf(1.0 - wrong, good + 1, runs - good))
    return low, high


def runs_for_share(rate: float, share: float, of: int = 1) -> int | None:
    """Runs with which a share like `rate` is told from `share`, about; None if none would."""

    def decides(n: int) -> bool:
        low, high = bounds_of_share(round(rate * n), n, of)
        return low >= share or high < share

    return least(decides, 1)


def all_of(answers: Sequence[Answer]) -> Answer:
    """The answer to a claim that holds if all of its parts hold."""
    return joined(answers, every="holds", one="does not hold")


def any_of(answers: Sequence[Answer]) -> Answer:
    """The answer to a claim that holds if one of its parts holds."""
    return joined(answers, every="does not hold", one="holds")


def joined(answers: Sequence[Answer], every: Word, one: Word) -> Answer:
    """One answer of several: `one` if a part says so, `every` if all do, else undecided."""
    words = [answer.word for answer in answers]
    if one in words:
        return Answer(one)
    if all(word == every for word in words):
        return Answer(every)
    needed = [answer.needed for answer in answers if answer.word == "undecided"]
    return Answer("undecided", None if None in needed else max(n for n in needed if n))


def by_construction(answer: Answer) -> Answer:
    """The answer to a claim that cannot fail; that it does not hold is a fault, and is said."""
    return answer if answer.word == "does not hold" else Answer("by construction")
