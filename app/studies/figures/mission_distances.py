"""What turns of a scene do to a run: a line per row, a dot per turn."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from agents.observables.following import least_clearances, nearest_pairs
from app.studies.charts.boxes import draw_key, runs_with_value
from app.studies.experiment import Case, Experiment
from app.studies.figures.convergence import MEASURED, PUBLISHED, published
from app.studies.figures.mission import FlownMission, fly_mission
from app.studies.figures.mission_paths import COLOURS
from app.studies.judge.verdict import Verdict, main_verdicts, verdicts_on

# Least distance between an agent and anything in each run: a panel per size of flock.

ROW_COLOURS = ("#2166ac", "#b07d12", "#1f9d63", "#c0392b")
SAFE = 1.0
"""d_min of Wu et al. 2023, table 3, m."""


def draw_distances(figure: Any, verdicts: list[Verdict]) -> None:
    """Draw the panels."""
    rows = main_verdicts(verdicts)
    sizes = sorted({row.case.agents for row in rows})
    labels = list(dict.fromkeys(row.case.label for row in rows))
    figure.set_size_inches(3.4 * len(sizes) + 0.8, 4.4)
    panels = figure.subplots(1, len(sizes), sharey=True, squeeze=False)[0]
    for axes, agents in zip(panels, sizes, strict=True):
        for row in rows:
            if row.case.agents == agents:
                k = labels.index(row.case.label)
                values = np.array([np.nan if v is None else v for v in row.values], float)
                axes.plot(
                    np.arange(1, values.size + 1), values, "o", markersize=3.6, alpha=0.75,
                    color=ROW_COLOURS[k], markeredgewidth=0, label=row.case.label,
                )  # fmt: skip
        axes.axhline(SAFE, color="#c0392b", linewidth=1.4)
        axes.set_title(f"N = {agents}")
        axes.set_xlabel("run")
        axes.set_ylim(0.0, 2.2)
    panels[0].set_ylabel("least distance to an agent or an obstacle / m")
    panels[0].annotate(
        "$d_{min}$", (0.02, SAFE), xycoords=("axes fraction", "data"), xytext=(0, 4),
        textcoords="offset points", color="#c0392b",
    )  # fmt: skip
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc="outside lower left", ncols=len(labels)
    )


# The least distance of any agent to another or to an obstacle, over time, and in all runs.

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
    def least(self) -> np.ndarray:
        """The less of both, (K,)."""
        return np.minimum(self.agent, self.obstacle)


def draw_nearest(figure: Any, experiment: Experiment, verdicts: list[Verdict], seed: int) -> None:
    """Draw the run of that seed of each row over time, and the least of each run beside it."""
    cases = experiment.cases
    figure.set_size_inches(12.6, 5.2)
    panels = figure.subplots(
        1, len(cases) + 1, sharey=True, width_ratios=[1.0] * len(cases) + [0.6]
    )
    for axes, case, colour in zip(panels, cases, COLOURS, strict=False):
        flight = fly_mission(experiment, case, seed, every=1)
        found = measure_nearest(flight)
        time = flight.record.dt * np.arange(len(found.agent))
        for values, style in ((found.agent, "-"), (found.obstacle, (0, (1.2, 1.2)))):
            axes.plot(time, values, color=INK, linewidth=0.8, linestyle=style, alpha=0.75)
        axes.plot(time, found.least, color=colour, linewidth=2.4, alpha=0.85)
        axes.set_xlim(0.0, min(time[-1], SHOWN))
        axes.set_xlabel("time / s")
        axes.set_title(f"{case.label}: {found.least.min():.2f} m at least", loc="left")
    draw_runs(panels[-1], verdicts_on(verdicts, "d_least"))
    for axes in panels:
        axes.axhline(SAFE, color=DANGER, linewidth=1.4)
    panels[0].set_ylim(0.0, 6.0)
    panels[0].set_ylabel("least distance / m")
    panels[0].annotate(
        "$d_{min}$", (0.98, SAFE), xycoords=("axes fraction", "data"), xytext=(0, 4),
        textcoords="offset points", ha="right", color=DANGER,
    )  # fmt: skip
    draw_key(
        figure,
        nearest_signs(cases),
        f"left: the run of seed {seed} of each row; right: the least of each run",
    )


def measure_nearest(flight: FlownMission) -> NearestDistances:
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
    for x, (row, colour) in enumerate(zip(rows, COLOURS, strict=False)):
        values = runs_with_value(row.values)
        aside = np.random.default_rng(0).uniform(-0.22, 0.22, values.size)
        axes.plot(x + aside, values, "o", markersize=4, markeredgewidth=0, alpha=0.6, color=colour)
    axes.set_xticks(range(len(rows)), [row.case.label.replace(" ", "\n") for row in rows])
    axes.tick_params(axis="x", length=0)
    axes.set_xlim(-0.6, len(rows) - 0.4)
    axes.set_title("all runs", loc="left")


def nearest_signs(cases: list[Case]) -> list[Any]:
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


# Success on a mission: a panel per size of flock, every run a dot, beside the published one.

WIDTH = 0.36


def draw_success(figure: Any, verdicts: list[Verdict]) -> None:
    """Draw the panels."""
    rows = main_verdicts(verdicts)
    sizes = sorted({row.case.agents for row in rows})
    figure.set_size_inches(4.4 * len(sizes) + 0.6, 5.4)
    panels = figure.subplots(1, len(sizes), sharey=True, squeeze=False)[0]
    for axes, agents in zip(panels, sizes, strict=True):
        at_size = [row for row in rows if row.case.agents == agents]
        for x, verdict in enumerate(at_size):
            draw_row(axes, x - 0.21, verdict)
            if verdict.published:
                published(axes, x + 0.21, verdict.published.mean, verdict.published.quartiles)
        axes.set_title(f"N = {agents}")
        axes.set_xticks(range(len(at_size)), [verdict.case.label for verdict in at_size])
        axes.tick_params(axis="x", length=0, labelsize=8.5)
        axes.set_xlim(-0.6, len(at_size) - 0.4)
        axes.set_ylim(-3, 103)
    panels[0].set_ylabel("$P_s$ / %")
    success_signs(figure)


def draw_row(axes: Any, x: float, verdict: Verdict) -> None:
    """Draw the runs of a row, the box from quartile to quartile, and the mean with its interval."""
    values = runs_with_value(verdict.values)
    if values.size == 0:
        return
    half = WIDTH / 2
    low, middle, high = verdict.summary.quartiles
    axes.fill_between(
        [x - half, x + half], low, high, facecolor=MEASURED + "30", edgecolor=MEASURED, linewidth=1
    )
    axes.plot([x - half, x + half], [middle, middle], color=MEASURED, linewidth=2.2)
    aside = np.random.default_rng(0).uniform(-0.8 * half, 0.8 * half, values.size)
    axes.plot(x + aside, values, ".", color=MEASURED, markersize=3, alpha=0.45, zorder=2.5)
    axes.plot(
        [x, x],
        verdict.summary.interval,
        color="#0b2545",
        linewidth=2.0,
        solid_capstyle="round",
        zorder=4,
    )
    axes.plot([x], [verdict.summary.mean], "o", color="#0b2545", markersize=5, zorder=5,
              markeredgecolor="white", markeredgewidth=0.8)  # fmt: skip


def success_signs(figure: Any) -> None:
    """Say what is what, below the panels."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    draw_key(
        figure,
        [
            Patch(facecolor=MEASURED + "30", edgecolor=MEASURED, label="measured quartiles"),
            Line2D([], [], marker=".", color=MEASURED, linestyle="none", label="a run"),
            Line2D([], [], marker="o", color="#0b2545", label="measured mean, 95 % interval"),
            Patch(facecolor="white", edgecolor=PUBLISHED, label="published quartiles"),
            Line2D([], [], marker="D", color=PUBLISHED, linestyle="none", label="published mean"),
        ],
        "share of the UAVs that are linked to the information UAV all the time",
    )


COLOUR = "#2166ac"


def draw_turned(figure: Any, verdicts: list[Verdict]) -> None:
    """Draw the main measure of all runs, each row's on a line of its own."""
    rows = [
        verdict
        for verdict in main_verdicts(verdicts)
        if any(value is not None for value in verdict.values)
    ]
    figure.set_size_inches(7.6, 0.42 * len(rows) + 1.2)
    axes = figure.subplots()
    for k, row in enumerate(rows):
        values = np.array([value for value in row.values if value is not None], float)
        axes.plot(values, np.full(values.size, k), "o", markersize=5, alpha=0.35, color=COLOUR,
                  markeredgewidth=0)  # fmt: skip
    names = [f"{row.case.label}, N = {row.case.agents}" for row in rows]
    axes.set_yticks(range(len(rows)), names)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_xlim(left=0.0)
    axes.grid(axis="x", alpha=0.3)
    if rows:
        axes.set_xlabel(f"{rows[0].measure.title} / {rows[0].unit}")


PICTURES = {
    "success": draw_success,
    "distances": draw_distances,
    "turned": draw_turned,
    "nearest": draw_nearest,
}
