"""The second of two flocks: its own room at some distance from the first, and titles over both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from viser import FrameHandle, LabelHandle, SceneApi

from app.viewer.scene.cameras.viewpoints import Sight, places
from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.parts import Parts
from app.viewer.scene.picking import picked

ROOT = "/beside"
GAP = 0.07
"""Least distance between the rooms, as a multiple of the longest side; with a title, TITLED."""
TITLED = 0.16
WIDE = 1.5
"""A world wider than this many times its depth has the second room below it, not on its right."""
SUNK = 0.02
"""How much lower the second floor lies, so that wide floors do not flicker through each other."""
CELL = 0.05
"""The rooms are whole cells of the floor apart, as a multiple of the longest side."""
LIFT = {2: 0.025, 3: 0.13}
"""Height of a title over its room, as a multiple of the longest side, by dimension."""


@dataclass
class ComparisonNodes:
    """Nodes that are there only while there are two flocks."""

    scene: SceneApi
    parts: Parts | None = None
    frame: FrameHandle | None = None
    titles: tuple[LabelHandle, ...] = ()

    @property
    def is_open(self) -> bool:
        """Whether the second flock is there and has left its box."""
        return self.parts is not None and self.parts.is_open

    def draw_box(self, first: Picture, second: Picture | None) -> Changes:
        """Make the second room, or take it away, and bring it up to date."""
        if second is None:
            if self.frame is not None:
                self.frame.remove()  # With all that is below it.
                self.parts, self.frame, self.titles = None, None, ()
            return []
        if self.parts is None or self.frame is None:
            self.frame = self.scene.add_frame(ROOT, show_axes=False)
            self.parts = Parts(self.scene, ROOT)
            self.titles = tuple(self._title(name) for name in ("first", "second"))
        aside = offset(first)
        one, other = self.titles
        changes: Changes = [
            (self.frame, "position", aside),
            (one, "text", first.frame.title),
            (one, "position", over(first) - aside),
            (other, "text", second.frame.title),
            (other, "position", over(second)),
        ]
        changes = [one for one in changes if not np.array_equal(getattr(one[0], one[1]), one[2])]
        return changes + self.parts.draw_box(second)

    def draw_flock(self, second: Picture | None) -> Changes:
        """What is to be changed for this frame."""
        return [] if second is None or self.parts is None else self.parts.draw_flock(second)

    def _title(self, name: str) -> LabelHandle:
        return self.scene.add_label(
            f"{ROOT}/titles/{name}", "", anchor="bottom-center", font_screen_scale=1.25
        )


def sights(first: Picture, second: Picture | None) -> tuple[Sight, ...]:
    """The pictures and where they stand."""
    here = Sight(first, np.zeros(3))
    return (here,) if second is None else (here, Sight(second, offset(first)))


def meant(
    sights: tuple[Sight, ...], origin: np.ndarray, direction: np.ndarray, near: float
) -> tuple[int, int | None]:
    """Which flock a click is for, 0 or 1, and the row of the agent that it hits, if any.

    Origin and direction (3,) are of the ray on the display, `near` is the half-width of the cone
    about it (rad). Where it hits nobody it is for the room whose middle it passes more closely.
    """
    for side, (shown, aside) in enumerate(sights):
        radius = 0.5 * shown.length * shown.size
        row = picked(origin - aside, direction, shown.at, radius, near)
        if row is not None:
            return side, row
    away = [passes(origin - aside, direction, shown.stage.floor) for shown, aside in sights]
    return int(np.argmin(away)), None


def passes(origin: np.ndarray, direction: np.ndarray, floor: float) -> float:
    """How far from the middle a ray meets the floor of a room; infinite if it does not."""
    if direction[2] == 0.0:
        return float("inf")
    share = (floor - origin[2]) / direction[2]
    away = float(np.hypot(*(origin + share * direction)[:2]))
    return away if share > 0.0 and np.isfinite(away) else float("inf")


def room(picture: Picture) -> tuple[np.ndarray, np.ndarray]:
    """Corners (3,) of the world's box and its mission on the display; they do not move."""
    low, high = -picture.stage.half, picture.stage.half.copy()
    for place in places(picture):
        low, high = np.minimum(low, place), np.maximum(high, place)
    return low, high


def offset(picture: Picture) -> np.ndarray:
    """Where the second room's centre is, (3,): right of the first, or below it if that is wide."""
    low, high = room(picture)
    side, flat = picture.stage.side, picture.stage.dim == 2
    width, depth = (high - low)[:2]
    below = flat and width > WIDE * depth
    away = depth + TITLED * side if below else width + GAP * side
    away = CELL * side * np.ceil(away / (CELL * side))
    return np.array([0.0 if below else away, -away if below else 0.0, -SUNK if flat else 0.0])


def over(picture: Picture) -> np.ndarray:
    """Where a room's title stands, (3,)."""
    low, high = room(picture)
    middle, lift = 0.5 * (low + high), LIFT[picture.stage.dim] * picture.stage.side
    if picture.stage.dim == 2:
        return np.array([middle[0], high[1] + lift, 0.0])
    return np.array([middle[0], middle[1], high[2] + lift])
