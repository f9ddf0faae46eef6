"""Measured beside published: one verdict per row and measure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from agents.catalogue import model
from app.studies.experiment import Case
from app.studies.experiment_file import ExpectedVerdict, PaperSweep, PublishedMeasure
from app.studies.judge.comparison import MeanComparison
from app.studies.judge.judge import RunRanges
from app.studies.judge.statistics import MeasureSummary
from app.studies.measure import Measure, Number


@dataclass(frozen=True)
class Verdict:
    """One measure of one row: what was measured, what was published, how far they are apart."""

    case: Case
    measure: Measure
    values: list[Number | None]
    """By seed; None for a run that has none."""
    ranges: RunRanges
    """The same, as far as it is known of runs that have none."""
    summary: MeasureSummary
    published: PublishedMeasure | None
    comparison: MeanComparison | None = None
    """None where nothing is published or nothing is to be compared."""
    expected: ExpectedVerdict | None = None
    """What was found before."""
    not_compared: str = ""
    """Why it is not compared."""
    single: bool = False
    """Whether the experiment is about a single run, and says nothing of others."""

    @property
    def word(self) -> str:
        """In a word: agrees, differs, undecided, or nothing."""
        return self.comparison.word if self.comparison else ""

    @property
    def unit(self) -> str:
        """The measure's unit; of a length that of the model's lengths."""
        return model(self.case.spec.model).in_units(self.measure.unit)

    @property
    def commonest_word(self) -> tuple[str, float]:
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
            row |= {"commonest": self.commonest_word[0]}
        if case.tick is not None:
            row |= {"tick": case.tick}
        row |= {"measure": self.measure.name, "unit": self.unit}
        row |= {"runs": s.runs, "absent": s.absent, "limit": s.limit, "mean": s.mean, "sd": s.sd}
        row |= dict(zip(("q25", "median", "q75"), s.quartiles, strict=True))
        row |= dict(zip(("low95", "high95"), s.interval, strict=True))
        row |= {"least": s.least, "most": s.most}
        if case.row:
            published = self.published
            q = (published and published.quartiles) or (None, None, None)
            row |= {"published_mean": published and published.average} | self.comparison_row()
            row |= dict(zip(("published_q25", "published_median", "published_q75"), q, strict=True))
            row |= {"not_compared": self.not_compared, "remark": case.row.remark}
        return row

    def comparison_row(self) -> dict[str, Any]:
        """How it stands beside what was published, as a flat row; None for what is not known."""
        comparison = self.comparison
        low, high = comparison.interval if comparison else (None, None)
        return {
            "verdict": self.word,
            "needed": comparison and comparison.needed,
            "because": comparison and comparison.why,
            "p": comparison and comparison.p,
            "difference": comparison and comparison.difference,
            "difference_low99": low,
            "difference_high99": high,
            "z": comparison and comparison.z,
            "d": comparison and comparison.effect,
            "expected": self.expected.verdict if self.expected else "",
            "why": self.expected.why if self.expected else "",
        }


def paired_differences(a: Verdict, b: Verdict) -> RunRanges:
    """What b has more than a, seed by seed."""
    return b.ranges.subtract(a.ranges)


def verdicts_on(verdicts: list[Verdict], measure: str) -> list[Verdict]:
    """The verdicts on one measure."""
    return [verdict for verdict in verdicts if verdict.measure.name == measure]


def main_verdicts(verdicts: list[Verdict]) -> list[Verdict]:
    """The verdicts on the measure that the experiment reports first."""
    return verdicts_on(verdicts, verdicts[0].measure.name) if verdicts else []


def group_by_sweep(verdicts: list[Verdict]) -> list[tuple[PaperSweep, int, list[Verdict]]]:
    """The verdicts by sweep and size of flock, in order of the values."""
    sweeps: dict[tuple[int, int], tuple[PaperSweep, int, list[Verdict]]] = {}
    for verdict in verdicts:
        if verdict.case.sweep:
            key = (id(verdict.case.sweep), verdict.case.agents)
            sweeps.setdefault(key, (verdict.case.sweep, verdict.case.agents, []))[2].append(verdict)
    return list(sweeps.values())


def name(value: object) -> str:
    """A swept value in words."""
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}" if isinstance(value, float) else str(value)
