"""Measured beside published: one verdict per row, and what a figure claims."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from app.experiments.conduct import Measured
from app.experiments.experiment import Sweep
from app.experiments.statistics import Summary, difference, summary, z_score

LARGE = 3.0
"""|z| from which on a row counts as different."""


@dataclass(frozen=True)
class Verdict:
    """One row: what was measured, what was published, how far they are apart."""

    measured: Measured
    summary: Summary
    z: float | None

    @property
    def word(self) -> str:
        """In a word: agrees, differs, `not reproduced` where that is known, or nothing."""
        published = self.measured.cell.published
        if published is None or self.z is None or math.isnan(self.z):
            return ""
        if published.not_reproduced:
            return "not reproduced"
        return "agrees" if abs(self.z) < LARGE else "differs"

    def as_row(self) -> dict[str, Any]:
        """As a flat row for JSON and CSV."""
        cell, s = self.measured.cell, self.summary
        row: dict[str, Any] = {"model": cell.model, "agents": cell.agents, "size": cell.size}
        if cell.sweep:
            row |= {"parameter": cell.sweep.parameter, "value": cell.value}
        row |= {"runs": s.runs, "given_up": s.given_up, "mean": s.mean, "sd": s.sd}
        row |= dict(zip(("q25", "median", "q75"), s.quartiles, strict=True))
        published = cell.published
        if published:
            q = published.quartiles or (None, None, None)
            row |= {"published_mean": published.mean, "z": self.z}
            row |= dict(zip(("published_q25", "published_median", "published_q75"), q, strict=True))
            row |= {"verdict": self.word, "why": published.not_reproduced or published.remark}
        return row


@dataclass(frozen=True)
class Claim:
    """What a figure says about a sweep at one size, and what was measured."""

    text: str
    holds: bool | None
    """None for a number without a published one."""


def verdicts(measured: list[Measured]) -> list[Verdict]:
    """A verdict for each row."""
    made = []
    for one in measured:
        s = summary(one.times)
        published = one.cell.published
        z = z_score(s, published.mean) if published and published.mean is not None else None
        made.append(Verdict(one, s, z))
    return made


def sweeps_of(made: list[Verdict]) -> list[tuple[Sweep, int, list[Verdict]]]:
    """The verdicts by sweep and size of flock, in order of the values."""
    found: dict[tuple[int, int], tuple[Sweep, int, list[Verdict]]] = {}
    for one in made:
        cell = one.measured.cell
        if cell.sweep:
            key = (id(cell.sweep), cell.agents)
            found.setdefault(key, (cell.sweep, cell.agents, []))[2].append(one)
    return list(found.values())


def claims(made: list[Verdict]) -> list[Claim]:
    """Whether the sweeps do what the paper says."""
    said = []
    for sweep, agents, points in sweeps_of(made):
        ends = f"from {name(sweep.values[0])} to {name(sweep.values[-1])}"
        label = f"N = {agents}, {sweep.parameter} {ends}"
        if sweep.trend and len(points) > 1:
            said.append(trend_claim(label, sweep, points))
        if sweep.flat_from is not None:
            later = [p for p in points if float(p.measured.cell.value or 0) >= sweep.flat_from]
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


def name(value: object) -> str:
    """A swept value in words."""
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}" if isinstance(value, float) else str(value)
