"""The verdict on each row of a paper, what it claims in words, and whether the runs bear it out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from app.studies.claims.sweep_claims import (
    bounds_in_words,
    endures_claim,
    found_claim,
    is_within,
    lag_claim,
    reaches_claim,
    sizes_claim,
)
from app.studies.experiment import Experiment
from app.studies.experiment_file import (
    DeclaredClaim,
    EnduranceClaim,
    EqualityClaim,
    EveryRunClaim,
    ExpectedVerdict,
    FasterClaim,
    LagClaim,
    MeanClaim,
    NearClaim,
    OrderClaim,
    PaperSweep,
    PhaseClaim,
    ReachClaim,
    ScalingClaim,
    SizeClaim,
)
from app.studies.experiment_runner import MeasuredCase
from app.studies.judge.claim_verdict import (
    DOES_NOT,
    HOLDS,
    UNDECIDED,
    ClaimVerdict,
    join_all,
    mean_above,
    mean_within,
    share_of_runs,
    verdict_by_construction,
)
from app.studies.judge.comparison import compare
from app.studies.judge.judge import CONFIDENCE, RunRanges, ranges_of, share_interval
from app.studies.judge.statistics import summary
from app.studies.judge.verdict import (
    Verdict,
    group_by_sweep,
    main_verdicts,
    name,
    paired_differences,
    verdicts_on,
)
from app.studies.measure import Measure, Number
from worlds.number_text import counted


@dataclass(frozen=True)
class Claim:
    """What a paper says with what was measured, and the answer of the runs."""

    text: str
    answer: ClaimVerdict
    expected: ExpectedVerdict | None = None
    """What was found before."""
    by_construction: str = ""
    """Why it cannot fail; empty where it can."""

    @property
    def word(self) -> str:
        """In a word."""
        return self.answer.word


def word_and_expected(word: str, expected: ExpectedVerdict | None) -> str:
    """What was found before beside the word that the runs give; nothing where nothing is known."""
    if expected is None:
        return ""
    now = f"; now: {word}" if differs_from_expected(word, expected) else ""
    return f"expected: {expected.verdict}{now}; {expected.why}"


def differs_from_expected(word: str, expected: ExpectedVerdict | None) -> bool:
    """Whether the runs say something else than what was found before."""
    return expected is not None and word not in ("undecided", expected.verdict)


DIGITS = ((2.0, 3), (10.0, 2), (math.inf, 1))
"""Means below which so many digits behind the point are told."""
FLAT = 0.05
"""Change of a mean, as a share of it, that is hardly any."""


def claims(verdicts: list[Verdict], declared_claims: Sequence[DeclaredClaim] = ()) -> list[Claim]:
    """Whether the runs do what the paper says; claims about rows that were not run are left out."""
    swept = group_by_sweep(main_verdicts(verdicts))
    several = len({sweep.model for sweep, _, _ in swept}) > 1
    results = [claim for sweep in swept for claim in sweep_claims(*sweep, several)]
    for declared_claim in declared_claims:
        points = verdicts_on(verdicts, declared_claim.measure)
        for text, answer in judge_claim(declared_claim, points):
            if declared_claim.by_construction:
                answer = verdict_by_construction(answer)
            results.append(
                Claim(text, answer, declared_claim.expected, declared_claim.by_construction)
            )
    return results


def judge_claim(declared: DeclaredClaim, points: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """What a claim says of the runs in words, and the answer."""
    if isinstance(declared, OrderClaim):
        sizes: list[int | None] = [*declared.agents] or [None]
        return [claim for n in sizes for claim in order_claim(declared, n, points)]
    if isinstance(declared, EveryRunClaim):
        return every_claim(declared, points)
    if isinstance(declared, EnduranceClaim):
        return [
            claim for label in declared.labels for claim in endures_claim(declared, label, points)
        ]
    if isinstance(declared, NearClaim):
        return near_claim(declared, points)
    if isinstance(declared, MeanClaim):
        return mean_claim(declared, points)
    if isinstance(declared, ScalingClaim):
        return scales_claim(declared, points)
    if isinstance(declared, PhaseClaim):
        return found_claim(declared, points)
    if isinstance(declared, LagClaim):
        return lag_claim(declared, points)
    if isinstance(declared, EqualityClaim):
        return alike_claim(declared, points)
    if isinstance(declared, SizeClaim):
        return sizes_claim(declared, points)
    if isinstance(declared, ReachClaim):
        return reaches_claim(declared, points)
    return faster_claim(declared, points)


def order_claim(
    claim: OrderClaim, agents: int | None, verdicts: list[Verdict]
) -> list[tuple[str, ClaimVerdict]]:
    """Whether the means rise along the labels at one size, or any, each step seed by seed."""
    rows = [row for row in verdicts if agents in (None, row.case.agents)]
    by_label = {row.case.label: row for row in rows}
    if not set(claim.labels) <= set(by_label):
        return []
    rows = [by_label[label] for label in claim.labels]
    steps = [paired_differences(a, b) for a, b in pairwise(rows)]
    largest = max(abs(row.summary.mean) for row in rows)
    digits = next((number for below, number in DIGITS if largest < below), 1)
    means = " < ".join(f"{row.case.label} {row.summary.mean:.{digits}f}" for row in rows)
    smallest = min(steps, key=lambda step: float(step.least.mean()))
    size = "" if agents is None else f"N = {agents}, "
    text = (
        f"{size}{rows[0].measure.symbol}: {means} (least step {format_margins(smallest, digits)})"
    )
    return [(text, join_all([mean_above(step, len(steps)) for step in steps]))]


def format_margins(margins: RunRanges, digits: int = 1, unit: str = "") -> str:
    """The mean of margins with its interval, in words."""
    low, high = margins.interval()
    span = f"99 %: {low:+.{digits}f} to {high:+.{digits}f}{unit}"
    if margins.open_runs:
        return f"{margins.open_runs} of {counted(margins.runs, 'pair')} not known, {span}"
    mean = f"{margins.least.mean():+.{digits}f}{unit}"
    if margins.runs == 1:
        return f"{mean} in one pair of runs"
    return f"{mean}, {span}"


def mean_of(values: RunRanges, unit: str = "") -> str:
    """The mean of values with its interval, in words.

    >>> from app.studies.judge.judge import ranges_of
    >>> mean_of(ranges_of([1.0, 1.0, 1.0]), " m")
    '1 m in all of 3 runs'
    """
    low, high = values.interval()
    span = f"99 %: {low:.4g} to {high:.4g}{unit}"
    if values.open_runs:
        return f"{values.open_runs} of {counted(values.runs, 'run')} not known, {span}"
    mean = f"{values.least.mean():.4g}{unit}"
    if values.are_equal:
        return (
            f"{mean} in all of {counted(values.runs, 'run')}"
            if values.runs > 1
            else f"{mean} in one run"
        )
    return f"{mean}, {span}"


def every_claim(claim: EveryRunClaim, verdicts: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether a measure is within bounds in every run, or in a share of the runs."""
    rows = [row for row in verdicts if not claim.labels or row.case.label in claim.labels]
    rows = [row for row in rows if not claim.agents or row.case.agents in claim.agents]
    rows = [row for row in rows if claim.tick is None or row.case.tick == claim.tick]
    rows = [row for row in rows if row.values]
    if not rows:
        return []
    measure = rows[0].measure
    good = [sum(is_within(claim, measure.counted(value)) for value in row.values) for row in rows]
    came = [value for row in rows for value in row.values if value is not None]
    words = bounds_in_words(claim)
    who = ", ".join(claim.labels) or "all"
    if claim.agents:
        who += f", N = {', '.join(map(str, claim.agents))}"
    span = f"{number(min(came))} to {number(max(came))}" if came else measure.absent
    unit = "" if rows[0].unit == "1" else f" {rows[0].unit}"
    when = "" if claim.tick is None else f" at tick {claim.tick}"
    often = "every run" if claim.share == 1.0 else f"{claim.share:.0%} of the runs or more"
    runs = sum(len(row.values) for row in rows)
    text = (
        f"{who}: {measure.symbol} {words}{unit}{when} in {often}; {span} in {counted(runs, 'run')}"
    )
    if sum(good) < runs:
        text += f", {runs - sum(good)} not"
    shares = list(zip(good, (len(row.values) for row in rows), strict=True))
    if all(row.single for row in rows):
        return [
            (f"{text}; said of the run that is shown", HOLDS if sum(good) == runs else DOES_NOT)
        ]
    sided = 2.0 * CONFIDENCE - 1.0 if claim.share == 1.0 else CONFIDENCE
    sure = min(float(share_interval(*share, sided).low) for share in shares)
    of = 1 if claim.share == 1.0 else len(rows)
    return [
        (
            f"{text}; at 99 % in {sure:.1%} of all or more",
            join_all([share_of_runs(*share, claim.share, of) for share in shares]),
        )
    ]


def mean_claim(claim: MeanClaim, verdicts: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether the means of some rows are beyond a bound, each a claim of its own."""
    rows = [row for row in verdicts if row.case.label in claim.labels and row.values]
    rows = [row for row in rows if not claim.agents or row.case.agents in claim.agents]
    answers = []
    for row in rows:
        unit = "" if row.unit == "1" else f" {row.unit}"
        text = (
            f"{row.case.label}, N = {row.case.agents}: mean {row.measure.symbol} "
            f"{claim.bound_words}{unit}; it is {mean_of(row.ranges, unit)}"
        )
        margins = row.ranges.add(-claim.bound).times(claim.sign)
        answers.append((text, mean_above(margins, len(rows))))
    return answers


def near_claim(claim: NearClaim, verdicts: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether the means of some rows are near a value."""
    rows = [row for row in verdicts if row.case.label in claim.labels]
    rows = [row for row in rows if not claim.agents or row.case.agents in claim.agents]
    answers = []
    for row in rows:
        unit = "" if row.unit == "1" else f" {row.unit}"
        text = (
            f"{row.case.label}, N = {row.case.agents}: the mean {row.measure.symbol} is within "
            f"{claim.within:g} of {claim.value:g}{unit}; it is {mean_of(row.ranges, unit)}"
        )
        answers.append((text, mean_within(row.ranges, claim.value, claim.within, len(rows))))
    return answers


def scales_claim(claim: ScalingClaim, verdicts: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether a measure goes with a power of N, by the slope of each seed's line on log scales."""
    rows = [row for row in verdicts if row.case.label == claim.label]
    if len(rows) < 2:
        return []
    sizes = np.log([row.case.agents for row in rows])
    seeds = zip(*(row.values for row in rows), strict=True)
    slopes = ranges_of(
        [
            np.polyfit(sizes, np.log(np.array(seed, float)), 1)[0]
            if all(value is not None and value > 0.0 for value in seed)
            else None
            for seed in seeds
        ]
    )
    span = ", ".join(str(row.case.agents) for row in rows)
    text = (
        f"{claim.label}, N = {span}: {rows[0].measure.symbol} goes with N to the power "
        f"{claim.power:g}, within {claim.within:g}; it is {mean_of(slopes)}"
    )
    return [(text, mean_within(slopes, claim.power, claim.within))]


def faster_claim(claim: FasterClaim, verdicts: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether one row needs less than another by more than a share in every pair of runs."""
    answers = []
    for row in verdicts:
        for other in verdicts:
            labels = row.case.label, other.case.label
            if labels == (claim.label, claim.than) and row.case.agents == other.case.agents:
                answers.append(pairs_claim(claim, row, other))
    return answers


def pairs_claim(claim: FasterClaim, row: Verdict, other: Verdict) -> tuple[str, ClaimVerdict]:
    """The claim for two rows, run by run, by what is left of the slow time less the quick one."""
    margins = other.ranges.times(1.0 - claim.by).subtract(row.ranges)
    runs, good = margins.runs, int((margins.least > 0.0).sum())
    bad = int((margins.most <= 0.0).sum())
    text = (
        f"{claim.label} is faster than {claim.than} by more than {claim.by:.0%} in every pair of "
        "runs; "
        f"in {good} of {runs}"
    )
    if bad or good == runs:
        return text, share_of_runs(good, runs, 1.0)
    return f"{text}, {runs - good} not known", UNDECIDED


def sweep_claims(
    sweep: PaperSweep, agents: int, points: list[Verdict], several: bool = False
) -> list[Claim]:
    """What a figure says about a sweep at one size; of which model, where there are `several`."""
    results = []
    size = f"{sweep.model}, N = {agents}" if several else f"N = {agents}"
    ends = f"from {name(sweep.values[0])} to {name(sweep.values[-1])}"
    if sweep.trend and len(points) > 1:
        results.append(trend_claim(f"{size}, {sweep.parameter} {ends}", sweep, points))
    if sweep.flat_from is not None:
        later = [p for p in points if float(p.case.value or 0) >= sweep.flat_from]
        if len(later) > 1:
            start = f"{size}, {sweep.parameter} from {sweep.flat_from:g} on"
            results.append(flat_claim(start, later[0], later[-1]))
    return results


def flat_claim(label: str, first: Verdict, last: Verdict) -> Claim:
    """Whether the mean of the last is, within `FLAT`, that of the first, seed by seed.

    The last less 1 - FLAT of the first is above 0, and less 1 + FLAT of it below 0 (Fieller 1954):
    nothing is divided by a mean that may be 0.
    """
    unit = "" if first.unit == "1" else f" {first.unit}"
    change = format_margins(paired_differences(first, last), 2, unit)
    text = (
        f"{label}: the mean changes by {change}, from {first.summary.mean:.4g}{unit}; published: "
        f"hardly, less than {FLAT:.0%}"
    )
    above = mean_above(last.ranges.subtract(first.ranges.times(1.0 - FLAT)))
    below = mean_above(first.ranges.times(1.0 + FLAT).subtract(last.ranges))
    return Claim(text, join_all([above, below]))


def alike_claim(claim: EqualityClaim, verdicts: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether the means of two rows are less than a distance apart, seed by seed."""
    by_label = {row.case.label: row for row in verdicts}
    if not set(claim.labels) <= set(by_label):
        return []
    first, second = (by_label[label] for label in claim.labels)
    step = paired_differences(first, second)
    means = f"{first.summary.mean:.3f} and {second.summary.mean:.3f}"
    text = (
        f"{first.measure.symbol} of {claim.labels[0]} and {claim.labels[1]}: {means}, less than "
        f"{claim.within:g} apart ({format_margins(step, 3)})"
    )
    return [(text, mean_within(step, 0.0, claim.within))]


def trend_claim(label: str, sweep: PaperSweep, points: list[Verdict]) -> Claim:
    """Whether the mean rises or falls from the first to the last value as published."""
    change = paired_differences(points[0], points[-1])
    sign = 1.0 if sweep.trend == "rises" else -1.0
    unit = "" if points[0].unit == "1" else f" {points[0].unit}"
    text = (
        f"{label}: the mean changes by {format_margins(change, 2, unit)}; published: {sweep.trend}"
    )
    return Claim(text, mean_above(change.times(sign)))


def number(value: float) -> str:
    """A measured value in a sentence."""
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


# A verdict for each row and each measure of an experiment.


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
