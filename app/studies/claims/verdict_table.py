"""A verdict for each row and each measure of an experiment."""

from __future__ import annotations

import numpy as np

from app.studies.experiment import Experiment
from app.studies.experiment_runner import MeasuredCase
from app.studies.judge.comparison import compare
from app.studies.judge.judge import RunRanges
from app.studies.judge.statistics import summary
from app.studies.judge.verdict import Verdict
from app.studies.measure import Measure, Number


def verdicts(experiment: Experiment, measured: list[MeasuredCase]) -> list[Verdict]:
    """A verdict for each row and each measure that the experiment reports, row by row."""
    return [
        verdict(experiment, case, measure) for case in measured for measure in experiment.measures
    ]


def verdict(experiment: Experiment, case: MeasuredCase, measure: Measure) -> Verdict:
    """The verdict of a measure of a row."""
    values = case.values[measure.name]
    limits = experiment.settings.limits_of(measure, case.values)
    ranges = ranges_of_runs(values, measure, limits)
    published = case.case.published(measure.name)
    spared = experiment.not_compared.get(measure.name, "")
    compared = published is not None and not spared
    return Verdict(
        case.case,
        measure,
        values,
        ranges,
        summary(ranges),
        published,
        compare(ranges, published) if published and compared else None,
        (published and published.expected) or experiment.expected.get(measure.name),
        spared,
        experiment.runs == 1,
    )


def ranges_of_runs(
    values: list[Number | None], measure: Measure, limits: list[float | None]
) -> RunRanges:
    """What is known of runs: of one without a value its limit, or else the measure's bounds."""
    low, high, binary, rare = measure.bounds
    given_up = [low if limit is None else limit for limit in limits]
    least = [at if value is None else value for value, at in zip(values, given_up, strict=True)]
    most = [high if value is None else value for value in values]
    return RunRanges(np.array(least, float), np.array(most, float), (low, high), binary, rare)
