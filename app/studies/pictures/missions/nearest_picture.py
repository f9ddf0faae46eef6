"""The least distance of any agent to another or to an obstacle, over time, and in all runs."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from agents.observables.following import least_clearances, nearest_pairs
from app.studies.experiment import Case, Experiment
from app.studies.pictures.boxes import came, explain
from app.studies.pictures.missions.distances import SAFE
from app.studies.pictures.missions.duel import COLOURS
from app.studies.pictures.missions.flown_mission import FlownMission, flown
from app.studies.verdicts.verdict import Verdict, of

SHOWN = 180.0
"""Time that is shown, s: after it hardly anything moves."""
DANGER = "#c0392b"
INK = "#3c434b"


class NearestDistances(NamedTuple):
    """Least distances at each kept tick, (K,) each, length; inf where there is nothing."""

    agent: np.ndarray
    """Of two agents."""
    obstacle: np.ndarray
    """Of an agent to the surface of an obstacle."""

    @property
    def anything(self) -> np.ndarray:
        """The less of both, (K,)."""
        return np.minimum(self.agent, self.obstacle)


def draw_nearest(figure: Any, experiment: Experiment, made: list[Verdict], seed: int) -> None:
    """Draw the run of that seed of each row over time, and the least of each run beside it."""
    cases = experiment.cases
    figure.set_size_inches(12.6, 5.2)
    panels = figure.subplots(
        1, len(cases) + 1, sharey=True, width_ratios=[1.0] * len(cases) + [0.6]
    )
    for axes, case, colour in zip(panels, cases, COLOURS, strict=False):
        flight = flown(experiment, case, seed, every=1)
        found = nearness(flight)
        time = flight.record.dt * np.arange(len(found.agent))
        for values, style in ((found.agent, "-"), (found.obstacle, (0, (1.2, 1.2)))):
            axes.plot(time, values, color=INK, linewidth=0.8, linestyle=style, alpha=0.75)
        axes.plot(time, found.anything, color=colour, linewidth=2.4, alpha=0.85)
        axes.set_xlim(0.0, min(time[-1], SHOWN))
        axes.set_xlabel("time / s")
        axes.set_title(f"{case.label}: {found.anything.min():.2f} m at least", loc="left")
    draw_runs(panels[-1], of(made, "d_least"))
    for axes in panels:
        axes.axhline(SAFE, color=DANGER, linewidth=1.4)
    panels[0].set_ylim(0.0, 6.0)
    panels[0].set_ylabel("least distance / m")
    panels[0].annotate(
        "$d_{min}$", (0.98, SAFE), xycoords=("axes fraction", "data"), xytext=(0, 4),
        textcoords="offset points", ha="right", color=DANGER,
    )  # fmt: skip
    explain(
        figure,
        signs(cases),
        f"left: the run of seed {seed} of each row; right: the least of each run",
    )


def nearness(flight: FlownMission) -> NearestDistances:
    """The least distances at each kept tick of a flight, as its mission's measures have them."""
    n = len(flight.flock.ids)
    trace = np.ascontiguousarray(flight.record.position.transpose(0, 2, 1))
    agent, obstacle = np.full(len(trace), np.inf), np.full(len(trace), np.inf)
    for k in range(len(trace)):
        pairs, clear = np.full((n, n), np.inf), np.full(n, np.inf)
        nearest_pairs(trace[k : k + 1], pairs)
        least_clearances(trace[k : k + 1], flight.flock.engine.surroundings, clear)
        agent[k], obstacle[k] = np.sqrt(pairs.min()), clear.min()
    return NearestDistances(agent, obstacle)


def draw_runs(axes: Any, rows: list[Verdict]) -> None:
    """Draw the least distance of each run, a dot, by row."""
    for x, (one, colour) in enumerate(zip(rows, COLOURS, strict=False)):
        values = came(one.values)
        aside = np.random.default_rng(0).uniform(-0.22, 0.22, values.size)
        axes.plot(x + aside, values, "o", markersize=4, markeredgewidth=0, alpha=0.6, color=colour)
    axes.set_xticks(range(len(rows)), [one.case.label.replace(" ", "\n") for one in rows])
    axes.tick_params(axis="x", length=0)
    axes.set_xlim(-0.6, len(rows) - 0.4)
    axes.set_title("all runs", loc="left")


def signs(cases: list[Case]) -> list[Any]:
    """What is what."""
    from matplotlib.lines import Line2D

    thin: dict[str, Any] = {"color": INK, "linewidth": 0.8}
    return [
        *(
            Line2D([], [], color=colour, linewidth=2.4, label=f"{case.label}: to anything")
            for case, colour in zip(cases, COLOURS, strict=False)
        ),
        Line2D([], [], label="to another agent", **thin),
        Line2D([], [], linestyle=(0, (1.2, 1.2)), label="to an obstacle", **thin),
    ]
