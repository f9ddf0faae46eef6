"""A mission at six instants: where the flock is in the scene, and how it looks from close."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.kinds.mission import MissionSettings
from app.studies.pictures.missions.flown_mission import flown
from app.studies.pictures.missions.mission_scene import (
    INFORMED,
    LOST,
    draw_links,
    draw_world,
    extent,
    show_box,
)
from app.studies.trial import flock_of

INSTANTS = (1, 80, 320, 485, 560)
"""k of Liu et al. 2021, figure 8; the sixth is the end."""
HALF = np.array([4.4, 3.0])
"""Half the sides of a panel, length."""
COLOURS = ("#12427c", "#2f74b8", "#6aa9d8", "#a7cfe8")
"""Colours of layers 2, 3, 4 and further."""


def draw_snapshots(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the first row's run of that seed."""
    case = experiment.cases[0]
    assert isinstance(experiment.settings, MissionSettings)
    end = flown(experiment, case, seed).record.ticks
    figure.set_size_inches(12.4, 10.6)
    figure.get_layout_engine().set(h_pad=0.1)
    panels = figure.subplot_mosaic(
        [["all"] * 3, list("abc"), list("def")], height_ratios=[1.12, 1, 1]
    )
    whole = panels["all"]
    flock = flock_of(case, seed)
    draw_world(whole, flock.world)
    places = []
    for letter, k in zip("abcdef", (*(k for k in INSTANTS if k < end), end), strict=False):
        flock.run(k - flock.tick)
        near = flock.layers() <= len(flock.ids)
        middle = np.median(flock.position[near], axis=0)[:2]
        draw_one(panels[letter], flock, middle)
        panels[letter].set_title(f"({letter}) k = {k}", loc="left")
        whole.scatter(*flock.position[:, :2].T, s=8, c=layer_colours(flock), zorder=5)
        top = flock.position[near, 1].max()
        whole.annotate(
            f"({letter})", (middle[0], top), (0, 6), textcoords="offset points", ha="center"
        )
        places.append(flock.position[near])
    show_box(whole, *extent(flock.world, np.concatenate(places), 1.6))
    whole.set_title(f"{case.label}, N = {case.agents}, seed {seed}", loc="left")
    signs(figure)


def draw_one(axes: Any, flock: Any, middle: np.ndarray) -> None:
    """Draw the flock around a place: links, and agents as arrow heads in their layer's colour."""
    draw_world(axes, flock.world)
    draw_links(axes, flock.position, flock.links())
    axes.quiver(
        *flock.position[:, :2].T, *flock.heading[:, :2].T, color=layer_colours(flock), zorder=5,
        pivot="mid", units="width", width=0.009, scale=30, headwidth=4.6, headlength=5.6,
        headaxislength=4.6,
    )  # fmt: skip
    show_box(axes, middle - HALF, middle + HALF)


def layer_colours(flock: Any) -> list[str]:
    """A colour for each agent by its layer; grey without a link to the information UAV."""
    n = len(flock.ids)
    return [
        LOST if layer > n else INFORMED if layer == 1 else COLOURS[min(layer - 2, len(COLOURS) - 1)]
        for layer in flock.layers()
    ]


def signs(figure: Any) -> None:
    """Say what is what."""
    from matplotlib.lines import Line2D

    names = ["information UAV", "layer 2", "layer 3", "layer 4", "layer 5 and on", "cut off"]
    handles = [
        Line2D([], [], color=colour, marker=">", linestyle="none", label=name)
        for name, colour in zip(names, (INFORMED, *COLOURS, LOST), strict=True)
    ]
    figure.legend(handles=handles, loc="outside lower left", ncols=6, fontsize=9)
