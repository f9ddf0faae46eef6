"""What swarms look like over the two parameters of a sweep, at the end of the run of a seed."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.kinds.swarming import SwarmingSettings, room
from app.studies.pictures.boxes import explain
from app.studies.trial import flock_of
from app.studies.verdicts.phase_map import map_of
from app.studies.verdicts.verdict import Verdict

STABLE, CATASTROPHIC = "#eef3fb", "#fbf1ec"
LEAST, AROUND = 0.3, 2.4
"""What is shown at least, length, and how many radii around the centre."""
LENGTH = 0.16
"""Of an arrow, as a share of what is shown."""


def draw_gallery(figure: Any, experiment: Experiment, made: list[Verdict], seed: int) -> None:
    """A panel for each place of the map, the first parameter to the right, the second upwards."""
    from matplotlib.colors import hsv_to_rgb

    settings = experiment.settings
    assert isinstance(settings, SwarmingSettings)
    found = map_of(made)
    xs, ys = sorted({spot.x for spot in found}), sorted({spot.y for spot in found})
    figure.set_size_inches(2.5 * len(xs) + 0.6, 2.75 * len(ys) + 0.8)
    grid = figure.subplots(len(ys), len(xs), squeeze=False)
    for spot in found:
        axes = grid[len(ys) - 1 - ys.index(spot.y), xs.index(spot.x)]
        flock = flock_of(spot.case, seed)
        flock.run(settings.lasts)
        where = flock.position - flock.position.mean(axis=0)
        half = max(LEAST, AROUND * float(np.sqrt((where**2).sum(axis=1).mean())))
        hue = np.arctan2(flock.heading[:, 1], flock.heading[:, 0]) / (2.0 * np.pi) % 1.0
        colours = hsv_to_rgb(
            np.column_stack([hue, np.full_like(hue, 0.8), np.full_like(hue, 0.75)])
        )
        axes.quiver(
            *where.T, *(LENGTH * half * flock.heading).T, color=colours, angles="xy",
            scale_units="xy", scale=1.0, width=0.011, headwidth=4.0, headlength=4.5,
            headaxislength=4.0, pivot="mid",
        )  # fmt: skip
        stable = room(flock) > 1.0
        axes.set_facecolor(STABLE if stable else CATASTROPHIC)
        axes.set(xlim=(-half, half), ylim=(-half, half), aspect="equal", xticks=[], yticks=[])
        axes.grid(visible=False)
        for spine in axes.spines.values():
            spine.set_visible(False)
        name = f"{spot.phase} ({spot.share:.0%})"
        axes.set_title(f"{name}\n$C l^2$ = {room(flock):.2g}, {2.0 * half:.2g} m", fontsize=9)
        if spot.x == xs[0]:
            axes.set_ylabel(f"$C$ = {spot.y:g}")
        if spot.y == ys[0]:
            axes.set_xlabel(f"$l$ = {spot.x:g}")
    explain(
        figure,
        [],
        "blue: H-stable (C l^2 > 1), red: catastrophic; above each the shape of most runs with "
        f"their share, and the side of what is shown of the run of seed {seed}",
    )
