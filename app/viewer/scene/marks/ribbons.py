"""Bands that agents leave behind them: flat on the floor, or rising with time.

A band that rises is the agent's way through space and time, time upwards, as in the figures of
Jacobs and Koessler: its foot is the oldest place shown, its top is now, straight above the agent.
"""

from __future__ import annotations

import math

import numpy as np
from viser import LabelHandle, SceneApi

from app.viewer.scene.draw.attitude import attitude
from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.line_segments import add_lines, jumps, segments
from app.viewer.scene.draw.shapes import Mesh
from app.viewer.scene.marks.trails import (
    FAINTEST,
    INJECTED,
    STRONGEST,
    TrailHistory,
    thin_knots,
    trailed_rows,
)
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.drawing_style import RIBBON, RISING, trail_turns

# How much time the height of what rises with time stands for: an upright axis at a corner.

MOST = 5
"""Marks on the axis, at most."""
STEPS = (1.0, 2.0, 5.0)
"""Time between marks, times a power of ten."""
MARK = 0.022
"""Length of a mark as a multiple of the longest side."""
APART = 0.024
"""How far apart the words beside two marks are on the floor: they stay legible from above."""


class TimeScale:
    """The present is at the top, and what is about to be forgotten at the foot."""

    def __init__(self, scene: SceneApi, name: str) -> None:
        self._drawn: object = None
        self._lines = add_lines(scene, f"{name}/lines", thickness=1.6)
        self._labels: list[LabelHandle] = [
            scene.add_label(
                f"{name}/words/{k}",
                "",
                anchor="center-right",
                font_screen_scale=0.85,
                visible=False,
            )
            for k in range(MOST)
        ]

    def hide(self) -> Changes:
        """Draw nothing."""
        self._drawn = None
        return [(node, "visible", False) for node in (self._lines, *self._labels)]

    def draw(self, picture: Picture, height: float, risen: float) -> Changes:
        """Draw it where the whole length of a trail is `height` high on the display, of which
        there is a share `risen` so far."""
        frame, stage = picture.frame, picture.stage
        key = (stage, height, risen, picture.look.trail_length, frame.dt, frame.unit)
        if key == self._drawn:
            return []
        self._drawn = key
        span = picture.look.trail_length * frame.dt
        ages = age_marks(span)
        ages = ages[ages <= span * risen * (1.0 + 1e-9)]
        up = height * (risen - ages / span)
        corner = stage.half * [-1.0, 1.0, 0.0]
        foot = corner + up[:, None] * [0.0, 0.0, 1.0]
        end = foot - [MARK * stage.side, 0.0, 0.0]
        end[:, 1] -= APART * stage.side * np.arange(len(ages))
        axis = np.array([corner, corner])
        axis[1, 2] = height * risen
        lines = np.concatenate([axis[None], np.stack([foot, end], axis=1)])
        changes = segments(self._lines, lines, palette.node_colour(palette.EDGE))
        for label, age, at in zip(self._labels, ages, end, strict=False):
            changes += [
                (label, "text", age_text(float(age), frame.unit)),
                (label, "position", at),
                (label, "visible", True),
            ]
        return changes + [(label, "visible", False) for label in self._labels[len(ages) :]]


def age_marks(span: float) -> np.ndarray:
    """Ages at round distances from 0 to at most `span`, at most `MOST` of them.

    >>> age_marks(0.6).tolist(), age_marks(20.0).tolist()
    ([0.0, 0.2, 0.4, 0.6], [0.0, 5.0, 10.0, 15.0, 20.0])
    """
    least = span / (MOST - 1)
    power = 10.0 ** math.floor(math.log10(least))
    step = next(step for step in (*(each * power for each in STEPS), 10.0 * power) if step >= least)
    return np.round(step * np.arange(math.floor(span / step * (1.0 + 1e-9)) + 1), 12)


def age_text(age: float, unit: str) -> str:
    """What stands beside a mark.

    >>> age_text(0.0, "s"), age_text(0.2, "s"), age_text(20.0, "ticks")
    ('now', '−0.2 s', '−20 ticks')
    """
    return "now" if age == 0.0 else f"−{age:g} {unit}"


MOST_AGENTS = 75
PIECES = 1200
"""Pieces of all bands together, about."""
KNOTS = (16, 240)
"""Least and most pieces of one band."""
BROAD, BROAD_CAR = 0.30, 0.6
"""Width of a band as a multiple of an agent's length, and of a car's width."""
OVERLAP = 0.15
"""How much longer a piece is than its part of the way, as a share of its width."""
RISE = 0.65
"""Height of a band that is as long as the look wants it, as a multiple of the longest side."""
LAID, LAYER, LAYERS = 0.012, 0.0006, 20
"""Height of the lowest band over a flat floor, how much higher the next one lies, and how many lie
at heights of their own."""
LIGHT = 1.45
"""Light on what is turned up to the sun, as a multiple of its own colour."""


class Ribbons:
    """A band behind each agent, or of very many agents behind some."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._past = TrailHistory()
        self._pieces = scene.add_batched_meshes_simple(
            f"{root}/flock/ribbons/pieces",
            *tile(),
            batched_wxyzs=np.array([[1.0, 0.0, 0.0, 0.0]]),
            batched_positions=np.zeros((1, 3)),
            batched_scales=np.ones((1, 3)),
            batched_colors=np.zeros((1, 3), dtype=np.uint8),
            flat_shading=True,
            side="double",
            lod="off",
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )
        self._plumb = add_lines(scene, f"{root}/flock/ribbons/plumb", 1.0, many_coloured=True)
        self._scale = TimeScale(scene, f"{root}/flock/ribbons/scale")

    def draw(self, picture: Picture) -> Changes:
        """Draw the bands, if the look asks for them."""
        look = picture.look
        is_drawn = look.trails in (RIBBON, RISING) and look.trail_length >= 1
        if not is_drawn and not picture.as_cars:
            self._past.clear()
            return self._hide()
        ids, positions, colour = ribbon_agents(picture)
        knots = int(np.clip(PIECES // max(len(ids), 1), *KNOTS))
        # The past of cars is there as soon as somebody asks for it.
        history_length = trail_turns(picture.frame.dt) if picture.as_cars else 0
        length = look.trail_length if is_drawn else history_length
        self._past.remember(picture.frame, ids, positions, length, knots, history_length)
        if not is_drawn:
            return self._hide()
        way, age = self._way(picture, positions, knots)
        return [
            *self._draw_pieces(picture, way, age, colour),
            *self._draw_plumb(picture, way, colour),
            *self._draw_scale(picture),
        ]

    def _hide(self) -> Changes:
        hidden: Changes = [(node, "visible", False) for node in (self._pieces, self._plumb)]
        return hidden + self._scale.hide()

    def _way(
        self, picture: Picture, positions: np.ndarray, knots: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """The knots and the present, (K, M, 3), at their heights, and the age of each, (K,): 1 for
        one that is about to be forgotten."""
        now, length = picture.frame.tick, picture.look.trail_length
        past_ticks = np.array(self._past.ticks)
        indices = thin_knots(past_ticks, now, length, knots)
        ticks = np.append(past_ticks[indices], now)
        way = np.stack([*(self._past.knots[k] for k in indices), positions])
        if picture.stage.dim == 2:
            way[..., 2] = LAID + LAYER * (np.arange(way.shape[1]) % LAYERS)
        if is_rising(picture):
            up = heights(ticks, self._past.began, now, length)
            way[..., 2] += up[:, None] * present_height(picture)
        return way, np.clip((now - ticks) / length, 0.0, 1.0)

    def _draw_pieces(
        self, picture: Picture, way: np.ndarray, age: np.ndarray, colour: np.ndarray
    ) -> Changes:
        start, end = way[:-1], way[1:]
        step = end - start
        length = np.linalg.norm(step, axis=2)
        is_drawn = np.isfinite(length) & (length > 1e-9) & ~jumps(start, end, picture.stage.period)
        if not is_drawn.any():
            return [(self._pieces, "visible", False)]
        share = STRONGEST + (FAINTEST - STRONGEST) * 0.5 * (age[:-1] + age[1:])
        faded = picture.mix_with_backdrop(np.broadcast_to(colour, step.shape), share[:, None, None])
        broad = breadth(picture)
        size = np.column_stack(
            [
                length[is_drawn] + OVERLAP * broad,
                np.full((is_drawn.sum(), 1), broad),
                np.ones(is_drawn.sum()),
            ]
        )
        return [
            (self._pieces, "batched_positions", (0.5 * (start + end))[is_drawn].astype(np.float32)),
            (self._pieces, "batched_wxyzs", attitude(step[is_drawn] / length[is_drawn][:, None])),
            (self._pieces, "batched_scales", size.astype(np.float32)),
            (self._pieces, "batched_colors", palette.lit_bytes(faded[is_drawn], LIGHT)),
            (self._pieces, "visible", True),
        ]

    def _draw_plumb(self, picture: Picture, way: np.ndarray, colour: np.ndarray) -> Changes:
        """Lines from the tops down to the agents, where bands rise."""
        if not is_rising(picture):
            return [(self._plumb, "visible", False)]
        top = way[-1]
        is_finite = np.isfinite(top).all(axis=1)
        foot = top * np.array([1.0, 1.0, 0.0])
        ends = np.repeat(
            palette.unlit_bytes(picture.mix_with_backdrop(colour, 0.5))[is_finite][:, None],
            2,
            axis=1,
        )
        return segments(self._plumb, np.stack([top, foot], axis=1)[is_finite], ends)

    def _draw_scale(self, picture: Picture) -> Changes:
        """How much time the height stands for, where bands rise."""
        if not is_rising(picture):
            return self._scale.hide()
        now, length = picture.frame.tick, picture.look.trail_length
        (share,) = heights(np.array([now]), self._past.began, now, length)
        return self._scale.draw(picture, present_height(picture), float(share))


def ribbon_agents(picture: Picture) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Identities (M,), places (M, 3) and colours (M, 3) of all that leave a band."""
    frame = picture.frame
    rows = trailed_rows(frame.informed, MOST_AGENTS)
    ids, here, colour = frame.ids[rows], picture.at[rows], picture.colour[rows]
    if not picture.as_cars or frame.progress.goal is None or not picture.look.mission:
        return ids, here, colour
    goal = picture.stage.to_display(frame.progress.goal)
    return (
        np.append(ids, INJECTED),
        np.concatenate([here, goal[None]]),
        np.concatenate([colour, palette.GOAL[None]]),
    )


def heights(ticks: np.ndarray, began: int, now: int, length: int) -> np.ndarray:
    """Heights of ticks (K,) where time rises, as shares of that of `length` ticks.

    The oldest tick shown is on the floor: the first of the run, until that is too long ago.

    >>> heights(np.array([0, 5, 10]), 0, 10, 20).tolist()
    [0.0, 0.25, 0.5]
    """
    return (ticks - max(began, now - length)) / length


def is_rising(picture: Picture) -> bool:
    """Whether bands rise: in a flat world, where there is room above."""
    return picture.look.trails == RISING and picture.stage.dim == 2


def present_height(picture: Picture) -> float:
    """Height of the present where bands rise, on the display; 0 where they do not."""
    return RISE * picture.stage.side if is_rising(picture) else 0.0


def breadth(picture: Picture) -> float:
    """Width of a band on the display."""
    cars = picture.frame.cars
    if cars is None or not picture.as_cars:
        return BROAD * picture.length
    return BROAD_CAR * picture.length * cars.width / cars.length


def tile() -> Mesh:
    """The unit square about the origin in the plane z = 0, facing up."""
    corners = np.array([[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]])
    return corners, np.array([[0, 1, 2], [0, 2, 3]])
