"""A beta agent beside a wall and beside a disc: where it is, and how it moves."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.kinds.projections import Projection, ProjectionSettings, obstacle_of
from app.studies.pictures.boxes import explain
from app.studies.pictures.missions.mission_scene import draw_obstacles
from app.studies.pictures.schemes.scheme_marks import INK, arrow, bare, sign, stroke, word
from app.studies.trial import flock_of

ALPHA, BETA, MOVES, PRINTED, REACH = "#2166ac", "#c0392b", "#1f9d63", "#b07d12", "#9aa3ad"
SCALE = 1.6
"""Length of a velocity of 1 m/s, m."""
AWAY = 0.45, 0.75
"""Distance of the agent that is drawn, of r."""


def draw_projections(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw an occasion of the wall and one of the disc, of the rows' flocks of that seed."""
    figure.set_size_inches(12.4, 6.4)
    panels = figure.subplots(1, 2)
    letters = {"wall": ("a", "a wall, (5)"), "disc": ("b", "a disc, (6)")}
    settings = experiment.settings
    assert isinstance(settings, ProjectionSettings)
    for axes, (beside, (letter, words)) in zip(panels, letters.items(), strict=True):
        mine = settings.model_copy(update={"beside": beside})
        flock = flock_of(experiment.cases[0], seed)
        found = mine.projected(flock)
        one = max(found, key=lambda each: suits(each, flock, mine))
        draw_one(axes, flock, mine, one)
        axes.set_title(f"({letter}) {words}", loc="left")
    explain(
        figure,
        [
            sign(ALPHA, "agent, q, and its velocity p"),
            sign(BETA, "beta agent, q̂, where the rule has it"),
            stroke(MOVES, "its velocity p̂, from the rule's force"),
            stroke(PRINTED, "as (6) prints it, mu P p", (0, (4, 2))),
            stroke(REACH, "sensing radius r"),
        ],
        f"an agent of {experiment.cases[0].label} put down at random beside the obstacle, seed "
        f"{seed}; the paper's scene has no numbers",
    )


def suits(one: Projection, flock: Any, settings: ProjectionSettings) -> float:
    """How well an occasion can be drawn: not too near, and its velocity slants to the surface."""
    r = flock.parameters.r
    x0, _, x1, _ = obstacle_of(flock.world, settings.beside).footprint().bounds
    central = abs(one.q[0] - 0.5 * (x0 + x1)) < (2.5 if settings.beside == "wall" else x1 - x0)
    away = one.q - one.q_hat
    distance = float(np.linalg.norm(away))
    share = float(np.linalg.norm(one.p_hat) / np.linalg.norm(one.p))
    heads = float(away @ one.p) < 0.0
    fits = AWAY[0] * r < distance < AWAY[1] * r and 0.5 < share < 0.85 and heads and central
    return float(fits) * (1.0 + np.linalg.norm(one.p))


def draw_one(axes: Any, flock: Any, settings: ProjectionSettings, one: Projection) -> None:
    """Draw an agent with its beta agent."""
    from matplotlib.patches import Circle

    r = flock.parameters.r
    draw_obstacles(axes, flock.world)
    axes.add_patch(
        Circle((one.q[0], one.q[1]), r, fill=False, edgecolor=REACH, linewidth=1.2, zorder=3)
    )
    axes.plot(*np.array([one.q, one.q_hat]).T, color=INK, linewidth=1.0, linestyle=(0, (3, 3)))
    printed = settings.equations(flock, one).p_hat
    arrow(axes, one.q, SCALE * one.p, ALPHA)
    arrow(axes, one.q_hat, SCALE * one.p_hat, MOVES, 2.4)
    if settings.beside == "disc":
        y = np.array(obstacle_of(flock.world, "disc").centre)
        axes.plot(*np.array([one.q_hat, y]).T, color=INK, linewidth=0.9, linestyle=(0, (1, 2)),
                  zorder=4)  # fmt: skip
        axes.plot(*y, "+", color=INK, markersize=10, zorder=6)
        word(axes, y, "$y_k$", shift=(14, -10))
        arrow(axes, one.q_hat, SCALE * printed, PRINTED, 1.6, 9.0, (0, (4, 2)))
    axes.plot(*one.q, "o", color=ALPHA, markersize=11, zorder=9, markeredgecolor="white")
    axes.plot(*one.q_hat, "o", color=BETA, markersize=10, zorder=9, markeredgecolor="white")
    tip = one.q + SCALE * one.p
    word(axes, tip, "$p_i$", ALPHA, tuple(12.0 * np.sign(one.p)))
    word(axes, one.q_hat + SCALE * one.p_hat, "$\\hat p_{i,k}$", MOVES,
         tuple(14.0 * np.sign(one.p_hat)))  # fmt: skip
    out = (one.q - one.q_hat) / np.linalg.norm(one.q - one.q_hat)
    word(axes, one.q, "$q_i$", ALPHA, tuple(16.0 * out))
    side = np.array([-out[1], out[0]])
    side *= -np.sign(side @ one.p_hat)
    word(axes, one.q_hat, "$\\hat q_{i,k}$", BETA, tuple(20.0 * side + 8.0 * out))
    shift, half = (4.0, 1.5 * r) if settings.beside == "disc" else (1.0, 1.25 * r)
    bare(axes, one.q - shift * out, half)
