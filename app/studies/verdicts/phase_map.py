"""Phases over the parameters of a sweep: what was measured at each place, and what is claimed."""

from __future__ import annotations

from dataclasses import dataclass

from app.studies.experiment import Case
from app.studies.experiment_file import LagClaim, PhaseClaim
from app.studies.verdicts.claim_verdict import ClaimVerdict, any_of, mean_above, share_of_runs
from app.studies.verdicts.statistics import MeasureSummary
from app.studies.verdicts.verdict import Verdict, paired

HALF = 0.5
"""Share of the runs of a cell above which a word is its own."""


@dataclass(frozen=True)
class PhasePoint:
    """One place of the map: the runs of a case."""

    case: Case
    p: MeasureSummary
    m: MeasureSummary
    phase: str
    """The commonest."""
    share: float
    """Of the runs that are in it, in [0, 1]."""

    @property
    def x(self) -> float:
        """The value of the sweep's parameter."""
        return float(self.case.value or 0.0)

    @property
    def y(self) -> float:
        """The value of its second parameter."""
        return float(self.case.at or 0.0)


def spots(made: list[Verdict]) -> list[PhasePoint]:
    """All places, those of maps and those of ways there and back, in the order of the cases."""
    by_case: dict[int, dict[str, Verdict]] = {}
    for one in made:
        by_case.setdefault(id(one.case), {})[one.measure.name] = one
    return [
        PhasePoint(row["p"].case, row["p"].summary, row["m"].summary, *row["phase"].commonest)
        for row in by_case.values()
    ]


def map_of(made: list[Verdict]) -> list[PhasePoint]:
    """The places of the map."""
    return [spot for spot in spots(made) if not spot.case.way]


def ways_of(made: list[Verdict]) -> list[tuple[PhasePoint, PhasePoint]]:
    """The places of the way there, each with the same place on the way back."""
    found = spots(made)
    there = [spot for spot in found if spot.case.way == "there"]
    back = [spot for spot in found if spot.case.way == "back"]
    return list(zip(there, back[::-1], strict=True))


def found_claim(one: PhaseClaim, made: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether more than half of the runs of some cell of the map have a word."""
    rows = [row for row in made if row.measure.name == one.measure and not row.case.way]
    if not rows:
        return []
    word = rows[0].measure.words.index(one.word)
    good = [sum(value == word for value in row.values) for row in rows]
    there = sum(row.commonest[0] == one.word for row in rows)
    most = max(g / len(row.values) for g, row in zip(good, rows, strict=True))
    text = (
        f"{one.word}: the commonest {one.measure} in {there} of {len(rows)} cells, in up to "
        f"{most:.0%} of the runs of a cell"
    )
    answers = [
        share_of_runs(g, len(row.values), HALF, len(rows))
        for g, row in zip(good, rows, strict=True)
    ]
    return [(text, any_of(answers))]


def lag_claim(one: LagClaim, made: list[Verdict]) -> list[tuple[str, ClaimVerdict]]:
    """Whether a measure is larger on the way back by more than a step, somewhere, run by run."""
    rows = [row for row in made if row.measure.name == one.measure]
    there = [row for row in rows if row.case.way == "there"]
    back = [row for row in rows if row.case.way == "back"]
    if not there:
        return []
    pairs = list(zip(there, back[::-1], strict=True))
    up, down = max(pairs, key=lambda pair: pair[1].summary.mean - pair[0].summary.mean)
    assert up.case.sweep is not None
    text = (
        f"{up.measure.symbol} remembers: at {up.case.sweep.parameter} = {up.case.value:g} it is "
        f"{up.summary.mean:.2f} on the way there, {down.summary.mean:.2f} on the way back; "
        f"asked: {one.by:g} more"
    )
    answers = [
        mean_above(paired(first, second).plus(-one.by), len(pairs)) for first, second in pairs
    ]
    return [(text, any_of(answers))]
