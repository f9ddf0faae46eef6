"""Success on a mission: a panel per size of flock, every run a dot, beside the published one."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.pictures.boxes import came, explain
from app.studies.pictures.convergence.models import MEASURED, PUBLISHED, published
from app.studies.verdicts.verdict import Verdict, main_ones

WIDTH = 0.36


def draw_success(figure: Any, made: list[Verdict]) -> None:
    """Draw the panels."""
    rows = main_ones(made)
    sizes = sorted({one.case.agents for one in rows})
    figure.set_size_inches(4.4 * len(sizes) + 0.6, 5.4)
    panels = figure.subplots(1, len(sizes), sharey=True, squeeze=False)[0]
    for axes, agents in zip(panels, sizes, strict=True):
        here = [one for one in rows if one.case.agents == agents]
        for x, one in enumerate(here):
            draw_row(axes, x - 0.21, one)
            if one.published:
                published(axes, x + 0.21, one.published.mean, one.published.quartiles)
        axes.set_title(f"N = {agents}")
        axes.set_xticks(range(len(here)), [one.case.label for one in here])
        axes.tick_params(axis="x", length=0, labelsize=8.5)
        axes.set_xlim(-0.6, len(here) - 0.4)
        axes.set_ylim(-3, 103)
    panels[0].set_ylabel("$P_s$ / %")
    signs(figure)


def draw_row(axes: Any, x: float, one: Verdict) -> None:
    """Draw the runs of a row, the box from quartile to quartile, and the mean with its interval."""
    values = came(one.values)
    if values.size == 0:
        return
    half = WIDTH / 2
    low, middle, high = one.summary.quartiles
    axes.fill_between(
        [x - half, x + half], low, high, facecolor=MEASURED + "30", edgecolor=MEASURED, linewidth=1
    )
    axes.plot([x - half, x + half], [middle, middle], color=MEASURED, linewidth=2.2)
    aside = np.random.default_rng(0).uniform(-0.8 * half, 0.8 * half, values.size)
    axes.plot(x + aside, values, ".", color=MEASURED, markersize=3, alpha=0.45, zorder=2.5)
    axes.plot(
        [x, x],
        one.summary.interval,
        color="#0b2545",
        linewidth=2.0,
        solid_capstyle="round",
        zorder=4,
    )
    axes.plot([x], [one.summary.mean], "o", color="#0b2545", markersize=5, zorder=5,
              markeredgecolor="white", markeredgewidth=0.8)  # fmt: skip


def signs(figure: Any) -> None:
    """Say what is what, below the panels."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    explain(
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
