"""What a paper claims in words, and whether the runs bear it out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from app.experiments.file import Every, Faster, Found, Lags, Order, Said, Sweep
from app.experiments.verdicts.claim import Claim
from app.experiments.verdicts.phase_map import found_claim, lag_claim
from app.experiments.verdicts.statistics import difference
from app.experiments.verdicts.verdict import LARGE, Verdict, name, of, sweeps_of
from worlds.counting import counted


def claims(made: list[Verdict], said: Sequence[Said] = ()) -> list[Claim]:
    """Whether the runs do what the paper says; claims about rows that were not run are left out."""
    found = [claim for sweep in sweeps_of(made) for claim in sweep_claims(*sweep)]
    for one in said:
        points = of(made, one.measure)
        if isinstance(one, Order):
            found += [claim for n in one.agents for claim in order_claim(one, n, points)]
        elif isinstance(one, Every):
            found += every_claim(one, points)
        elif isinstance(one, Found):
            found += found_claim(one, points)
        elif isinstance(one, Lags):
            found += lag_claim(one, points)
        else:
            found += faster_claim(one, points)
    return found


def order_claim(one: Order, agents: int, made: list[Verdict]) -> list[Claim]:
    """Whether the means rise along the labels at one size."""
    by_label = {row.case.label: row for row in made if row.case.agents == agents}
    if not set(one.labels) <= set(by_label):
        return []
    rows = [by_label[label] for label in one.labels]
    steps = [difference(a.summary, b.summary) for a, b in pairwise(rows)]
    means = " < ".join(f"{row.case.label} {row.summary.mean:.1f}" for row in rows)
    least, error = min(steps)
    text = (
        f"N = {agents}, {rows[0].measure.symbol}: {means} (least step {least:.1f} +- {error:.1f})"
    )
    return [Claim(text, least > 0.0, one.not_reproduced)]


def every_claim(one: Every, made: list[Verdict]) -> list[Claim]:
    """Whether a measure is within bounds in every run, or in a share of the runs."""
    rows = [row for row in made if not one.labels or row.case.label in one.labels]
    rows = [row for row in rows if one.tick is None or row.case.tick == one.tick]
    values = [value for row in rows for value in row.values]
    if not values:
        return []
    there = [value for value in values if value is not None]
    without = rows[0].measure.without
    bad = sum(not is_within(one, without if value is None else value) for value in values)
    bounds = {
        "above": one.above,
        "below": one.below,
        "at least": one.at_least,
        "at most": one.at_most,
    }
    words = " and ".join(f"{word} {x:g}" for word, x in bounds.items() if x is not None)
    who = ", ".join(one.labels) or "all"
    measure = rows[0].measure
    span = f"{number(min(there))} to {number(max(there))}" if there else measure.absent
    unit = "" if measure.unit == "1" else f" {measure.unit}"
    when = "" if one.tick is None else f" at tick {one.tick}"
    often = "every run" if one.share == 1.0 else f"{one.share:.0%} of the runs or more"
    runs = counted(len(values), "run")
    text = f"{who}: {measure.symbol} {words}{unit}{when} in {often}; {span} in {runs}"
    holds = len(values) - bad >= one.share * len(values)
    return [Claim(text + (f", {bad} not" if bad else ""), holds, one.not_reproduced)]


def is_within(one: Every, value: float) -> bool:
    """Whether a value is within all of the bounds that are given."""
    return (
        (one.above is None or value > one.above)
        and (one.below is None or value < one.below)
        and (one.at_least is None or value >= one.at_least)
        and (one.at_most is None or value <= one.at_most)
    )


def faster_claim(one: Faster, made: list[Verdict]) -> list[Claim]:
    """Whether one row needs less than another by more than a share in every pair of runs."""
    found = []
    for row in made:
        for other in made:
            labels = row.case.label, other.case.label
            if labels == (one.label, one.than) and row.case.agents == other.case.agents:
                found.append(pairs_claim(one, row, other))
    return found


def pairs_claim(one: Faster, row: Verdict, other: Verdict) -> Claim:
    """The claim for two rows, run by run; a run without an end is endless."""
    pairs = list(zip(row.values, other.values, strict=True))
    gained = [gain(quick, slow) for quick, slow in pairs]
    text = (
        f"{one.label} is faster than {one.than} by more than {one.by:.0%} in every pair of runs; "
        f"by {min(gained):.1%} to {max(gained):.1%} in {len(pairs)}"
    )
    return Claim(text, min(gained) > one.by, one.not_reproduced)


def gain(quick: float | None, slow: float | None) -> float:
    """The share of the slow time that the quick one saves; None is endless."""
    if quick is None:
        return -math.inf
    return 1.0 if slow is None else 1.0 - quick / slow


def sweep_claims(sweep: Sweep, agents: int, points: list[Verdict]) -> list[Claim]:
    """What a figure says about a sweep at one size."""
    said = []
    ends = f"from {name(sweep.values[0])} to {name(sweep.values[-1])}"
    if sweep.trend and len(points) > 1:
        said.append(trend_claim(f"N = {agents}, {sweep.parameter} {ends}", sweep, points))
    if sweep.flat_from is not None:
        later = [p for p in points if float(p.case.value or 0) >= sweep.flat_from]
        if len(later) > 1:
            change = later[-1].summary.mean / later[0].summary.mean - 1.0
            said.append(
                Claim(
                    f"N = {agents}, {sweep.parameter} from {sweep.flat_from:g} on: the mean "
                    f"changes by {change:+.1%}; published: hardly",
                    abs(change) < 0.05,
                )
            )
    return said


def trend_claim(label: str, sweep: Sweep, points: list[Verdict]) -> Claim:
    """Whether the mean rises or falls from the first to the last value as published."""
    change, error = difference(points[0].summary, points[-1].summary)
    sign = 1.0 if sweep.trend == "rises" else -1.0
    text = (
        f"{label}: the mean changes by {change:+.2f} +- {error:.2f} ticks; published: {sweep.trend}"
    )
    return Claim(text, sign * change > LARGE * error)


def number(value: float) -> str:
    """A measured value in a sentence."""
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
