"""Where in a group agents are, by the one parameter in which they differ."""

from __future__ import annotations

from collections.abc import Callable
from textwrap import fill
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from agents.catalogue import model
from agents.models.declare import declared
from app.studies.charts.boxes import WORDS, box, draw_key
from app.studies.charts.colour_table import COLOURS, RULER
from app.studies.experiment import Experiment, flock_of
from app.studies.judge.verdict import Verdict, verdicts_on
from app.studies.measure import PERCENT, SHARE, Measure, MeasureBounds, Number, Settings
from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents import Flock

# Runs in which agents of one group differ in one parameter: Couzin et al. 2002, second half.

CORRELATION = MeasureBounds(-1.0, 1.0)
FEWEST = 3
"""Agents below which a rank correlation says nothing."""
OFTEN = 0.5
"""Share of the looks at which an agent is in the largest group for its mean place to count."""


class Places(NamedTuple):
    """Own numbers of agents and where they are in the largest group, each (N,)."""

    own: np.ndarray
    distance: np.ndarray
    """Mean distance to the centre of the group, length; nan of an agent that is seldom in it."""
    front: np.ndarray
    """Mean place along the mean heading of the group, from its centre, length; nan as above."""
    polarisation: float
    momentum: float
    largest: float
    """Mean share of the agents in the largest group, %."""


class SortingSettings(Settings):
    """How long a group is left alone, and how often it is looked at then."""

    kind: ClassVar[str] = "sorting"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("front", "f", "Spearman's rank correlation of the own number with the mean place "
                "along the group's heading: above 0, those with more are in front", "1",
                "fewer than three agents", bounds=CORRELATION),
        Measure("centre", "c", "Spearman's rank correlation of the own number with the mean "
                "distance to the group's centre: above 0, those with less are near it", "1",
                "fewer than three agents", bounds=CORRELATION),
        Measure("order", "p", "Polarisation, mean over time", "1", bounds=SHARE),
        Measure("mills", "m", "Angular momentum, mean over time", "1", bounds=SHARE),
        Measure("largest", "largest", "Agents in the largest group, mean over time", "%",
                bounds=PERCENT),
    )  # fmt: skip

    settle: int = Field(ge=0)
    """Ticks before a group is looked at, from its start."""
    looks: int = Field(ge=1)
    """How often it is looked at; places are means over the looks."""
    every: int = Field(ge=1)
    """Ticks between two looks."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let the group settle, then look at it. Raises InputError."""
        places = self.places_of(flock, between)
        return {
            "front": rank_correlation(places.own, places.front),
            "centre": rank_correlation(places.own, places.distance),
            "order": places.polarisation,
            "mills": places.momentum,
            "largest": places.largest,
        }

    def places_of(self, flock: Flock, between: Callable[[], None] = lambda: None) -> Places:
        """Where the agents are on average, once the group has settled.

        Raises InputError unless they differ in exactly one parameter.
        """
        name = own_parameter(flock)
        between()
        flock.run(self.settle)
        n = len(flock.ids)
        seen, distance, front = np.zeros(n), np.zeros(n), np.zeros(n)
        states = []
        for _ in range(self.looks):
            between()
            flock.run(self.every)
            rows = np.flatnonzero(flock.group_labels() == 0)
            heading = flock.heading[rows].mean(axis=0)
            offset = flock.position[rows] - flock.position[rows].mean(axis=0)
            seen[rows] += 1.0
            distance[rows] += np.linalg.norm(offset, axis=1)
            front[rows] += offset @ heading / np.linalg.norm(heading)
            states.append(
                (
                    flock.observe("polarisation"),
                    flock.observe("angular-momentum"),
                    100.0 * len(rows) / n,
                )
            )
        times = np.where(seen >= OFTEN * self.looks, seen, np.nan)
        polarisation, momentum, largest = (float(mean) for mean in np.mean(states, axis=0))
        return Places(
            flock.own[name], distance / times, front / times, polarisation, momentum, largest
        )

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.settle + self.looks * self.every


def own_parameter(flock: Flock) -> str:
    """The parameter in which the agents differ. Raises InputError unless there is exactly one."""
    names = list(flock.spec.individuals)
    if len(names) != 1:
        raise InputError(
            f"agents differ in {', '.join(names) or 'nothing'}: their places are sorted by exactly "
            "one parameter, such as s = { uniform = [2.0, 4.0] }"
        )
    return names[0]


def rank_correlation(own: np.ndarray, place: np.ndarray) -> float | None:
    """Spearman's rank correlation of two values of agents (N,); nan in `place` is left out.

    None for fewer than three agents, or where all values of one of the two are equal.

    >>> rank_correlation(np.array([1.0, 2.0, 9.0]), np.array([0.1, 0.2, 0.3]))
    1.0
    """
    from scipy.stats import rankdata

    kept = np.isfinite(place)
    if kept.sum() < FEWEST:
        return None
    first, second = (rankdata(values[kept]) for values in (own, place))
    if np.ptp(first) == 0.0 or np.ptp(second) == 0.0:
        return None
    return round(float(np.corrcoef(first, second)[0, 1]), 12)  # 1, not 1 + 2e-16


SHOWN = (("front", "place along the heading"), ("distance", "distance to the centre"))
"""What is drawn of one run: of the first row for the one, of the second for the other."""


def draw_sorting(figure: Any, experiment: Experiment, verdicts: list[Verdict], seed: int) -> None:
    """Draw the agents of a run of the first two rows, and the correlations of all runs below."""
    settings = experiment.settings
    assert isinstance(settings, SortingSettings)
    figure.set_size_inches(11.4, 8.4)
    above, below = figure.subplots(2, 2)
    for k, (case, axes, (name, words)) in enumerate(
        zip(experiment.cases, above, SHOWN, strict=False)
    ):
        flock = flock_of(case, seed)
        places = settings.places_of(flock)
        values = getattr(places, name)
        axes.plot(places.own, values, "o", color=COLOURS[k % len(COLOURS)], markersize=4)
        axes.axhline(0.0, color=RULER, linewidth=1.0)
        axes.set(xlabel=label_of(flock), ylabel=f"mean {words} / length")
        correlation = rank_correlation(places.own, values)
        told = "" if correlation is None else f", rank correlation {correlation:.2f}"
        axes.set_title(f"{case.label}, seed {seed}{told}", loc="left", fontsize=10)
    for axes, (name, words) in zip(below, (("front", SHOWN[0][1]), ("centre", SHOWN[1][1])),
                                   strict=True):  # fmt: skip
        rows = verdicts_on(verdicts, name)
        for x, row in enumerate(rows):
            box(axes, x, row.values, COLOURS[x % len(COLOURS)], 0.4)
        axes.axhline(0.0, color=RULER, linewidth=1.0)
        axes.set_ylim(-1.05, 1.05)
        axes.set_xticks(range(len(rows)), [fill(row.case.label, 10) for row in rows], fontsize=8)
        axes.set_ylabel("rank correlation")
        axes.set_title(f"own number and {words}, all runs", loc="left", fontsize=10)
    draw_key(figure, [], WORDS)


def label_of(flock: Flock) -> str:
    """The words and the unit of the parameter in which agents differ."""
    name = own_parameter(flock)
    parameters = declared(model(flock.spec.model).parameters)
    found = next(one for one in parameters if one.name == name)
    return found.words + ("" if found.unit == "1" else f" / {found.unit}")


PICTURES = {"sorting": draw_sorting}
