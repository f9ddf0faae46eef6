"""Phases over the parameters of a sweep: what was measured at each place, and what is claimed."""

from __future__ import annotations

from dataclasses import dataclass

from app.experiments.experiment import Case
from app.experiments.file import Found, Lags
from app.experiments.verdicts.claim import Claim
from app.experiments.verdicts.statistics import Summary
from app.experiments.verdicts.verdict import LARGE, Verdict


@dataclass(frozen=True)
class Spot:
    """One place of the map: the runs of a case."""

    case: Case
    p: Summary
    m: Summary
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


def spots(made: list[Verdict]) -> list[Spot]:
    """All places, those of maps and those of ways there and back, in the order of the cases."""
    by_case: dict[int, dict[str, Verdict]] = {}
    for one in made:
        by_case.setdefault(id(one.case), {})[one.measure.name] = one
    return [
        Spot(row["p"].case, row["p"].summary, row["m"].summary, *row["phase"].commonest)
        for row in by_case.values()
    ]


def map_of(made: list[Verdict]) -> list[Spot]:
    """The places of the map."""
    return [spot for spot in spots(made) if not spot.case.way]


def ways_of(made: list[Verdict]) -> list[tuple[Spot, Spot]]:
    """The places of the way there, each with the same place on the way back."""
    found = spots(made)
    there = [spot for spot in found if spot.case.way == "there"]
    back = [spot for spot in found if spot.case.way == "back"]
    return list(zip(there, back[::-1], strict=True))


def found_claim(one: Found, made: list[Verdict]) -> list[Claim]:
    """Whether a word is the commonest somewhere on the map."""
    rows = [row for row in made if row.measure.name == one.measure and not row.case.way]
    there = [row for row in rows if row.commonest[0] == one.word]
    return [
        Claim(
            f"{one.word}: the commonest {one.measure} in {len(there)} of {len(rows)} cells",
            bool(there),
            one.not_reproduced,
        )
    ]


def lag_claim(one: Lags, made: list[Verdict]) -> list[Claim]:
    """Whether a measure is larger on the way back, by more than a step and than chance."""
    rows = [row for row in made if row.measure.name == one.measure]
    there = [row for row in rows if row.case.way == "there"]
    back = [row for row in rows if row.case.way == "back"]
    if not there:
        return []
    pairs = list(zip(there, back[::-1], strict=True))
    up, down = max(pairs, key=lambda pair: pair[1].summary.mean - pair[0].summary.mean)
    a, b = up.summary, down.summary
    error = (a.standard_error**2 + b.standard_error**2) ** 0.5
    assert up.case.sweep is not None
    text = (
        f"{up.measure.symbol} remembers: at {up.case.sweep.parameter} = {up.case.value:g} it is "
        f"{a.mean:.2f} on the way there, {b.mean:.2f} on the way back"
    )
    gap = b.mean - a.mean
    return [Claim(text, gap > one.by and gap > LARGE * error, one.not_reproduced)]
