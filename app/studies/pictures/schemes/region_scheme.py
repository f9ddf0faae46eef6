"""The regions about an agent, and the force between two agents over their distance."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.kinds.regions import RegionSettings, warning_distance
from app.studies.pictures.boxes import explain
from app.studies.pictures.schemes.scheme_marks import INK, arrow, bare, sign, stroke, word
from app.studies.trial import flock_of

FILLS = ("#f6d5cf", "#fbe9c6", "#dbe8f6")
COLOURS = ("#c0392b", "#b07d12", "#2166ac")
NAMES = ("separation", "early warning", "attraction")
LONGEST, SHORTEST = 1.5, 0.5
"""Arrow of the strongest and of the weakest force, m."""
OTHERS = ((0.55, 65.0), (0.8, -40.0), (0.6, 170.0), (0.25, 100.0), (0.75, -110.0), (0.35, 15.0),
          (0.7, 128.0))  # fmt: skip
"""Other agents: share of the way through a region, and direction, deg; region by region."""
WEAKEST = 0.01
"""Force below which the axis is linear, m/s^2."""


def draw_regions(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the regions of the first row's agents left, the force over the distance right."""
    settings = experiment.settings
    assert isinstance(settings, RegionSettings)
    flock: Any = flock_of(experiment.cases[0], seed)
    edges = [0.0, warning_distance(flock), flock.parameters.d, flock.parameters.r]
    figure.set_size_inches(12.4, 5.9)
    left, right = figure.subplots(1, 2, width_ratios=[1.0, 1.15])
    draw_rings(left, flock, settings, edges)
    draw_force(right, flock, settings, edges)
    signs = [sign(colour, name, "s") for colour, name in zip(COLOURS, NAMES, strict=True)]
    explain(
        figure, [*signs, stroke(INK, "what the rule makes of another agent")],
        f"two agents of {experiment.cases[0].label} put down at distances from each other; values "
        "of table 3; the paper's figure has no numbers",
    )  # fmt: skip


def draw_rings(axes: Any, flock: Any, settings: RegionSettings, edges: list[float]) -> None:
    """Draw the regions about an agent, and what others in them do to it."""
    from matplotlib.patches import Circle

    for outer, fill, colour in zip(edges[:0:-1], FILLS[::-1], COLOURS[::-1], strict=True):
        axes.add_patch(
            Circle((0.0, 0.0), outer, facecolor=fill, edgecolor=colour, linewidth=1.4, zorder=1)
        )
    for k, (share, angle) in enumerate(OTHERS):
        region = k % 3
        away = edges[region] + share * (edges[region + 1] - edges[region])
        out = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
        force = float(settings.pushes(flock, np.array([away])).force[0])
        strong = np.clip(np.log10(abs(force) / WEAKEST) / 7.0, 0.0, 1.0)
        length = SHORTEST + (LONGEST - SHORTEST) * strong
        # On the other agent: away from the middle where they repel each other.
        arrow(axes, away * out, -np.sign(force) * length * out, COLOURS[region], 2.0)
        axes.plot(*(away * out), "o", color=COLOURS[region], markersize=8, zorder=9,
                  markeredgecolor="white")  # fmt: skip
    axes.plot(0.0, 0.0, "o", color=INK, markersize=12, zorder=9, markeredgecolor="white")
    for name, edge, turn, colour in zip(
        ("$d_e$", "$d$", "$r$"), edges[1:], (-90.0, -78.0, -69.0), COLOURS, strict=True
    ):
        at = edge * np.array([np.cos(np.radians(turn)), np.sin(np.radians(turn))])
        word(axes, at, f"{name} = {edge:g} m", colour)
    bare(axes, np.zeros(2), 1.06 * edges[-1])
    axes.set_title("(a) regions within the sensing radius of an agent", loc="left")


def draw_force(axes: Any, flock: Any, settings: RegionSettings, edges: list[float]) -> None:
    """Draw the force over the distance, with and without the weight of (12)."""
    for k, fill in enumerate(FILLS):
        axes.axvspan(edges[k], edges[k + 1], color=fill, alpha=0.6, zorder=0, linewidth=0.0)
        middle = 0.5 * (edges[k] + edges[k + 1])
        tau = (flock.parameters.tau_s, flock.parameters.tau_e, flock.parameters.tau_a)[k]
        axes.text(
            middle, 0.985, f"{NAMES[k]}\n$\\tau$ = {tau:g}", transform=axes.get_xaxis_transform(),
            ha="center", va="top", color=COLOURS[k], fontsize=9.5,
        )  # fmt: skip
    for k in range(3):
        distance = np.linspace(edges[k] + 1e-3, edges[k + 1] - 1e-3, 150)
        found = settings.pushes(flock, distance)
        axes.plot(distance, found.force, color=INK, linewidth=2.2)
        axes.plot(distance, found.bare, color=INK, linewidth=1.1, linestyle=(0, (3, 2)))
    axes.axhline(0.0, color=INK, linewidth=0.8)
    axes.set_yscale("symlog", linthresh=WEAKEST)
    axes.set_ylim(-1e6, 1e3)
    axes.set_yticks([-1e5, -1e3, -10.0, -0.1, 0.0, 0.1, 10.0])
    axes.minorticks_off()
    axes.set_xlim(0.0, edges[-1])
    axes.set_xlabel("distance / m")
    axes.set_ylabel("force towards the other / m/s², below 0 they repel")
    axes.set_title("(b) the force with the weight (12); dashed: without", loc="left")
