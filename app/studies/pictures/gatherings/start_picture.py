"""A flock at its start: in its box, and how its speeds, headings and distances are spread."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.kinds.beginning import gaps
from app.studies.pictures.gatherings.box import draw_box
from app.studies.trial import flock_of

RAMP = ("#d9b8ea", "#7b2fa8", "#2e0a47")
"""Violet, the darker the faster, as in the thesis."""
BARS, CHANCE = "#8e5bb0", "#1f9d63"
BINS = 10


def draw_start(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the first row's flock of that seed before its first tick."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    case = experiment.cases[0]
    flock = flock_of(case, seed)
    figure.set_size_inches(12.0, 6.4)
    left, right = figure.subfigures(1, 2, width_ratios=[1.75, 1.0])
    axes = left.subplots(subplot_kw={"projection": "3d"})
    fastest = float(flock.speed.max())
    scale = Normalize(0.0, fastest)
    ramp = LinearSegmentedColormap.from_list("speed", RAMP)
    draw_box(axes, flock, list(ramp(scale(flock.speed[flock.active]))))
    blocks = f", {len(flock.world.obstacles)} blocks" if flock.world.obstacles else ""
    axes.set_title(f"{case.agents} agents{blocks}, seed {seed}, before the first tick", loc="left")
    bar = left.colorbar(
        ScalarMappable(scale, ramp), ax=axes, location="bottom", shrink=0.45, aspect=30, pad=0.0
    )
    bar.outline.set_visible(False)
    bar.set_label("speed / (length/s)", fontsize=9)
    panels = right.subplots(3, 1)
    draw_spread(panels[0], flock.speed, (0.0, fastest), "speed / (length/s)")
    draw_spread(panels[1], flock.heading[:, 2], (-1.0, 1.0), "upward part of the heading")
    near = gaps(flock)
    draw_spread(
        panels[2],
        near,
        (0.0, float(near.max())),
        "distance to the nearest agent / length",
        even=False,
    )


def draw_spread(
    axes: Any, values: np.ndarray, span: tuple[float, float], words: str, even: bool = True
) -> None:
    """Draw how many agents have which value (N,); `even`: beside what chance makes of each bin."""
    axes.hist(values, bins=BINS, range=span, color=BARS, rwidth=0.92)
    if even:
        axes.axhline(len(values) / BINS, color=CHANCE, linewidth=1.3, linestyle=(0, (4, 3)))
        axes.annotate(
            "dashed: evenly spread", (1.0, 1.0), xycoords="axes fraction", xytext=(0, 3),
            textcoords="offset points", ha="right", fontsize=8, color=CHANCE,
        )  # fmt: skip
    axes.set_xlim(*span)
    axes.xaxis.get_major_locator().set_params(nbins=5)
    axes.set_xlabel(words)
    axes.set_ylabel("agents")
