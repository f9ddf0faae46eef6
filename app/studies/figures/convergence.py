"""Mean convergence time over the values of a parameter: a panel per sweep, a line per size."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from agents.state.start import goal_heading
from app.studies.charts.boxes import WORDS, box, draw_key
from app.studies.charts.colour_table import COLOURS, MARKERS
from app.studies.charts.mean_line import INTERVAL_WORDS, draw_mean_bars
from app.studies.judge.verdict import Verdict, group_by_sweep, name
from app.studies.measure import COUNT, HALF_TURN, Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

# Runs until a flock is consistent: Liu et al. 2021, section 3.1.

UNKNOWN_TICKS = 30.0
"""Ticks to convergence where nothing is published."""


class ConvergenceSettings(Settings):
    """When a flock counts as consistent, and when a run is given up."""

    kind: ClassVar[str] = "convergence"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure(
            "k_con",
            "k_con",
            "Time to consistency",
            "ticks",
            "not consistent",
            whole=True,
            bounds=COUNT,
            limited=True,
        ),
        Measure(
            "off",
            "off theta_d",
            "Angle of the mean heading to the reference state at the end",
            "deg",
            bounds=HALF_TURN,
        ),
    )

    desired: float = Field(gt=0.0, lt=1.0)
    hold: int = Field(ge=1)
    limit: int = Field(ge=1)

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """k_con (27); None if the run was given up."""
        k = flock.run_until_consistent(self.limit, self.desired, self.hold, between=between)
        return {"k_con": k, "off": from_reference(flock)}

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """The published time and the ticks for which it has to hold."""
        return (published or UNKNOWN_TICKS) + self.hold


def from_reference(flock: Flock) -> float:
    """Angle of the mean heading of a flock to the reference state, theta_d, degrees."""
    mean, reference = flock.heading.sum(0), goal_heading(flock.heading.shape[1])
    mean /= np.linalg.norm(mean)
    half = math.atan2(np.linalg.norm(mean - reference), np.linalg.norm(mean + reference))
    return math.degrees(2.0 * half)


# Convergence times of models: a panel per size of flock, measured beside published.

MEASURED = "#2166ac"
DIFFERS = "#b07d12"
PUBLISHED = "#3c434b"
WIDTH = 0.36


def draw_models(figure: Any, main: list[Verdict]) -> None:
    """Draw the panels."""
    sizes = sorted({verdict.case.agents for verdict in main})
    figure.set_size_inches(4.3 * len(sizes) + 0.6, 5.2)
    panels = figure.subplots(1, len(sizes), sharey=True, squeeze=False)[0]
    for axes, agents in zip(panels, sizes, strict=True):
        rows = [verdict for verdict in main if verdict.case.agents == agents]
        for x, point in enumerate(rows):
            row = point.published
            colour = DIFFERS if point.word == "differs" else MEASURED
            box(axes, x - 0.21, point.values, colour, WIDTH)
            if row:
                published(axes, x + 0.21, row.mean, row.quartiles)
        axes.set_yscale("log")
        axes.set_title(f"N = {agents}")
        axes.set_xticks(range(len(rows)), [row.case.spec.model.upper() for row in rows])
        axes.tick_params(axis="x", length=0, labelsize=9)
        axes.set_xlim(-0.6, len(rows) - 0.4)
    panels[0].set_ylabel("$k_{con}$ / ticks")
    signs_below(figure, any(r.published for r in main))


def published(axes: Any, x: float, mean: float | None, quartiles: tuple | None) -> None:
    """Draw the published quartiles as an open box with the mean as a diamond."""
    if quartiles:
        low, middle, high = quartiles
        half = WIDTH / 2
        axes.fill_between([x - half, x + half], low, high, facecolor="#ffffff", edgecolor=PUBLISHED)
        axes.plot([x - half, x + half], [middle, middle], color=PUBLISHED, linewidth=2.2)
    if mean is not None:
        axes.plot([x], [mean], marker="D", markersize=4.5, color=PUBLISHED, linestyle="none")


def signs_below(figure: Any, with_published: bool) -> None:
    """Say what is what, below the panels."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    signs: list[Any] = [Patch(facecolor=MEASURED + "40", edgecolor=MEASURED, label="measured")]
    if with_published:
        signs += [
            Patch(facecolor=DIFFERS + "40", edgecolor=DIFFERS, label="measured, differs"),
            Patch(facecolor="white", edgecolor=PUBLISHED, label="published quartiles"),
            Line2D([], [], marker="D", color=PUBLISHED, linestyle="none", label="published mean"),
        ]
    draw_key(figure, signs, WORDS)


# Convergence times with and without something: pairs of boxes for each size of flock.

PAIR_COLOURS = ("#c0392b", "#2166ac", "#3c434b", "#b07d12")
"""With in red and without in blue, as the paper's figure 6."""
STEP = 0.34


def draw_pairs(figure: Any, main: list[Verdict]) -> None:
    """Draw the boxes, one group per size of flock."""
    from matplotlib.patches import Patch

    figure.set_size_inches(7.2, 5.0)
    axes = figure.subplots()
    cases = [verdict.case for verdict in main]
    sizes = sorted({case.agents for case in cases})
    values = list(dict.fromkeys(case.value for case in cases))
    colour = dict(zip(values, PAIR_COLOURS, strict=False))
    for verdict in main:
        case = verdict.case
        k = values.index(case.value)
        x = sizes.index(case.agents) + STEP * (k - (len(values) - 1) / 2)
        box(axes, x, verdict.values, colour[case.value], 0.8 * STEP)
    axes.set_xticks(range(len(sizes)), [f"N = {n}" for n in sizes])
    axes.tick_params(axis="x", length=0)
    axes.set_xlim(-0.6, len(sizes) - 0.4)
    axes.set_ylim(bottom=0)
    axes.set_ylabel("$k_{con}$ / ticks")
    parameter = cases[0].sweep.parameter.replace("_", " ") if cases[0].sweep else ""
    signs = [
        Patch(facecolor=colour[v] + "40", edgecolor=colour[v], label=f"{parameter} {name(v)}")
        for v in values
    ]
    draw_key(figure, signs, WORDS)


SYMBOLS = {"p1": "$p_1$", "p2": "$p_2$"}
LINEAR_TO = 0.01
"""The logarithmic axis is linear up to here where it has to show 0."""


def draw_sweeps(figure: Any, main: list[Verdict]) -> None:
    """Draw the panels."""
    from matplotlib.ticker import LogLocator, ScalarFormatter

    swept = group_by_sweep(main)
    sweeps = list({id(sweep): sweep for sweep, _, _ in swept}.values())
    figure.set_size_inches(5.2 * len(sweeps), 4.8)
    panels = figure.subplots(1, len(sweeps), squeeze=False)[0]
    for axes, sweep in zip(panels, sweeps, strict=True):
        lines = [(agents, points) for paper_sweep, agents, points in swept if paper_sweep is sweep]
        for k, (agents, points) in enumerate(lines):
            draw_mean_bars(
                axes,
                [float(p.case.value or 0.0) for p in points],
                [p.summary for p in points],
                COLOURS[k % len(COLOURS)],
                f"N = {agents}",
                marker=MARKERS[k % len(MARKERS)],
            )
        values = [float(value) for value in sweep.values]
        axes.set_xscale("symlog" if min(values) <= 0.0 else "log", **linear(values))
        axes.set_xticks(values, [f"{value:g}" for value in values], fontsize=9)
        axes.set_xlabel(SYMBOLS.get(sweep.parameter, sweep.parameter))
        fixed = ", ".join(f"{SYMBOLS.get(p, p)} = {name(v)}" for p, v in sweep.fixed.items())
        axes.set_title(f"{SYMBOLS.get(sweep.parameter, sweep.parameter)}, with {fixed}")
        if steep(lines):
            axes.set_yscale("log")
            axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axes.yaxis.set_major_formatter(ScalarFormatter())
        axes.minorticks_off()
    panels[0].set_ylabel("mean $k_{con}$ / ticks")
    draw_key(figure, panels[0].get_legend_handles_labels()[0], INTERVAL_WORDS)


def steep(lines: list[tuple[int, list[Verdict]]]) -> bool:
    """Whether the means of any line span so much that a logarithmic axis shows them better."""
    means = [[p.summary.mean for p in points] for _, points in lines]
    return any(max(line) > 4.0 * min(line) for line in means)


def linear(values: list[float]) -> dict[str, float]:
    """The linear part of the axis, where 0 is among the values."""
    return {"linthresh": LINEAR_TO, "linscale": 0.5} if min(values) <= 0.0 else {}


PICTURES = {"models": draw_models, "sweeps": draw_sweeps, "pairs": draw_pairs}
