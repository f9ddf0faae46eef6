"""Handles by which a person moves obstacles and the goal, and the marks of what is being drawn."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from viser import SceneApi, TransformControlsEvent

from app.viewer.editing.editor import has_heights
from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.line_segments import add_lines, segments
from app.viewer.scene.draw.shapes import circle
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.marks.obstacle_marks import drawn_height
from app.viewer.scene.shown import palette

SETTLE = 0.35
"""Seconds after a release before a gizmo goes to its place again: frames on their way are old."""
SPOT = 0.008
"""Radius of the mark on a corner that was clicked, as a multiple of the longest side."""
ABOVE = 0.012
"""How far above what they mark the lines are, on the display."""


@dataclass(frozen=True)
class Marks:
    """What handles and marks are to be seen."""

    key: int = 0
    """Key of the selected obstacle; 0 for none."""
    obstacle: Any = None
    goal: bool = False
    """Whether the goal has handles."""
    corners: tuple[tuple[float, float], ...] = ()
    """Corners of a polygon that is not closed yet, in the world."""


@dataclass(frozen=True)
class Drag:
    """How far a gizmo has been dragged since it was grabbed."""

    thing: int
    """Key of the obstacle; 0 for the goal."""
    gesture: str
    """A name that no other drag has."""
    by: tuple[float, ...]
    """Shift, (3,), length."""
    degrees: float
    """Turn about the upright axis, anticlockwise."""
    done: bool
    """Whether it was let go."""


Dragged = Callable[[Drag], None]


class Handles:
    """A gizmo on the selected obstacle and one on the goal, an outline, and corners."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._marks = Marks()
        self._picture: Picture | None = None
        self._outline = add_lines(scene, f"{root}/handles/outline", thickness=3.2)
        self._sketch = add_lines(scene, f"{root}/handles/sketch", thickness=2.6)
        self._obstacle = Gizmo(scene, f"{root}/handles/obstacle", turns=True)
        self._goal = Gizmo(scene, f"{root}/handles/goal", turns=False)

    def on_dragged(self, callback: Dragged) -> None:
        """Call `callback(drag)`, world units, while a gizmo is dragged and when it is let go."""
        self._obstacle.on_dragged(callback)
        self._goal.on_dragged(callback)

    def show(self, marks: Marks) -> None:
        """Show other handles and marks from now on."""
        self._marks = marks
        for handle, name, value in self.draw(self._picture) if self._picture is not None else ():
            setattr(handle, name, value)

    def draw(self, picture: Picture) -> Changes:
        """Bring handles and marks to their places."""
        self._picture = picture
        marks, stage = self._marks, picture.stage
        changes: Changes = []
        obstacle = marks.obstacle
        if obstacle is None:
            changes += [*self._obstacle.hide(), (self._outline, "visible", False)]
        else:
            changes += self._obstacle.put(marks.key, stage, grip(picture, obstacle), obstacle)
            lines = outline(picture, obstacle)
            changes += segments(self._outline, lines, palette.node_colour(palette.HALO))
        goal = picture.frame.progress.goal if marks.goal else None
        if goal is None:
            changes += self._goal.hide()
        else:
            changes += self._goal.put(0, stage, stage.to_display(goal), None)
        return changes + segments(
            self._sketch, sketch(picture, marks.corners), palette.node_colour(palette.LEADER)
        )


class Gizmo:
    """Arrows, a plate and an arc; what it reports is relative to where it was grabbed."""

    numbers = itertools.count(1)

    def __init__(self, scene: SceneApi, name: str, turns: bool) -> None:
        self._turns = turns
        self._thing = 0
        self._stage: Stage | None = None
        self._holder: int | None = None
        """The browser that holds it: the last to take hold of it."""
        self._grabbed: tuple[int, str, np.ndarray, float] = (0, "", np.zeros(3), 0.0)
        """What was grabbed, the gesture's name, where and how it stood then."""
        self._released = 0.0
        self._dragged: list[Dragged] = []
        self._handle = scene.add_transform_controls(
            name,
            scale=85.0,
            fixed=True,
            line_width=3.5,
            active_axes=(True, True, False),
            disable_rotations=not turns,
            depth_test=False,
            opacity=0.9,
            visible=False,
        )
        self._handle.on_update(self._handle_drag)

    def on_dragged(self, callback: Dragged) -> None:
        self._dragged.append(callback)

    def hide(self) -> Changes:
        self._thing = 0
        return [(self._handle, "visible", False)] if self._handle.visible else []

    def put(self, thing: int, stage: Stage, place: np.ndarray, obstacle: Any) -> Changes:
        """Bring it to a thing, unless somebody drags it."""
        other = thing != self._thing or stage != self._stage
        if other:
            self._thing, self._stage, self._holder = thing, stage, None
        elif self._holder is not None or time.monotonic() - self._released < SETTLE:
            return []
        upright = stage.dim == 3 and (obstacle is None or has_heights(obstacle))
        round_one = obstacle is None or obstacle.shape in ("disc", "ring", "sphere")
        options: dict[str, Any] = {
            "active_axes": (True, True, upright),
            "disable_rotations": not self._turns or upright or round_one,
            "position": np.asarray(place, float),
            "wxyz": np.array([1.0, 0.0, 0.0, 0.0]),
            "visible": True,
        }
        return [
            (self._handle, name, value)
            for name, value in options.items()
            if not np.array_equal(getattr(self._handle, name), value)
        ]

    async def _handle_drag(self, event: TransformControlsEvent) -> None:
        """On the event loop, so that start, updates and end arrive in order."""
        stage = self._stage
        place = np.asarray(event.target.position, float)
        angle = azimuth(np.asarray(event.target.wxyz, float))
        if stage is None or place.shape != (3,) or not np.isfinite([*place, angle]).all():
            return
        if event.phase == "start":
            self._holder = event.client_id
            gesture = f"{self._handle.name} {next(self.numbers)}"
            self._grabbed = (self._thing, gesture, place, angle)
            return
        if event.client_id != self._holder:
            return
        done = event.phase == "end"
        if done:
            self._holder, self._released = None, time.monotonic()
        thing, gesture, start, before = self._grabbed
        by = tuple(float(step) for step in (place - start) / stage.scale)
        drag = Drag(thing, gesture, by, float(np.rad2deg(angle - before)), done)
        for callback in self._dragged:
            callback(drag)


def azimuth(wxyz: np.ndarray) -> float:
    """The turn about the upright axis of an attitude, rad; NaN for what is none."""
    if wxyz.shape != (4,) or not np.isfinite(wxyz).all() or not wxyz.any():
        return float("nan")
    w, x, y, z = wxyz
    return float(np.arctan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z))


def grip(picture: Picture, obstacle: Any) -> np.ndarray:
    """Where an obstacle is taken hold of, on the display, (3,)."""
    world, stage = picture.frame.world, picture.stage
    height = obstacle.handle_height(world.height) if stage.dim == 3 else drawn_height(world)
    return stage.place_on_display(np.array([*obstacle.anchor, height]))


def outline(picture: Picture, obstacle: Any) -> np.ndarray:
    """Lines around an obstacle at its upper rim, or about its middle for a sphere, (K, 2, 3)."""
    world, stage = picture.frame.world, picture.stage
    rings = []
    for part, _, top in obstacle.spans():
        upper = world.height if top is None else top
        height = upper if stage.dim == 3 else drawn_height(world)
        rings += [(ring, height) for ring in (part.exterior, *part.interiors)]
    for (x, y, z), radius in obstacle.spheres():
        rings.append((shapely.Point(x, y).buffer(radius, quad_segs=16).exterior, z))
    lines = []
    for ring, height in rings:
        points = shapely.get_coordinates(ring)
        placed = stage.place_on_display(np.column_stack([points, np.full(len(points), height)]))
        placed[:, 2] += ABOVE
        lines.append(np.stack([placed[:-1], placed[1:]], axis=1))
    return np.concatenate(lines) if lines else np.empty((0, 2, 3))


def sketch(picture: Picture, corners: tuple[tuple[float, float], ...]) -> np.ndarray:
    """Lines between the corners of an open polygon, and a ring on each, (K, 2, 3)."""
    if not corners:
        return np.empty((0, 2, 3))
    stage, world = picture.stage, picture.frame.world
    floor = world.low[2] if stage.dim == 3 else 0.0
    at = stage.place_on_display(np.column_stack([np.array(corners), np.full(len(corners), floor)]))
    at[:, 2] += 2.0 * ABOVE
    radius = SPOT * stage.side
    rings = [spot + radius * circle(24) for spot in at]
    return np.concatenate([np.stack([at[:-1], at[1:]], axis=1), *rings])
