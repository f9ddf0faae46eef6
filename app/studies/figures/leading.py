"""Where a group goes of which some agents prefer a direction, or two."""

from __future__ import annotations

from collections.abc import Callable
from textwrap import fill
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from app.studies.charts.boxes import WORDS, box, draw_key
from app.studies.charts.colour_table import COLOURS, RULER
from app.studies.experiment import Experiment, flock_of
from app.studies.judge.verdict import Verdict, verdicts_on
from app.studies.measure import COUNT, HALF_TURN, PERCENT, Measure, MeasureBounds, Number, Settings
from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents import Flock

# Runs in which informed agents lead a group: Couzin et al. 2005.

COSINE = MeasureBounds(-1.0, 1.0)
CHUNK = 500
"""Ticks between two looks at the world outside."""


class LeadingSettings(Settings):
    """How long a group goes, and over which time before the end its direction is measured."""

    kind: ClassVar[str] = "leading"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("accuracy", "cos", "Cosine of the angle between the way of the group's centre and "
                "the preferred direction; of two, their middle", "1", bounds=COSINE),
        Measure("apart", "angle", "That angle", "deg", bounds=HALF_TURN),
        Measure("choice", "choice", "That angle over the angle of a preferred direction to the "
                "middle of both: 0 is a compromise, 1 the way of one of the two", "1",
                "one preferred direction", bounds=COUNT),
        Measure("largest", "largest", "Agents in the largest group at the end", "%",
                bounds=PERCENT),
    )  # fmt: skip

    lasts: float = Field(gt=0.0)
    """For which a group goes, s."""
    over: float = Field(gt=0.0)
    """The last part of that, over which its direction is measured, s."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let the group go, and measure where it goes at the end. Raises InputError."""
        middle, half = preferred_directions(flock)
        left = round((self.lasts - self.over) / flock.dt)
        while left > 0:
            between()
            flock.run(min(CHUNK, left))
            left -= CHUNK
        before = flock.position.mean(axis=0)
        flock.run(round(self.over / flock.dt))
        way = flock.position.mean(axis=0) - before
        cosine = float(np.clip(way @ middle / np.linalg.norm(way), -1.0, 1.0))
        angle = float(np.degrees(np.arccos(cosine)))
        return {
            "accuracy": cosine,
            "apart": angle,
            "choice": angle / half if half > 0.0 else None,
            "largest": 100.0 * float(flock.observe("largest-group")) / len(flock.ids),
        }

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.lasts / dt


def preferred_directions(flock: Flock) -> tuple[np.ndarray, float]:
    """The middle of the preferred directions, a unit vector (2,), and how far each is from it, deg.

    Those of the agents with a weight omega above 0. Raises InputError unless there are one or two,
    which are less than 180 deg apart.
    """
    p: Any = flock.parameters
    n = len(flock.ids)
    weight = flock.own.get("omega", np.full(n, p.omega))
    direction = flock.own.get("g", np.full(n, p.g))
    found = np.unique(direction[weight > 0.0])
    if len(found) not in (1, 2):
        raise InputError(
            f"{len(found)} preferred directions (g of agents with omega > 0): one or two are needed"
        )
    vectors = np.column_stack([np.cos(np.radians(found)), np.sin(np.radians(found))])
    middle = vectors.mean(axis=0)
    length = float(np.linalg.norm(middle))
    if length < 1e-9:
        raise InputError(f"g = {found[0]:g} and {found[1]:g} deg are opposite: they have no middle")
    return middle / length, float(np.degrees(np.arccos(min(1.0, length))))


def draw_leading(figure: Any, experiment: Experiment, verdicts: list[Verdict], seed: int) -> None:
    """Draw the way of a group of each row of the last one's size, and two measures of all runs."""
    figure.set_size_inches(13.4, 4.8)
    paths, sizes, choices = figure.subplots(1, 3, width_ratios=[1.3, 0.8, 1.0])
    settings = experiment.settings
    assert isinstance(settings, LeadingSettings)
    shown = [case for case in experiment.cases if case.agents == experiment.cases[-1].agents]
    for k, case in enumerate(shown):
        flock = flock_of(case, seed)
        middle, _ = preferred_directions(flock)
        turned = np.column_stack([middle, [-middle[1], middle[0]]])  # the middle points right
        places = [flock.position.mean(axis=0)]
        for _ in range(round(settings.lasts / flock.dt / CHUNK) * 10):
            flock.run(CHUNK // 10)
            places.append(flock.position.mean(axis=0))
        way = (np.array(places) - places[0]) @ turned
        paths.plot(*way.T, color=COLOURS[k % len(COLOURS)], linewidth=1.4, label=case.label)
    paths.plot(0.0, 0.0, "o", color=RULER, markersize=5)
    paths.set(aspect="equal", xlabel="way along the middle of what is preferred / length",
              ylabel="aside / length")  # fmt: skip
    paths.set_title(f"way of the centre, N = {shown[0].agents}, seed {seed}", loc="left")
    of_one = [row for row in verdicts_on(verdicts, "choice") if not any_value(row)]
    labels = {row.case.label for row in of_one}
    rows = [row for row in verdicts_on(verdicts, "accuracy") if row.case.label in labels]
    draw_boxes(sizes, rows, [f"N = {row.case.agents}" for row in rows])
    sizes.set_title("cosine to what is preferred, all runs", loc="left", fontsize=10)
    rows = [row for row in verdicts_on(verdicts, "choice") if any_value(row)]
    draw_boxes(choices, rows, [row.case.label for row in rows])
    choices.axhline(1.0, color=RULER, linewidth=1.0, linestyle=":")
    choices.set_title("0: compromise, 1: choice, all runs", loc="left", fontsize=10)
    draw_key(figure, paths.get_legend_handles_labels()[0], WORDS)


def any_value(row: Verdict) -> bool:
    """Whether some run of a row has the measure."""
    return any(value is not None for value in row.values)


def draw_boxes(axes: Any, rows: list[Verdict], labels: list[str]) -> None:
    """Draw the runs of each row."""
    for x, row in enumerate(rows):
        box(axes, x, row.values, COLOURS[x % len(COLOURS)], 0.4)
    axes.set_xticks(range(len(rows)), [fill(label, 12) for label in labels], fontsize=8)


PICTURES = {"leading": draw_leading}
