"""What a UAV does about obstacles: the angles of one occasion, and many occasions round shapes."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.kinds.tangents import Probes, TangentSettings
from app.studies.pictures.boxes import explain
from app.studies.pictures.missions.mission_scene import draw_obstacles, show_box
from app.studies.trial import flock_of

BEFORE, AFTER, KEEPS, NEAREST, INK = "#7a828c", "#2166ac", "#e08214", "#1f9d63", "#3c434b"
MARGIN = 0.75
"""Shown around an obstacle, length."""
TURNS = 25.0, 65.0
"""Turn of the occasion that is drawn large, deg."""
ARROW = 0.22
"""Length of an arrow round the shapes, length."""


def draw_tangents(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the occasions of the first row and that seed."""
    settings = experiment.settings
    assert isinstance(settings, TangentSettings)
    flock = flock_of(experiment.cases[0], seed)
    found = settings.probed(flock)
    figure.set_size_inches(12.8, 5.4)
    panels = figure.subplots(1, 3, width_ratios=[1.0, 1.0, 1.0])
    discs = [one for one in flock.world.obstacles if one.shape == "disc"]
    pointed = [one for one in flock.world.obstacles if one.shape == "polygon"]
    draw_occasion(panels[0], flock, found, discs[0])
    for axes, one, words in (
        (panels[1], discs[0], "(b) round a disc: along the tangent"),
        (panels[2], pointed[-1], "(c) at corners without a tangent: as before"),
    ):
        draw_obstacles(axes, flock.world)
        draw_all(axes, found)
        x0, y0, x1, y1 = one.footprint().bounds
        middle = 0.5 * np.array([x0 + x1, y0 + y1])
        half = 0.5 * max(x1 - x0, y1 - y0) + MARGIN
        show_box(axes, middle - half, middle + half)
        bare(axes)
        axes.set_title(words, loc="left")
    explain(
        figure, signs(), f"a UAV put down {settings.looks} times near the obstacles, seed {seed}"
    )


def chosen(found: Probes, shape: Any, reach: float) -> int:
    """The occasion that is drawn large: at this obstacle, a clear turn, not too near."""
    at = np.linalg.norm(found.nearest - np.array(shape.centre), axis=1)
    good = (
        (at < shape.radius + 1e-6)
        & (found.turned > TURNS[0])
        & (found.turned < TURNS[1])
        & (found.away < 0.8 * reach)
    )
    return int(np.argmax(np.where(good, found.away, -1.0)))


def draw_occasion(axes: Any, flock: Any, found: Probes, shape: Any) -> None:
    """Draw one occasion with the names of the paper's (20) to (22)."""
    from matplotlib.patches import Circle, Wedge

    p = flock.parameters
    k = chosen(found, shape, p.r_avoid)
    place, point = found.position[k], found.nearest[k]
    draw_obstacles(axes, flock.world)
    way = np.degrees(np.arctan2(*found.before[k][::-1]))
    half = np.degrees(p.theta_obstruct)
    axes.add_patch(
        Wedge(
            place,
            p.r_avoid,
            way - half,
            way + half,
            facecolor="#fdf0dd",
            edgecolor="none",
            zorder=1,
        )
    )
    axes.add_patch(Circle(place, p.r_avoid, fill=False, edgecolor=KEEPS, linewidth=1.1, zorder=2.5))
    axes.plot(
        *np.array([place, point]).T, color=NEAREST, linewidth=1.2, linestyle=(0, (3, 2)), zorder=4
    )
    along = found.after[k]
    axes.plot(
        *np.array([point - 0.75 * along, point + 0.75 * along]).T,
        color=INK,
        linewidth=1.0,
        zorder=3,
    )
    axes.plot(*point, "o", color=NEAREST, markersize=9, zorder=6, markeredgecolor="white")
    axes.plot(*place, "o", color=INK, markersize=8, zorder=6, markeredgecolor="white")
    for heading, colour, words in (
        (found.before[k], BEFORE, "$\\theta_i$, wanted"),
        (found.after[k], AFTER, "$\\theta_{obs}$, taken"),
    ):
        tip = place + 0.42 * heading
        axes.annotate(
            "", tip, place, zorder=7,
            arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 2.2, "shrinkA": 0,
                        "mutation_scale": 15, "shrinkB": 0},
        )  # fmt: skip
        put_word(axes, place + 0.47 * heading, heading, words, colour)
    edge = place - p.r_avoid * (point - place) / found.away[k]
    put_word(axes, edge, edge - place, f"$r_{{avoid}}$ = {p.r_avoid:g}", KEEPS)
    show_box(axes, place - 1.05, place + 1.05)
    bare(axes)
    axes.set_title(
        f"(a) the nearest point is {found.ahead[k]:.0f}° ahead: it turns by {found.turned[k]:.0f}°",
        loc="left",
    )


def bare(axes: Any) -> None:
    """Take ticks and spines away."""
    axes.set(xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_visible(False)


def put_word(axes: Any, at: np.ndarray, way: np.ndarray, words: str, colour: str) -> None:
    """Write words beyond a place, on the side that a way (2,) leads to."""
    axes.annotate(
        words, at, (6.0 * np.sign(way[0]), 8.0 * way[1] / max(1e-9, float(np.linalg.norm(way)))),
        textcoords="offset points", ha="left" if way[0] > 0.0 else "right", va="center",
        color=colour, fontsize=10, zorder=8,
    )  # fmt: skip


def draw_all(axes: Any, found: Probes) -> None:
    """Draw all occasions: the heading before in grey, the one after in colour."""
    turned = found.turned > 1e-6
    style: dict[str, Any] = {
        "angles": "xy", "scale_units": "xy", "scale": 1.0 / ARROW, "width": 0.006, "clip_on": True,
    }  # fmt: skip
    axes.quiver(*found.position.T, *found.before.T, color=BEFORE, alpha=0.6, zorder=4, **style)
    for rows, colour in ((turned, AFTER), (~turned & found.corner, KEEPS)):
        axes.quiver(*found.position[rows].T, *found.after[rows].T, color=colour, zorder=5, **style)


def signs() -> list[Any]:
    """What is what."""
    from matplotlib.lines import Line2D

    arrow: dict[str, Any] = {"marker": ">", "linestyle": "none", "markersize": 8}
    return [
        Line2D([], [], color=BEFORE, label="heading before", **arrow),
        Line2D([], [], color=AFTER, label="after, along the tangent", **arrow),
        Line2D([], [], color=KEEPS, label="at a corner: kept", **arrow),
        Line2D([], [], color=NEAREST, marker="o", linestyle="none", label="nearest obstacle point"),
    ]
