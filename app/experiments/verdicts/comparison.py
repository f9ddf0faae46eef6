"""A measured mean beside a published one: agrees, differs, or more runs would decide."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from app.experiments.file import Published
from app.experiments.verdicts.answer import least, quantile

PUBLISHED_RUNS = 100
"""Runs behind each published mean (Liu et al. 2021, sections 3.1 and 3.2)."""
TOLERANCE = 1.0
"""Standard deviations of a single run within which means count as the same, once it is sure that
they are no further apart."""
NOTE = (
    "differs: the means are told apart at 99 % (Student's t); agrees: they are not, and at 99 % "
    "they are less than a standard deviation of one run apart; undecided, n: about n runs would "
    "decide"
)
SPREAD_NOTE = (
    "the paper gives no spread, so that the one measured here stands for its 100 runs too; z and "
    "d: measured less published mean, in standard errors and in standard deviations of a run"
)
WELCH_NOTE = (
    "published runs are compared as runs, each sample with its own spread (Welch); z and d: "
    "measured less published mean, in standard errors and in standard deviations of a run"
)


@dataclass(frozen=True)
class Comparison:
    """A measured and a published mean; NaN stands for what a sample without spread does not say."""

    word: Literal["agrees", "differs", "undecided"]
    difference: float
    """Measured less published mean."""
    interval: tuple[float, float] = (math.nan, math.nan)
    """Of the difference, 99 %."""
    z: float = math.nan
    """The difference in standard errors."""
    effect: float = math.nan
    """The difference in standard deviations of a run: Cohen's d."""
    needed: int | None = None
    """Of an undecided one: runs that would decide it, about; None if that is not known."""

    def __str__(self) -> str:
        return self.word if self.needed is None else f"{self.word}, {self.needed}"


def compare(values: np.ndarray, published: Published) -> Comparison | None:
    """How measured runs (R,) stand beside what was published; None without runs or a mean."""
    mean = published.average
    if mean is None or values.size == 0:
        return None
    theirs = np.array(published.values)
    difference = float(values.mean()) - mean
    if values.size == 1:
        return Comparison("undecided", difference)
    s = float(values.std(ddof=1))
    other = float(theirs.std(ddof=1)) if theirs.size > 1 else s
    count = theirs.size or PUBLISHED_RUNS
    if s == other == 0.0:
        same = math.isclose(difference, 0.0, abs_tol=1e-9 * max(1.0, abs(mean)))
        return Comparison("agrees" if same else "differs", difference, (difference, difference))
    scale = math.sqrt(0.5 * (s**2 + other**2))

    def half(n: int) -> float:
        """Half of the interval with n runs."""
        return quantile(freedom(s, n, other, count, theirs.size > 1)) * error(n)

    def error(n: int) -> float:
        return math.sqrt(s**2 / n + other**2 / count)

    def word(n: int) -> Literal["agrees", "differs", "undecided"]:
        if abs(difference) > half(n):
            return "differs"
        return "agrees" if abs(difference) + half(n) < TOLERANCE * scale else "undecided"

    n = values.size
    found = word(n)
    return Comparison(
        found,
        difference,
        (difference - half(n), difference + half(n)),
        difference / error(n),
        difference / scale,
        least(lambda n: word(n) != "undecided") if found == "undecided" else None,
    )


def freedom(s: float, n: int, other: float, count: int, has_runs: bool) -> float:
    """Degrees of freedom of a difference of two means: Welch and Satterthwaite.

    Where the second spread is the first one again it is measured on n runs only.
    """
    if not has_runs:
        return n - 1
    a, b = s**2 / n, other**2 / count
    return (a + b) ** 2 / (a**2 / (n - 1) + b**2 / (count - 1))
