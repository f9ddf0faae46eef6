"""Draws four moments of a run: the pictures of the pages that `make.py` writes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import hsv_to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from rule_scenes import Scene, flock_of, scene_of

from agents import Flock
from agents.models.model import Model
from agents.observables.catalogue import is_in_corridor
from app.viewer.pictures.plane import swimming_outlines
from app.viewer.scene.draw.agent_shapes import SWIMMER
from app.worlds.world_picture import (
    FLOOR,
    GOAL,
    INK,
    LOOK,
    PALE,
    PATH,
    SOLID,
    SOLID_EDGE,
    edges,
    fill,
    floor,
    footprint,
)

DART = np.array([[0.62, 0.0], [-0.42, 0.40], [-0.24, 0.0], [-0.42, -0.40]])
"""Outline of an agent of length 1 that heads along +x."""
INFORMED = "#d62728"
LOST = "#9aa3ad"
NEAR, FAR = 0.12, 0.80
"""Hues of the second layer, and of the last one that is told apart."""
LAYERS = 9
DOTS = 120
PIECES = 8
"""Pieces of a tail, each fainter than the one after it."""


def by_heading(flock: Flock) -> np.ndarray:
    """A colour for each agent from its heading, (N, 3); grey for crashed agents."""
    hue = np.arctan2(flock.heading[:, 1], flock.heading[:, 0]) / (2 * np.pi) % 1.0
    colour = hsv_to_rgb(np.column_stack([hue, np.full_like(hue, 0.8), np.full_like(hue, 0.75)]))
    colour[~flock.active] = matplotlib.colors.to_rgb(LOST)
    return colour


def by_layer(flock: Flock) -> np.ndarray:
    """A colour for each agent from its hops to the information agent; pale without a link."""
    layer = flock.layers()
    share = np.clip((layer - 2.0) / (LAYERS - 2.0), 0.0, 1.0)
    hue = NEAR + (FAR - NEAR) * share
    colour = hsv_to_rgb(np.column_stack([hue, np.full_like(hue, 0.85), np.full_like(hue, 0.78)]))
    colour[layer > len(layer)] = matplotlib.colors.to_rgb(LOST)
    return colour


def draw_agents(axes: Any, flock: Flock, colour: np.ndarray, length: float, form: str = "") -> None:
    """Draw agents as darts or fish of a length in the world's units, as `form` or their rule says;
    information agents larger and red."""
    form = form or flock.model.rule.form
    for informed, bigger in ((False, 1.0), (True, 1.5)):
        rows = np.flatnonzero(flock.informed == informed)
        if not len(rows):
            continue
        ux, uy = flock.heading[rows, :2].T
        turn = np.array([[ux, -uy], [uy, ux]]).transpose(2, 0, 1)
        shapes = DART[None].repeat(len(rows), axis=0)
        if form == "fish" and flock.model.body.vehicle is None:
            shapes = SWIMMER.scale * swimming_outlines(flock.ids[rows], flock.tick)
        placed = flock.position[rows, None, :2] + bigger * length * np.einsum(
            "nij,nkj->nki", turn, shapes
        )
        axes.add_collection(
            PolyCollection(
                placed, facecolors=INFORMED if informed else colour[rows], edgecolors="white",
                linewidths=0.35 * bigger, zorder=8 + informed, clip_on=True,
            )
        )  # fmt: skip


def draw_tails(axes: Any, trace: np.ndarray, colour: np.ndarray, width: float) -> None:
    """Draw where agents have just been, (T, N, dim), fading."""
    for k in range(PIECES):
        piece = trace[k * len(trace) // PIECES : (k + 1) * len(trace) // PIECES + 1]
        if len(piece) > 1:
            axes.add_collection(
                LineCollection(
                    list(piece.transpose(1, 0, 2)[:, :, :2]), colors=colour, linewidths=width,
                    alpha=0.06 + 0.5 * (k + 1) / PIECES, capstyle="butt", zorder=6,
                )
            )  # fmt: skip


def draw_world(axes: Any, flock: Flock) -> None:
    """Draw what is solid, and the path and the goal of those who know them."""
    world, mission = flock.world, flock.world.mission
    floor(axes, world)
    fill(axes, footprint(world), SOLID, SOLID_EDGE)
    edges(axes, world)
    if mission is None:
        return
    if mission.path is not None and flock.informed.any():
        way = np.array(mission.path.waypoints)[:, :2]
        axes.plot(*way.T, color=PATH, linewidth=1.0, linestyle=(0, (6, 3)), zorder=4)
        axes.plot(*way.T, "o", color=PATH, markersize=5, zorder=4)
    if mission.goal is not None and seeks(flock):
        route = np.array(mission.goal.route)[:, :2]
        if len(route) > 1:
            line = np.vstack([route, route[:1]]) if mission.goal.closed else route
            axes.plot(*line.T, color=GOAL, linewidth=0.9, linestyle=(0, (1, 2)), zorder=4)
        axes.plot(*flock.goal_at([flock.tick])[0, :2], "*", color=GOAL, markersize=13,
                  markeredgecolor="white", markeredgewidth=0.7, zorder=10)  # fmt: skip


def seeks(flock: Flock) -> bool:
    """Whether the agents know where the goal is."""
    return bool({"gamma", "seek"} & set(flock.model.rule.forces))


def on_mission(flock: Flock) -> bool:
    """Whether an information agent has a path to lead the others along."""
    return flock.world.mission is not None and bool(flock.informed.any())


def moment(flock: Flock, tick: int, tail: int) -> np.ndarray:
    """Run to a tick; the positions of the last `tail` ticks, (T, N, dim)."""
    flock.run(max(0, tick - tail - flock.tick))
    return np.concatenate([flock.position[None].copy(), flock.trace(tick - flock.tick)])


def when(flock: Flock) -> str:
    """The time, in the model's unit."""
    unit = flock.model.body.unit
    return f"tick {flock.tick}" if unit == "ticks" else f"{flock.elapsed:g} {unit}"


def how(flock: Flock) -> str:
    """How the flock does at what it is there for."""
    if on_mission(flock):
        return f"{flock.observe('following'):.0%} linked"
    if seeks(flock) and flock.world.mission.goal.speed == 0.0:
        return f"{flock.observe('goal-distance'):.0f} m to the goal"
    if is_in_corridor(flock):
        return f"lane order {flock.observe('lane-order'):.2f}"
    return f"polarisation {flock.observe('polarisation'):.2f}"


def frame(axes: Any, low: Any, high: Any, title: str) -> None:
    """Show a part of the plane, without rulers."""
    axes.set_facecolor(FLOOR)
    axes.spines[:].set_visible(False)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xticks=[], yticks=[])
    axes.set_title(title, loc="left", fontsize=10, color=INK)


def panels(figure: Figure, flock: Flock, scene: Scene) -> None:
    """Four panels of the same part of the world."""
    low, high = scene.view or (flock.world.low, np.add(flock.world.low, flock.world.size))
    room = 0.015 * np.max(np.subtract(high, low))
    low, high = np.subtract(low, room), np.add(high, room)
    width, height = np.subtract(high, low)[:2]
    rows = 1 if width < 1.3 * height else 2
    across = 13.0 / (len(scene.ticks) // rows)
    figure.set_size_inches(13.0, rows * (across * height / width + 0.3))
    grid = figure.subplots(rows, len(scene.ticks) // rows).ravel()
    for axes, tick in zip(grid, scene.ticks, strict=True):
        trace = moment(flock, tick, scene.tail)
        colour = by_layer(flock) if on_mission(flock) else by_heading(flock)
        draw_world(axes, flock)
        draw_tails(axes, trace, colour, 0.9)
        draw_agents(axes, flock, colour, scene.length)
        frame(axes, low, high, f"{when(flock)}   {how(flock)}")


def journey(figure: Figure, flock: Flock, scene: Scene) -> None:
    """The whole way on a map, and below it the flock from close at four moments of it."""
    low, high = np.array(scene.view)
    width, height = high - low
    wide, tall = scene.window
    figure.set_size_inches(13.0, 13.0 * height / width + 13.0 / 4 * tall / wide + 0.5)
    grid = figure.add_gridspec(2, 4, height_ratios=(height / width, tall / wide / 4))
    whole = figure.add_subplot(grid[0, :])
    draw_world(whole, flock)
    since = flock.position[None].copy()
    for k, tick in enumerate(scene.ticks):
        part = np.concatenate([since, flock.trace(tick - flock.tick)])
        since = part[-1:]
        colour = by_layer(flock)
        whole.add_collection(
            LineCollection(list(part.transpose(1, 0, 2)), colors=[*colour], linewidths=0.35,
                           alpha=0.4, zorder=3)
        )  # fmt: skip
        draw_agents(whole, flock, colour, scene.length)
        axes = figure.add_subplot(grid[1, k])
        draw_world(axes, flock)
        draw_tails(axes, part[-scene.tail :], colour, 1.0)
        draw_agents(axes, flock, colour, scene.length)
        linked = flock.position[flock.layers() <= len(flock.ids)]
        corner = linked.mean(axis=0) - np.array(scene.window) / 2
        frame(axes, corner, corner + scene.window, f"{when(flock)}   {how(flock)}")
        box = Rectangle(tuple(corner), wide, tall, fill=False, edgecolor=PALE, linewidth=0.8)
        whole.add_patch(box)
        whole.annotate(when(flock), (corner[0], corner[1] + tall), xytext=(2, 2), fontsize=8,
                       color=INK, textcoords="offset points", zorder=11)  # fmt: skip
    frame(whole, low, high, "")


def draw(model: Model, path: Path) -> None:
    """Four moments of a run into a PNG."""
    flock, scene = flock_of(model), scene_of(model)
    with matplotlib.rc_context(LOOK):  # type: ignore[arg-type]
        figure = Figure(layout="constrained")
        (journey if scene.window else panels)(figure, flock, scene)
        figure.savefig(path, dpi=DOTS, bbox_inches="tight", pad_inches=0.05)
