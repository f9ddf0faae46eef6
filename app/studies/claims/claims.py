"""What a paper claims in words, and whether the runs bear it out."""

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
from app.studies.experiment_file import (
    EnduranceClaim,
    EqualityClaim,
    EveryRunClaim,
    ExpectedVerdict,
    FasterClaim,
    LagClaim,
    NearClaim,
    OrderClaim,
    PaperSweep,
    PhaseClaim,
    ReachClaim,
    Said,
    ScalingClaim,
    SizeClaim,
)
from app.studies.judge.claim_verdict import (
    DOES_NOT,
    HOLDS,
    UNDECIDED,
    ClaimVerdict,
    all_of,
    by_construction,
    mean_above,
    mean_within,
    share_of_runs,
)
from app.studies.judge.judge import CONFIDENCE, RunRanges, ranges_of, share_interval
from app.studies.judge.verdict import Verdict, main_ones, name, of, paired, sweeps_of
from worlds.number_text import counted

# What a paper says in words, and what was measured.


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


def beside(word: str, expected: ExpectedVerdict | None) -> str:
    """What was found before beside the word that the runs give; nothing where nothing is known."""
    if expected is None:
        return ""
    now = f"; now: {word}" if is_news(word, expected) else ""
    return f"expected: {expected.verdict}{now}; {expected.why}"


def is_news(word: str, expected: ExpectedVerdict | None) -> bool:
    """Whether the runs say something else than what was found before."""
    return expected is not None and word not in ("undecided", expected.verdict)


DIGITS = ((2.0, 3), (10.0, 2), (math.inf, 1))
"""Means below which so many digits behind the point are told."""
FLAT = 0.05
"""Change of a mean, as a share of it, that is hardly any."""


def claims(made: list[Verdict], said: Sequence[Said] = ()) -> list[Claim]:
    """Whether the runs do what the paper says; claims about rows that were not run are left out."""
    swept = sweeps_of(main_ones(made))
    several = len({sweep.model for sweep, _, _ in swept}) > 1
    found = [claim for one in swept for claim in sweep_claims(*one, several)]
    for one in said:
        points = of(made, one.measure)
        for text, answer in said_of(one, points):
            if one.by_construction:
                answer = by_construction(answer)
            found.append(Claim(text, answer, one.expected, one.by_construction))
    return found


def said_of(one: Said, points: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """What a claim says of the runs in words, and the answer."""
    if isinstance(one, OrderClaim):
        sizes: list[int | None] = [*one.agents] or [None]
        return [claim for n in sizes for claim in order_claim(one, n, points)]
    if isinstance(one, EveryRunClaim):
        return every_claim(one, points)
    if isinstance(one, EnduranceClaim):
        return [claim for label in one.labels for claim in endures_claim(one, label, points)]
    if isinstance(one, NearClaim):
        return near_claim(one, points)
    if isinstance(one, ScalingClaim):
        return scales_claim(one, points)
    if isinstance(one, PhaseClaim):
        return found_claim(one, points)
    if isinstance(one, LagClaim):
        return lag_claim(one, points)
    if isinstance(one, EqualityClaim):
        return alike_claim(one, points)
    if isinstance(one, SizeClaim):
        return sizes_claim(one, points)
    if isinstance(one, ReachClaim):
        return reaches_claim(one, points)
    return faster_claim(one, points)


def order_claim(
    one: OrderClaim, agents: int | None, made: list[Verdict]
) -> list[tuple[str, ClaimVerdict]]:
    """Whether the means rise along the labels at one size, or any, each step seed by seed."""
    rows = [row for row in made if agents in (None, row.case.agents)]
    by_label = {row.case.label: row for row in rows}
    if not set(one.labels) <= set(by_label):
        return []
    rows = [by_label[label] for label in one.labels]
    steps = [paired(a, b) for a, b in pairwise(rows)]
    largest = max(abs(row.summary.mean) for row in rows)
    digits = next((number for below, number in DIGITS if largest < below), 1)
    means = " < ".join(f"{row.case.label} {row.summary.mean:.{digits}f}" for row in rows)
    smallest = min(steps, key=lambda step: float(step.least.mean()))
    size = "" if agents is None else f"N = {agents}, "
    text = f"{size}{rows[0].measure.symbol}: {means} (least step {spread(smallest, digits)})"
    return [(text, all_of([mean_above(step, len(steps)) for step in steps]))]


def spread(margins: RunRanges, digits: int = 1, unit: str = "") -> str:
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


def every_claim(one: EveryRunClaim, made: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether a measure is within bounds in every run, or in a share of the runs."""
    rows = [row for row in made if not one.labels or row.case.label in one.labels]
    rows = [row for row in rows if not one.agents or row.case.agents in one.agents]
    rows = [row for row in rows if one.tick is None or row.case.tick == one.tick]
    rows = [row for row in rows if row.values]
    if not rows:
        return []
    measure = rows[0].measure
    good = [sum(is_within(one, measure.counted(value)) for value in row.values) for row in rows]
    came = [value for row in rows for value in row.values if value is not None]
    words = bounds_in_words(one)
    who = ", ".join(one.labels) or "all"
    if one.agents:
        who += f", N = {', '.join(map(str, one.agents))}"
    span = f"{number(min(came))} to {number(max(came))}" if came else measure.absent
    unit = "" if rows[0].unit == "1" else f" {rows[0].unit}"
    when = "" if one.tick is None else f" at tick {one.tick}"
    often = "every run" if one.share == 1.0 else f"{one.share:.0%} of the runs or more"
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
    sided = 2.0 * CONFIDENCE - 1.0 if one.share == 1.0 else CONFIDENCE
    sure = min(float(share_interval(*share, sided).low) for share in shares)
    of = 1 if one.share == 1.0 else len(rows)
    return [
        (
            f"{text}; at 99 % in {sure:.1%} of all or more",
            all_of([share_of_runs(*share, one.share, of) for share in shares]),
        )
    ]


def near_claim(one: NearClaim, made: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether the means of some rows are near a value."""
    rows = [row for row in made if row.case.label in one.labels]
    rows = [row for row in rows if not one.agents or row.case.agents in one.agents]
    found = []
    for row in rows:
        unit = "" if row.unit == "1" else f" {row.unit}"
        text = (
            f"{row.case.label}, N = {row.case.agents}: the mean {row.measure.symbol} is within "
            f"{one.within:g} of {one.value:g}{unit}; it is {mean_of(row.ranges, unit)}"
        )
        found.append((text, mean_within(row.ranges, one.value, one.within, len(rows))))
    return found


def scales_claim(one: ScalingClaim, made: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether a measure goes with a power of N, by the slope of each seed's line on log scales."""
    rows = [row for row in made if row.case.label == one.label]
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
        f"{one.label}, N = {span}: {rows[0].measure.symbol} goes with N to the power "
        f"{one.power:g}, within {one.within:g}; it is {mean_of(slopes)}"
    )
    return [(text, mean_within(slopes, one.power, one.within))]


def faster_claim(one: FasterClaim, made: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether one row needs less than another by more than a share in every pair of runs."""
    found = []
    for row in made:
        for other in made:
            labels = row.case.label, other.case.label
            if labels == (one.label, one.than) and row.case.agents == other.case.agents:
                found.append(pairs_claim(one, row, other))
    return found


def pairs_claim(one: FasterClaim, row: Verdict, other: Verdict) -> tuple[str, ClaimVerdict]:
    """The claim for two rows, run by run, by what is left of the slow time less the quick one."""
    margins = other.ranges.times(1.0 - one.by).minus(row.ranges)
    runs, good = margins.runs, int((margins.least > 0.0).sum())
    bad = int((margins.most <= 0.0).sum())
    text = (
        f"{one.label} is faster than {one.than} by more than {one.by:.0%} in every pair of runs; "
        f"in {good} of {runs}"
    )
    if bad or good == runs:
        return text, share_of_runs(good, runs, 1.0)
    return f"{text}, {runs - good} not known", UNDECIDED


def sweep_claims(
    sweep: PaperSweep, agents: int, points: list[Verdict], several: bool = False
) -> list[Claim]:
    """What a figure says about a sweep at one size; of which model, where there are `several`."""
    said = []
    size = f"{sweep.model}, N = {agents}" if several else f"N = {agents}"
    ends = f"from {name(sweep.values[0])} to {name(sweep.values[-1])}"
    if sweep.trend and len(points) > 1:
        said.append(trend_claim(f"{size}, {sweep.parameter} {ends}", sweep, points))
    if sweep.flat_from is not None:
        later = [p for p in points if float(p.case.value or 0) >= sweep.flat_from]
        if len(later) > 1:
            start = f"{size}, {sweep.parameter} from {sweep.flat_from:g} on"
            said.append(flat_claim(start, later[0], later[-1]))
    return said


def flat_claim(label: str, first: Verdict, last: Verdict) -> Claim:
    """Whether the mean of the last is, within `FLAT`, that of the first, seed by seed.

    The last less 1 - FLAT of the first is above 0, and less 1 + FLAT of it below 0 (Fieller 1954):
    nothing is divided by a mean that may be 0.
    """
    unit = "" if first.unit == "1" else f" {first.unit}"
    change = spread(paired(first, last), 2, unit)
    text = (
        f"{label}: the mean changes by {change}, from {first.summary.mean:.4g}{unit}; published: "
        f"hardly, less than {FLAT:.0%}"
    )
    above = mean_above(last.ranges.minus(first.ranges.times(1.0 - FLAT)))
    below = mean_above(first.ranges.times(1.0 + FLAT).minus(last.ranges))
    return Claim(text, all_of([above, below]))


def alike_claim(one: EqualityClaim, made: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether the means of two rows are less than a distance apart, seed by seed."""
    by_label = {row.case.label: row for row in made}
    if not set(one.labels) <= set(by_label):
        return []
    first, second = (by_label[label] for label in one.labels)
    step = paired(first, second)
    means = f"{first.summary.mean:.3f} and {second.summary.mean:.3f}"
    text = (
        f"{first.measure.symbol} of {one.labels[0]} and {one.labels[1]}: {means}, less than "
        f"{one.within:g} apart ({spread(step, 3)})"
    )
    return [(text, mean_within(step, 0.0, one.within))]


def trend_claim(label: str, sweep: PaperSweep, points: list[Verdict]) -> Claim:
    """Whether the mean rises or falls from the first to the last value as published."""
    change = paired(points[0], points[-1])
    sign = 1.0 if sweep.trend == "rises" else -1.0
    unit = "" if points[0].unit == "1" else f" {points[0].unit}"
    text = f"{label}: the mean changes by {spread(change, 2, unit)}; published: {sweep.trend}"
    return Claim(text, mean_above(change.times(sign)))


def number(value: float) -> str:
    """A measured value in a sentence."""
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
