"""A flock in the plane, seen from above: the world stays, the agents are moved."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from agents.models.model import Model
from agents.observables.catalogue import OBSERVABLES
from agents.observables.observable import Range
from agents.snapshot import Snapshot
from app.viewer.pictures import key
from app.viewer.pictures.shot import Shot
from app.viewer.scene.draw.agent_meshes import fish_outlines
from app.viewer.scene.draw.agent_shapes import SWIMMER
from app.viewer.scene.draw.density import (
    PlaneRegion,
    count_within,
    density_picture,
    flock_region,
)
from app.viewer.scene.draw.line_segments import nearest_image
from app.viewer.scene.marks.agents import dart_rows
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.drawing_style import FISH
from app.worlds.world_picture import (
    FLOOR,
    GOAL,
    INK,
    PALE,
    START,
    draw_gates,
    draw_path,
    draw_solid,
    view,
)
from worlds.input_error import InputError, unknown
from worlds.mission import Mission
from worlds.world import World

DART = np.array([[0.60, 0.0], [-0.40, 0.36], [-0.22, 0.0], [-0.40, -0.36]])
"""Outline of an agent of length 1 that heads along +x, as that of the page."""
HULL = np.array([[-0.5, -0.46], [-0.5, 0.46], [0.26, 0.46], [0.5, 0.32], [0.5, -0.32],
                 [0.26, -0.46]])  # fmt: skip
"""Of a car of length and width 1."""
CABIN = np.array([[-0.30, -0.32], [-0.30, 0.32], [0.12, 0.32], [0.22, 0.24], [0.22, -0.24],
                  [0.12, -0.32]])  # fmt: skip
BEAT, SWING, GOLDEN = 12.0, 0.42, 0.6180339887498949
"""Of fish in pictures and films: ticks of a beat of the tail, and how far it swings, rad. No two
beat together."""
SEEN = 8.0
"""Points of an agent's length from which on it has an outline."""
AROUND = 0.16
"""Half of what is shown around a followed agent, as a share of the world's longest side."""


class Plane:
    """The scene on its axes. `signs` explain what of the world is drawn."""

    def __init__(self, axes: Any, world: World, follow: int | None = None):
        from matplotlib.collections import PolyCollection

        self.axes, self.world, self.follow = axes, world, follow
        self.signs = self.draw_world()
        self.bodies: Any = PolyCollection([], zorder=8, closed=True)
        self.cabins: Any = PolyCollection([], zorder=9, closed=True, linewidths=0)
        (self.goal,) = axes.plot([], [], "*", color=GOAL, markersize=14, markeredgecolor="white",
                                 markeredgewidth=0.8, zorder=10)  # fmt: skip
        self.ring = ring(axes)
        for one in (self.bodies, self.cabins):
            axes.add_collection(one, autolim=False)
        self.density: Any = None
        """The image of a flock of which no agent can be told apart."""
        self.moving: list[Any] = [self.bodies, self.cabins, self.ring, self.goal]
        """What changes from tick to tick; with a camera that follows, all does."""
        low, high = self.frame()
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xticks=[],
                 yticks=[])  # fmt: skip
        axes.spines[:].set_visible(False)
        axes.set_facecolor(FLOOR if follow is not None and world.wraps.any() else "none")

    def frame(self) -> tuple[np.ndarray, np.ndarray]:
        """The corners of what is shown."""
        return view(self.world)

    def draw_world(self) -> list[Any]:
        """Floor, edges, obstacles, path and the goal's route; the signs that explain them."""
        from matplotlib.lines import Line2D

        axes, world = self.axes, self.world
        signs = draw_solid(axes, world)
        mission = world.mission or Mission()
        if mission.has_gates:
            signs += draw_gates(axes, world, [0, 1])
        if mission.path:
            signs.append(draw_path(axes, mission.path, [0, 1]))
        if mission.goal:
            route = np.array(mission.goal.route)[:, :2]
            if len(route) > 1:
                line = np.vstack([route, route[:1]]) if mission.goal.closed else route
                axes.plot(*line.T, color=GOAL, linewidth=1.2, linestyle=(0, (1, 1.5)), zorder=5)
            signs.append(Line2D([], [], color=GOAL, marker="*", markersize=11, linestyle="none",
                                label="goal"))  # fmt: skip
        return signs

    def begin(self, shot: Shot) -> None:
        """Draw where the mission starts, which depends on how many there are."""
        from matplotlib.patches import Patch, Rectangle

        if shot.made.shows_density:
            self.signs.append(key.faint_sign())
        if shot.made.frame.room is None:
            return
        low, high = shot.made.frame.room
        style: dict[str, Any] = {"edgecolor": START, "linestyle": (0, (3, 2)), "linewidth": 1.2}
        self.axes.add_patch(
            Rectangle(tuple(low[:2]), *(high - low)[:2], fill=False, zorder=3, **style)
        )
        self.signs.append(Patch(fill=False, label="start", **style))

    def show(self, shot: Shot) -> None:
        """Move the agents to where they are."""
        position, heading = shot.position, shot.now.heading
        if self.follow is not None:
            row = shot.row_of(self.follow)
            position = self.centre_on(shot, row)
            self.ring.set_data(*position[row, :, None])
        order = np.argsort(shot.made.size, kind="stable")
        order = order[shot.made.is_there[order]]
        if shot.made.shows_density:
            self.draw_density(shot, position)
            order = np.asarray(dart_rows(shot.made))
        colour = shot.made.colour[order]
        cars = shot.made.frame.cars
        shapes, stretch = [DART], np.ones(2)
        if shot.made.form == FISH:
            shapes = [SWIMMER.scale * swimming_outlines(shot.now.ids[order], shot.now.tick)]
        if cars is not None:
            shapes, stretch = [HULL, CABIN], np.array([1.0, cars.width / cars.length])
        placed = [
            place_shapes(one * stretch, position[order], heading[order], shot.length[order])
            for one in shapes
        ]
        large = self.points_of(float(np.median(shot.length))) > SEEN
        self.bodies.set_verts(placed[0])
        outlined = shot.made.frame.outlined
        if outlined is not None and outlined.any():
            self.colour_hollow(colour, outlined[order], large)
        else:
            self.bodies.set_facecolor(colour)
            self.bodies.set_edgecolor("white" if large else "none")
            self.bodies.set_linewidth(0.6 if large else 0.0)
        if cars is not None:
            self.cabins.set_verts(placed[1])
            self.cabins.set_facecolor(palette.GLASS)
        goal = shot.made.frame.progress.goal
        self.goal.set_data(*(([], []) if goal is None else goal[:2, None]))

    def colour_hollow(self, colour: np.ndarray, hollow: np.ndarray, large: bool) -> None:
        """Give agents their colours (N, 3), to those that are `hollow` (N,) in outline alone."""
        face = np.column_stack([colour, ~hollow])
        edge = np.column_stack([colour, hollow])
        if large:
            edge[~hollow] = 1.0
        self.bodies.set_facecolor(face)
        self.bodies.set_edgecolor(edge)
        self.bodies.set_linewidth(np.where(hollow, 1.2, 0.6 if large else 0.0))

    def draw_density(self, shot: Shot, position: np.ndarray) -> None:
        """Draw where agents at `position` (N, 2) are dense, and where they head."""
        (left, right), (lower, upper) = self.axes.get_xlim(), self.axes.get_ylim()
        region = PlaneRegion((left, lower), (right, upper))
        if self.follow is None:
            region = region.intersection(flock_region(shot.made.frame)) or region
        there = ~shot.made.frame.is_down
        position, heading = position[there], shot.now.heading[there]
        count = count_within(position, *region.low, *region.high)
        made = density_picture(position, heading, region, count)
        if self.density is None:
            limits = self.axes.get_xlim(), self.axes.get_ylim()
            self.density = self.axes.imshow(
                made.pixels, origin="lower", interpolation="bilinear", zorder=1.5
            )
            self.axes.set(xlim=limits[0], ylim=limits[1])
            self.moving.append(self.density)
        self.density.set_data(made.pixels)
        self.density.set_extent((region.low[0], region.high[0], region.low[1], region.high[1]))
        self.axes.set(xlim=(left, right), ylim=(lower, upper))

    def rule(self, figure: Any, shot: Shot, y: float) -> None:
        """The scale bar, below the left edge of the world."""
        key.draw_ruler(figure, self.axes, shot, y)

    def points_of(self, length: float) -> float:
        """How many points a length is on paper."""
        (low, _), (high, _) = self.axes.transData.transform([(0.0, 0.0), (length, 0.0)])
        return 72.0 * abs(high - low) / self.axes.figure.dpi

    def centre_on(self, shot: Shot, row: int) -> np.ndarray:
        """Look at an agent; the positions of the others as it has them, nearest images."""
        centre = shot.position[row]
        period = np.full(3, np.inf)
        period[:2][self.world.wraps] = np.array(self.world.size)[self.world.wraps]
        apart = np.zeros((len(shot.position), 3))
        apart[:, :2] = shot.position - centre
        low, high = self.frame()
        shape = (high - low) / max(high - low)
        half = AROUND * max(self.world.size) * shape / np.sqrt(min(shape))
        self.axes.set_xlim(centre[0] - half[0], centre[0] + half[0])
        self.axes.set_ylim(centre[1] - half[1], centre[1] + half[1])
        return centre + nearest_image(apart, period)[:, :2]


def ring(axes: Any) -> Any:
    """What is drawn around a followed agent."""
    (made,) = axes.plot([], [], "o", markersize=30, markerfacecolor="none",
                        markeredgecolor=palette.css(palette.SELECTED), markeredgewidth=1.2,
                        zorder=9)  # fmt: skip
    return made


def place_shapes(
    shapes: np.ndarray, position: np.ndarray, heading: np.ndarray, length: np.ndarray
) -> np.ndarray:
    """A shape (K, 2), or one each (N, K, 2), at each place, turned along each heading, of each
    length: (N, K, 2)."""
    ux, uy = heading[:, 0], heading[:, 1]
    turn = np.stack([np.stack([ux, -uy], -1), np.stack([uy, ux], -1)], 1)
    each = np.broadcast_to(shapes, (len(position), *shapes.shape[-2:]))
    return position[:, None, :] + length[:, None, None] * np.einsum("nij,nkj->nki", turn, each)


def tail_angles(ids: np.ndarray, tick: int) -> np.ndarray:
    """How far fish of these identities (N,) have their tails turned at a tick, (N,), rad."""
    return SWING * np.sin(2.0 * np.pi * (tick / BEAT + ids * GOLDEN))


def swimming_outlines(ids: np.ndarray, tick: int) -> np.ndarray:
    """Outlines (N, K, 2) of fish of these identities (N,) at a tick, along +x."""
    return fish_outlines(tail_angles(ids, tick))


# Curves below a film: observables over its time, drawn as far as it has come.

TALL = 1.55
"""Inches that they take."""
LEFT, RIGHT, BELOW, ABOVE = 0.75, 0.3, 0.5, 0.3
"""Inches around a plot."""
COLOUR = "#2f6fde"


class Plots:
    """Observables from time `first` to time `last`. Raises InputError for what is no curve."""

    def __init__(self, names: Sequence[str], first: float, last: float):
        for name in names:
            if name not in OBSERVABLES:
                raise unknown("observable", name, OBSERVABLES)
            if OBSERVABLES[name].over or OBSERVABLES[name].is_table:
                raise InputError(f"--plot {name} is not one number at each tick")
        self.names, self.ends = list(names), (first, max(last, first + 1e-9))
        self.times: list[float] = []
        self.values: dict[str, list[float]] = {name: [] for name in self.names}
        self.lines: list[Any] = []

    def draw(self, figure: Any, model: Model) -> None:
        """Make the axes along the lower edge of a figure."""
        wide, tall = figure.get_size_inches()
        each = (wide - RIGHT) / len(self.names)
        self.lines = []
        for k, name in enumerate(self.names):
            axes = figure.add_axes(
                ((k * each + LEFT) / wide, BELOW / tall, (each - LEFT) / wide,
                 (TALL - BELOW - ABOVE) / tall)
            )  # fmt: skip
            one = OBSERVABLES[name]
            unit = "" if one.unit == "1" else f" / {model.in_units(one.unit)}"
            axes.set_title(f"{name.replace('-', ' ')}{unit}", loc="left", fontsize=9.5, color=INK)
            axes.set_xlabel(f"time / {model.body.unit}", fontsize=9)
            axes.tick_params(labelsize=8.5, length=3, color=PALE, labelcolor=INK)
            axes.spines[["left", "bottom"]].set(visible=True, color=PALE)
            axes.set_xlim(*self.ends)
            if is_share(name):
                axes.set_ylim(0.0, 1.02)
            (line,) = axes.plot([], [], color=COLOUR, linewidth=1.6)
            self.lines.append(line)
        self.update()

    def look(self, now: Snapshot) -> bool:
        """Measure the flock; whether the axes have changed, and not only the curves."""
        seen = now.measurable()
        self.times.append(now.elapsed)
        for name in self.names:
            self.values[name].append(float(OBSERVABLES[name].measure(seen)))
        return self.update()

    def update(self) -> bool:
        """Bring the curves up to date; whether an axis has had to grow."""
        grown = False
        for name, line in zip(self.names, self.lines, strict=False):
            values = np.array(self.values[name])
            line.set_data(self.times, values)
            known = values[np.isfinite(values)]
            low, high = line.axes.get_ylim()
            outside = len(known) and (known.min() < low or known.max() > high)
            if not is_share(name) and (outside or len(known) == 1):
                room = 0.25 * max(float(np.ptp(known)), 0.05 * abs(known[0]), 1e-9)
                line.axes.set_ylim(known.min() - room, known.max() + room)
                grown = True
        return grown


def is_share(name: str) -> bool:
    """Whether an observable lies between 0 and 1."""
    one = OBSERVABLES[name].range
    return isinstance(one, Range) and one.is_share
