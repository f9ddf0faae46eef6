"""Cars that are to stay near a place: their way from above, and their distance over time."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from app.studies.charts.boxes import draw_key, runs_with_value
from app.studies.experiment import Experiment, flock_of
from app.studies.figures.driving import CARS, INJECTED, STOPS
from app.studies.judge.verdict import Verdict, verdicts_on
from app.studies.measure import COUNT, SUCCESS, Measure, Number, Settings
from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents import Flock

# Runs of cars that are to stay near a place: Jacobs and Koessler, gallery figure 1.

CHUNK = 500
"""Ticks between two looks at whether the run is to end."""


class HoldingSettings(Settings):
    """How long cars drive, and when they are to have come."""

    kind: ClassVar[str] = "holding"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure(
            "held",
            "held",
            "Runs in which no car leaves the radius again",
            "%",
            whole=True,
            bounds=SUCCESS,
        ),
        Measure("furthest", "furthest", "Largest distance to the place, once they have come", "m"),
        Measure("mean", "mean", "Mean distance to the place, once they have come", "m"),
        Measure(
            "came",
            "came",
            "Time at which the last car comes within the radius",
            "s",
            "never",
            bounds=COUNT,
            limited=True,
        ),
        Measure(
            "collision", "collision", "Runs in which cars touch", "%", whole=True, bounds=SUCCESS
        ),
    )

    limit: float = Field(gt=0.0)
    """How long a run lasts, s."""
    radius: float = Field(gt=0.0)
    """The set radius, m."""
    late: float = Field(gt=0.0)
    """Time from which on cars count as having come, s."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Drive, and measure the distances. Raises InputError if there is no place to stay near."""
        away = self.distances(flock, self.drive(flock, between))
        late = away[round(self.late / flock.dt) :]
        inside = np.flatnonzero((away <= self.radius).all(axis=1))
        touched = STOPS in flock.model.signals and bool(flock.signal(STOPS).any())
        return {
            "held": 100 * bool((late <= self.radius).all()),
            "furthest": float(late.max()),
            "mean": float(late.mean()),
            "came": float(inside[0] * flock.dt) if len(inside) else None,
            "collision": 100 * touched,
        }

    def drive(self, flock: Flock, between: Callable[[], None] = lambda: None) -> np.ndarray:
        """Positions at every tick from 0 to the limit, (T + 1, N, 2), m."""
        if flock.world.mission is None or flock.world.mission.goal is None:
            raise InputError(
                f"the world {flock.world.name!r} has no place to stay near: it has no goal"
            )
        ticks = int(self.ticks(None, flock.dt))
        positions = [flock.position[None].copy()]
        while flock.tick < ticks:
            between()
            positions.append(flock.trace(min(CHUNK, ticks - flock.tick)))
        return np.concatenate(positions)

    def distances(self, flock: Flock, position: np.ndarray) -> np.ndarray:
        """Distances of positions (T, N, 2) from tick 0 on to the place, (T, N), m."""
        goal = flock.goal_at(np.arange(len(position)))
        return np.linalg.norm(position - goal[:, None], axis=2)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return round(self.limit / dt)


RADIUS, LATE, INK = "#c0392b", "#7a828c", "#3c434b"


def draw_holding(figure: Any, experiment: Experiment, verdicts: list[Verdict], seed: int) -> None:
    """Draw the first row's run of that seed, and how far the cars of all runs go."""
    from matplotlib.patches import Circle, Rectangle

    settings, case = experiment.settings, experiment.cases[0]
    assert isinstance(settings, HoldingSettings)
    flock = flock_of(case, seed)
    position = settings.drive(flock)
    away = settings.distances(flock, position)
    figure.set_size_inches(12.8, 5.6)
    above, over_time, runs = figure.subplots(1, 3, width_ratios=[1.0, 1.25, 0.55])
    low, size = np.array(flock.world.low), np.array(flock.world.size)
    goal = flock.goal_at([0])[0]
    above.add_patch(Rectangle((low[0], low[1]), *size, fill=False, edgecolor="#aab2bd"))
    above.add_patch(Circle(goal, settings.radius, fill=False, edgecolor=RADIUS, linewidth=1.6))
    time = flock.dt * np.arange(len(position))
    for row in range(position.shape[1]):
        colour = CARS[row % len(CARS)]
        above.plot(*position[:, row].T, color=colour, linewidth=0.9)
        above.plot(*position[0, row], "o", color=colour, markersize=7, markeredgecolor="white")
        over_time.plot(time, away[:, row], color=colour, linewidth=1.2)
    above.plot(*goal, "*", color=INJECTED, markersize=14, markeredgecolor=INK, zorder=5)
    above.grid(visible=False)
    above.set(
        aspect="equal",
        xlim=(low[0] - 0.1, low[0] + size[0] + 0.1),
        ylim=(low[1] - 0.1, low[1] + size[1] + 0.1),
        xlabel="x / m",
        ylabel="y / m",
    )
    above.set_title(f"N = {case.agents}, seed {seed}, in the capture area", loc="left")
    over_time.axvline(settings.late, color=LATE, linewidth=1.0, linestyle=(0, (4, 3)))
    over_time.annotate(
        "looked at from here", (settings.late, 1.0), (5, -4), xycoords=("data", "axes fraction"),
        textcoords="offset points", va="top", fontsize=9, color=LATE,
    )  # fmt: skip
    over_time.set_xlim(0.0, time[-1])
    over_time.set_xlabel("time / s")
    over_time.set_ylabel("distance to the place / m")
    draw_runs(runs, verdicts_on(verdicts, "furthest"))
    for axes in (over_time, runs):
        axes.axhline(settings.radius, color=RADIUS, linewidth=1.6)
        axes.set_ylim(0.0, 1.12 * max(settings.radius, float(away.max())))
    draw_key(figure, signs(settings.radius), "")


def draw_runs(axes: Any, points: list[Verdict]) -> None:
    """Draw the largest distance of each run, a dot, by row."""
    for x, point in enumerate(points):
        values = runs_with_value(point.values)
        aside = np.random.default_rng(0).uniform(-0.22, 0.22, values.size)
        axes.plot(x + aside, values, ".", color=CARS[0], markersize=6, alpha=0.55)
    axes.set_xticks(range(len(points)), [f"N = {point.case.agents}" for point in points])
    axes.tick_params(axis="x", length=0)
    axes.set_xlim(-0.6, len(points) - 0.4)
    axes.set_title("furthest, all runs", loc="left")


def signs(radius: float) -> list[Any]:
    """What is what."""
    from matplotlib.lines import Line2D

    star: dict[str, Any] = {
        "marker": "*",
        "linestyle": "none",
        "markersize": 13,
        "markeredgecolor": INK,
    }
    return [
        Line2D([], [], color=INJECTED, label="the place", **star),
        Line2D([], [], color=RADIUS, linewidth=1.6, label=f"the set radius, {radius:g} m"),
        Line2D([], [], color=CARS[0], linewidth=1.2, label="the car; a dot where it starts"),
    ]


PICTURES = {"holding": draw_holding}
