"""What runs say of a claim, on one scale: it holds, it does not hold, or more runs would decide.

Each word but "undecided" is wrong in about one case of a hundred, or fewer: `judge.py` says how,
`benchmarks/studies/judge.py` how often.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal

from app.studies.judge.judge import (
    CONFIDENCE,
    FEWEST_RUNS,
    RunRanges,
    likely_interval,
    share_interval,
)

NEARLY_ALL = 0.9
"""No number of runs shows that something is so in every run: it is taken to be so if no run breaks
it and at least this share of all runs, at 99 % confidence, does not either."""
MOST = 10**6
"""Runs beyond which a claim counts as one that runs cannot decide."""
LEAST_P, HALVINGS = 1e-12, 24
"""The least p-value that is told from 0, and steps in which a p-value is found."""

ANSWERS_NOTE = (
    "claims are answered at 99 %: of means by Student's t corrected for skewness, seed by seed; of "
    "shares of runs by the exact binomial bound; what is said of every run holds if no run breaks "
    "it and 9 of 10 of all runs or more, at 99 %, do not either; fewer than five runs, and equal "
    "runs, decide nothing of a mean; a run that was given up counts as its limit or more"
)

Word = Literal["holds", "does not hold", "undecided", "by construction"]


@dataclass(frozen=True)
class ClaimVerdict:
    """What the runs say of a claim."""

    word: Word
    needed: int | None = None
    """Of an undecided one: runs that would decide it, about; None if none would, or if the spread
    of the runs is not known yet."""
    why: str = ""
    """Of an undecided one: what keeps it undecided, other than the number of runs."""
    p: float = field(default=1.0, compare=False)
    """The chance, at most, with which runs give this word where it is false; 1 if undecided."""

    def __str__(self) -> str:
        if self.word != "undecided":
            return self.word
        if self.needed is not None:
            return f"undecided (about {self.needed} runs would decide)"
        return f"undecided ({self.why})" if self.why else "undecided"


HOLDS, DOES_NOT, UNDECIDED = (
    ClaimVerdict("holds"),
    ClaimVerdict("does not hold"),
    ClaimVerdict("undecided"),
)
TOO_FEW = ClaimVerdict("undecided", FEWEST_RUNS)


def decide[WordT: str](word_at: Callable[[float], WordT], of: int = 1) -> tuple[WordT, float]:
    """The word that `word_at` gives at 99 %, and its p-value.

    `of`: how many such questions are asked at once; each is then answered more strictly, so that
    the whole keeps its confidence (Bonferroni).
    """
    alpha = (1.0 - CONFIDENCE) / of
    word = word_at(1.0 - alpha)
    if word == "undecided":
        return word, 1.0
    low, high = math.log10(LEAST_P), math.log10(alpha)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if word_at(1.0 - 10.0**middle) == word else (middle, high)
    return word, min(1.0, of * 10.0**high)


def mean_above(margins: RunRanges, of: int = 1) -> ClaimVerdict:
    """Whether the mean of margins, of which each run gives one, is above 0; `of` as in `decide`."""

    def word(low: float, high: float) -> Word:
        return "holds" if low > 0.0 else "does not hold" if high < 0.0 else "undecided"

    return interval_verdict(margins, word, of)


def mean_within(values: RunRanges, target: float, bound: float, of: int = 1) -> ClaimVerdict:
    """Whether the mean of values is no further than a bound from a target; `of` as in `decide`.

    It holds where the whole interval is within the bound, and does not where all of it is outside.
    """

    def word(low: float, high: float) -> Word:
        if low >= target - bound and high <= target + bound:
            return "holds"
        return "does not hold" if low > target + bound or high < target - bound else "undecided"

    return interval_verdict(values, word, of)


def interval_verdict(
    values: RunRanges, word: Callable[[float, float], Word], of: int
) -> ClaimVerdict:
    """The answer that a word makes of the interval of a mean."""
    if values.runs < FEWEST_RUNS:
        return TOO_FEW
    answer, p = decide(lambda confidence: word(*values.interval(confidence)), of)
    if answer != "undecided":
        return ClaimVerdict(answer, p=p)
    if values.open_runs:
        return ClaimVerdict(answer, why=values.open_words)
    confidence = 1.0 - (1.0 - CONFIDENCE) / of

    def decides(runs: int) -> bool:
        limits = likely_interval(values, runs, confidence)
        return word(float(limits.low), float(limits.high)) != "undecided"

    needed = least_runs(decides, values.runs)
    return ClaimVerdict(answer, needed, "all runs are equal" if values.are_equal else "")


def least_runs(decides: Callable[[int], bool], start: int = 2) -> int | None:
    """The least number of runs from `start` on that decides, as far as more never decide less.

    >>> least_runs(lambda n: n * n > 1000)
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


def share_of_runs(good: int, runs: int, share: float, of: int = 1) -> ClaimVerdict:
    """Whether something is so in at least a share of all runs, if it is in `good` of `runs`.

    With share = 1 a single run that breaks it shows that it does not hold; `NEARLY_ALL` says when
    it does.
    """
    if share == 1.0 and good < runs:
        return ClaimVerdict("does not hold", p=0.0)
    if runs == 0:
        return TOO_FEW
    answer, p = decide(lambda confidence: share_word(good, runs, share, confidence), of)
    if answer != "undecided":
        return ClaimVerdict(answer, p=p)
    return ClaimVerdict(answer, runs_for_share(good / runs, share, of, runs))


def share_word(good: int, runs: int, share: float, confidence: float) -> Word:
    """The word at a confidence.

    What is said of every run can be wrongly borne out only, not wrongly denied, so that the whole
    chance of a false word is on one side.
    """
    every = share == 1.0
    sided = 2.0 * confidence - 1.0 if every else confidence
    limits = share_interval(good, runs, sided)
    if limits.low >= (NEARLY_ALL if every else share):
        return "holds"
    return "does not hold" if not every and limits.high < share else "undecided"


def runs_for_share(rate: float, share: float, of: int = 1, runs_made: int = 1) -> int | None:
    """Runs, of which so many are made, with which a share like `rate` is told from `share`, about.

    None if no number would.
    """
    confidence = 1.0 - (1.0 - CONFIDENCE) / of

    def decides(runs: int) -> bool:
        return share_word(round(rate * runs), runs, share, confidence) != "undecided"

    return least_runs(decides, runs_made)


def join_all(answers: Sequence[ClaimVerdict]) -> ClaimVerdict:
    """The answer to a claim that holds if all of its parts hold."""
    return join_verdicts(answers, every="holds", verdict_word="does not hold")


def join_any(answers: Sequence[ClaimVerdict]) -> ClaimVerdict:
    """The answer to a claim that holds if one of its parts holds."""
    return join_verdicts(answers, every="does not hold", verdict_word="holds")


def join_verdicts(answers: Sequence[ClaimVerdict], every: Word, verdict_word: Word) -> ClaimVerdict:
    """Join answers: `verdict_word` if a part says so, `every` if all do, else undecided."""
    parts = [answer for answer in answers if answer.word == verdict_word]
    if parts:
        return ClaimVerdict(verdict_word, p=min(answer.p for answer in parts))
    if all(answer.word == every for answer in answers):
        return ClaimVerdict(every, p=max(answer.p for answer in answers))
    open_ones = [answer for answer in answers if answer.word == "undecided"]
    needed = [answer.needed for answer in open_ones if answer.needed is not None]
    why = next((answer.why for answer in open_ones if answer.why), "")
    return ClaimVerdict("undecided", max(needed) if len(needed) == len(open_ones) else None, why)


def verdict_by_construction(answer: ClaimVerdict) -> ClaimVerdict:
    """The answer to a claim that cannot fail; that it does not hold is a fault, and is said."""
    return answer if answer.word == "does not hold" else ClaimVerdict("by construction")
