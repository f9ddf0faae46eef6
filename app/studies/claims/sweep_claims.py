"""Claims about what size does, and about the points of sweeps: what is so at some, or at all."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from app.studies.experiment_file import (
    EnduranceClaim,
    EveryRunClaim,
    LagClaim,
    PhaseClaim,
    ReachClaim,
    SizeClaim,
)
from app.studies.judge.claim_verdict import (
    ClaimVerdict,
    join_all,
    join_any,
    mean_above,
    share_of_runs,
)
from app.studies.judge.verdict import Verdict, group_by_sweep, name, paired_differences

# The bounds that a claim sets to a measure.


def bounds_in_words(claim: EveryRunClaim | EnduranceClaim) -> str:
    """The bounds that are given."""
    bounds = {
        "above": claim.above,
        "below": claim.below,
        "at least": claim.at_least,
        "at most": claim.at_most,
    }
    return " and ".join(f"{word} {x:g}" for word, x in bounds.items() if x is not None)


def is_within(claim: EveryRunClaim | EnduranceClaim, value: float) -> bool:
    """Whether a value is within all of the bounds that are given."""
    return (
        (claim.above is None or value > claim.above)
        and (claim.below is None or value < claim.below)
        and (claim.at_least is None or value >= claim.at_least)
        and (claim.at_most is None or value <= claim.at_most)
    )


# Claims about the phases of a map: that one is found, that the way back lags behind.

HALF = 0.5
"""Share of the runs of a cell above which a word is its own."""


def found_claim(claim: PhaseClaim, verdicts: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether more than half of the runs of some cell of the map have a word."""
    rows = [row for row in verdicts if row.measure.name == claim.measure and not row.case.way]
    if not rows:
        return []
    word = rows[0].measure.words.index(claim.word)
    good = [sum(value == word for value in row.values) for row in rows]
    matching = sum(row.commonest_word[0] == claim.word for row in rows)
    most = max(g / len(row.values) for g, row in zip(good, rows, strict=True))
    text = (
        f"{claim.word}: the commonest {claim.measure} in {matching} of {len(rows)} cells, in up to "
        f"{most:.0%} of the runs of a cell"
    )
    answers = [
        share_of_runs(g, len(row.values), HALF, len(rows))
        for g, row in zip(good, rows, strict=True)
    ]
    return [(text, join_any(answers))]


def lag_claim(claim: LagClaim, verdicts: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether a measure is larger on the way back by more than a step, somewhere, run by run."""
    rows = [row for row in verdicts if row.measure.name == claim.measure]
    outward_rows = [row for row in rows if row.case.way == "there"]
    back = [row for row in rows if row.case.way == "back"]
    if not outward_rows:
        return []
    pairs = list(zip(outward_rows, back[::-1], strict=True))
    up, down = max(pairs, key=lambda pair: pair[1].summary.mean - pair[0].summary.mean)
    text = (
        f"{up.measure.symbol} remembers: "
        f"at {up.case.own_sweep.parameter} = {up.case.value:g} it is "
        f"{up.summary.mean:.2f} on the way there, {down.summary.mean:.2f} on the way back; "
        f"asked: {claim.by:g} more"
    )
    answers = [
        mean_above(paired_differences(first, second).add(-claim.by), len(pairs))
        for first, second in pairs
    ]
    return [(text, join_any(answers))]


def sizes_claim(claim: SizeClaim, verdicts: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether a measure falls, or rises, from each size of flock to the next, seed by seed.

    By a share of a mean: what is left of it less the next, so that nothing is divided.
    """
    at_value = [row for row in verdicts if row.case.value == claim.value]
    by_size = {row.case.agents: row for row in at_value if row.case.label == claim.label}
    if not set(claim.agents) <= set(by_size):
        return []
    rows = [by_size[agents] for agents in claim.agents]
    sign = 1.0 if claim.trend == "rises" else -1.0
    steps = [
        b.ranges.subtract(a.ranges.times(1.0 + sign * claim.by)).times(sign)
        for a, b in pairwise(rows)
    ]
    sweep = rows[0].case.sweep
    at = f", {sweep.parameter} = {name(claim.value)}" if sweep else ""
    means = ", ".join(f"{row.summary.mean:.4g} at N = {row.case.agents}" for row in rows)
    share = f" by {claim.by:.0%} or more" if claim.by else ""
    text = f"{claim.label}{at}: {rows[0].measure.symbol} {claim.trend} with N{share}: {means}"
    return [(text, join_all([mean_above(step, len(steps)) for step in steps]))]


def reaches_claim(claim: ReachClaim, verdicts: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether a mean is below, or above, a bound at some point of a sweep; or at none."""
    rows = [row for row in verdicts if row.case.sweep and row.case.label == claim.label]
    rows = [row for row in rows if row.case.agents in claim.agents]
    rows = [row for row in rows if row.values]
    if not rows:
        return []
    margins = [row.ranges.add(-claim.bound).times(claim.sign) for row in rows]
    most = max(zip(margins, rows, strict=True), key=lambda pair: float(pair[0].least.mean()))[1]
    low, high = most.ranges.interval()
    extreme = "least" if claim.above is None else "most"
    text = (
        f"{claim.label}, N = {', '.join(map(str, claim.agents))}: mean {rows[0].measure.symbol} "
        f"{claim.bound_words} {'nowhere' if claim.nowhere else 'somewhere'}; {extreme} "
        f"{most.summary.mean:.3f} at {most.case.own_sweep.parameter} = {name(most.case.value)} "
        f"(99 %: {low:.3f} to {high:.3f})"
    )
    if claim.nowhere:
        return [(text, join_all([mean_above(margin.times(-1.0), len(rows)) for margin in margins]))]
    answers = [mean_above(margin, len(rows)) for margin in margins]
    answer = join_any(answers)
    if answer.word == "undecided":  # one point is enough: that which is nearest to being decided
        likely = zip(margins, answers, strict=True)
        needed = [verdict.needed for margin, verdict in likely if margin.least.mean() > 0.0]
        answer = replace(answer, needed=min((n for n in needed if n is not None), default=None))
    return [(text, answer)]


def endures_claim(
    claim: EnduranceClaim, label: str, verdicts: list[Verdict]
) -> list[tuple[str, ClaimVerdict]]:
    """Whether a measure is within bounds in every run of a sweep; from which value on it is not."""
    answers = []
    for sweep, agents, points in group_by_sweep(verdicts):
        if sweep.label != label or not all(point.values for point in points):
            continue
        measure = points[0].measure
        runs = [len(point.values) for point in points]
        good = [
            sum(is_within(claim, measure.counted(value)) for value in point.values)
            for point in points
        ]
        unit = "" if points[0].unit == "1" else f" {points[0].unit}"
        ends = f"{name(sweep.values[0])} to {name(sweep.values[-1])}"
        text = (
            f"{label}, N = {agents}: {measure.symbol} {bounds_in_words(claim)}{unit} in every run "
            "at "
            f"{sweep.parameter} {ends}"
        )
        failing = [k for k in range(len(points)) if good[k] < runs[k]]
        if failing:
            k = failing[0]
            text += f"; first fails at {name(points[k].case.value)} ({good[k]} of {runs[k]} runs)"
            text += f", worst {min(g / r for g, r in zip(good, runs, strict=True)):.0%}"
        shares = zip(good, runs, strict=True)
        answers.append((text, join_all([share_of_runs(*share, 1.0) for share in shares])))
    return answers
