"""Least distance between an agent and anything in each run: a panel per size of flock."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.verdicts.verdict import Verdict, main_ones

COLOURS = ("#2166ac", "#b07d12", "#1f9d63", "#c0392b")
SAFE = 1.0
"""d_min of Wu et al. 2023, table 3, m."""


def draw_distances(figure: Any, made: list[Verdict]) -> None:
    """Draw the panels."""
    rows = main_ones(made)
    sizes = sorted({one.case.agents for one in rows})
    labels = list(dict.fromkeys(one.case.label for one in rows))
    figure.set_size_inches(3.4 * len(sizes) + 0.8, 4.4)
    panels = figure.subplots(1, len(sizes), sharey=True, squeeze=False)[0]
    for axes, agents in zip(panels, sizes, strict=True):
        for one in rows:
            if one.case.agents == agents:
                k = labels.index(one.case.label)
                values = np.array([np.nan if v is None else v for v in one.values], float)
                axes.plot(
                    np.arange(1, values.size + 1), values, "o", markersize=3.6, alpha=0.75,
                    color=COLOURS[k], markeredgewidth=0, label=one.case.label,
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
