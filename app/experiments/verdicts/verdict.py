"""Measured beside published: one verdict per row and measure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from app.experiments.conduct import Measured
from app.experiments.experiment import Case, Experiment
from app.experiments.file import Published, Sweep
from app.experiments.kinds.settings import Measure, Number
from app.experiments.verdicts.statistics import Summary, summary, welch, z_score

LARGE = 3.0
"""|z| from which on a row counts as different."""


@dataclass(frozen=True)
class Verdict:
    """One measure of one row: what was measured, what was published, how far they are apart."""

    case: Case
    measure: Measure
    values: list[Number | None]
    """By seed; None for a run that has none."""
    summary: Summary
    published: Published | None
    z: float | None
    """None where nothing is published or nothing is to be compared."""
    why: str = ""
    """Why it is not compared or does not come out."""

    @property
    def word(self) -> str:
        """In a word: agrees, differs, `not reproduced` where that is known, or nothing."""
        if self.published is None or self.z is None or math.isnan(self.z):
            return ""
        if self.why:
            return "not reproduced"
        return "agrees" if abs(self.z) < LARGE else "differs"

    @property
    def commonest(self) -> tuple[str, float]:
        """The commonest word of a measure that is a name, and the share of the runs that have it.

        No word for a quantity.
        """
        words = self.measure.words
        if not words or not self.values:
            return "", 0.0
        counts = [sum(value == k for value in self.values) for k in range(len(words))]
        most = counts.index(max(counts))
        return words[most], counts[most] / len(self.values)

    def as_row(self) -> dict[str, Any]:
        """As a flat row for JSON and CSV; the same keys for all rows of an experiment."""
        case, s = self.case, self.summary
        row: dict[str, Any] = {"model": case.spec.model, "label": case.label, "agents": case.agents}
        row |= {"size": case.spec.size}
        if case.sweep:
            row |= {"parameter": case.sweep.parameter, "value": case.value}
            row |= {"against": case.sweep.against, "at": case.at, "way": case.way}
            row |= {"commonest": self.commonest[0]}
        row |= {"measure": self.measure.name, "unit": self.measure.unit}
        row |= {"runs": s.runs, "absent": s.absent, "mean": s.mean, "sd": s.sd}
        row |= dict(zip(("q25", "median", "q75"), s.quartiles, strict=True))
        row |= dict(zip(("low95", "high95"), s.interval, strict=True))
        row |= {"least": s.least, "most": s.most}
        if case.row:
            published = self.published or Published()
            q = published.quartiles or (None, None, None)
            row |= {"published_mean": published.average, "z": self.z}
            row |= dict(zip(("published_q25", "published_median", "published_q75"), q, strict=True))
            row |= {"verdict": self.word, "why": self.why or case.row.remark}
        return row


def verdicts(experiment: Experiment, measured: list[Measured]) -> list[Verdict]:
    """A verdict for each row and each measure that the experiment reports, row by row."""
    return [
        verdict(experiment, one, measure) for one in measured for measure in experiment.measures
    ]


def verdict(experiment: Experiment, one: Measured, measure: Measure) -> Verdict:
    """The verdict of a measure of a row."""
    values = one.values[measure.name]
    s = summary(values)
    published = one.case.published(measure.name)
    spared = experiment.not_compared.get(measure.name, "")
    why = spared or experiment.not_reproduced.get(measure.name, "")
    z = None
    if published and published.average is not None and not spared:
        z = z_of(s, published)
        why = published.not_reproduced or why
    return Verdict(one.case, measure, values, s, published, z, why)


def z_of(measured: Summary, published: Published) -> float:
    """Distance from what was published: from its runs where they are printed, else its mean."""
    if published.values:
        return welch(measured, summary(published.values))
    assert published.mean is not None
    return z_score(measured, published.mean)


def of(made: list[Verdict], measure: str) -> list[Verdict]:
    """The verdicts on one measure."""
    return [one for one in made if one.measure.name == measure]


def main_ones(made: list[Verdict]) -> list[Verdict]:
    """The verdicts on the measure that the experiment reports first."""
    return of(made, made[0].measure.name) if made else []


def sweeps_of(made: list[Verdict]) -> list[tuple[Sweep, int, list[Verdict]]]:
    """The verdicts by sweep and size of flock, in order of the values."""
    found: dict[tuple[int, int], tuple[Sweep, int, list[Verdict]]] = {}
    for one in made:
        if one.case.sweep:
            key = (id(one.case.sweep), one.case.agents)
            found.setdefault(key, (one.case.sweep, one.case.agents, []))[2].append(one)
    return list(found.values())


def name(value: object) -> str:
    """A swept value in words."""
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}" if isinstance(value, float) else str(value)
