"""Points of view: presets fitted to the world, and following an agent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.viewer.scene.draw.drawn_frame import Picture
from app.viewer.scene.draw.line_segments import nearest_image

UP = np.array([0.0, 0.0, 1.0])
MARGIN = {2: 1.13, 3: 1.20}
"""Room left around a world, as a multiple of its extent in the view."""


@dataclass(frozen=True)
class CameraView:
    """Where a camera stands and where it looks, on the display."""

    position: np.ndarray
    target: np.ndarray
    fov: float
    """Vertical field of view, rad."""

    @property
    def near(self) -> float:
        """Where drawing begins: far enough that depths stay distinct at this distance, and nearer
        than 1, where viser hangs the background.
        """
        return min(0.5, 0.02 * float(np.linalg.norm(self.position - self.target)))


@dataclass(frozen=True)
class _Preset:
    azimuth: float
    """Direction from the target to the camera, deg."""
    elevation: float
    fov: float


_TOP_DOWN = {2: _Preset(-90.0, 89.95, 0.14), 3: _Preset(-90.0, 89.95, 0.80)}
"""In the plane so narrow and far that nothing leans and the shadows, which viser draws within 20
units of the camera, are all out of reach; a hair off the pole, which keeps y up."""
_PERSPECTIVE = {2: _Preset(-112.0, 42.0, 0.55), 3: _Preset(-120.0, 26.0, 0.80)}
_SIDE = {2: _Preset(-90.0, 14.0, 0.45), 3: _Preset(-90.0, 4.0, 0.75)}
_CLOSE = {2: _Preset(-90.0, 58.0, 0.55), 3: _Preset(-118.0, 22.0, 0.60)}


def view(name: str, dim: int, low: np.ndarray, high: np.ndarray, aspect: float) -> CameraView:
    """The preset `name` for a box from `low` to `high`, (3,), in a canvas of this aspect."""
    presets = {
        "top-down": _TOP_DOWN[dim],
        "perspective": _PERSPECTIVE[dim],
        "side": _SIDE[dim],
        "follow": _CLOSE[dim],
    }
    if name not in presets:
        raise ValueError(f"camera = {name!r} is not one of {', '.join(presets)}")
    return _fitted(presets[name], low, high, aspect, MARGIN[dim])


def _fitted(
    preset: _Preset, low: np.ndarray, high: np.ndarray, aspect: float, margin: float
) -> CameraView:
    """The nearest place along the preset's direction from which the whole box is in view."""
    azimuth, elevation = np.deg2rad(preset.azimuth), np.deg2rad(preset.elevation)
    back = np.array(
        [
            np.cos(azimuth) * np.cos(elevation),
            np.sin(azimuth) * np.cos(elevation),
            np.sin(elevation),
        ]
    )
    right = np.cross(UP, back) / np.linalg.norm(np.cross(UP, back))
    over = np.cross(back, right)
    centre = 0.5 * (low + high)
    corners = np.stack(np.meshgrid(*np.stack([low, high], axis=1)), axis=-1).reshape(-1, 3) - centre
    tangent = np.tan(0.5 * preset.fov) / margin
    sideways, upwards, nearer = corners @ right, corners @ over, corners @ back
    lift, distance = 0.0, 1.0
    for _ in range(8):
        needed = np.maximum(np.abs(sideways) / aspect, np.abs(upwards - lift)) / tangent
        distance = max(float(np.max(needed + nearer)), 1.0)
        # Perspective shows the near half of the box larger: look at the middle of what is seen.
        slope = (upwards - lift) / (distance - nearer)
        lift += 0.5 * distance * (float(np.max(slope)) + float(np.min(slope)))
    target = centre + lift * over
    return CameraView(target + distance * back, target, preset.fov)


# A camera that rides along: behind an agent and over it, looking where it goes.

CATCH_UP, TURN = 0.10, 0.22
"""Time constants with which it catches up with the agent's place and with its heading, s."""
BEHIND, OVER, AHEAD = {2: 6.0, 3: 4.4}, {2: 3.2, 3: 1.5}, {2: 2.0, 3: 2.5}
"""Where it is and what it looks at, in lengths of the agent, by dimension."""
STEEPEST = np.deg2rad(50.0)
"""A camera does not follow a climb or a dive steeper than this: it would lose its upright."""
ABOVE_FLOOR = 0.6
"""How far it keeps above the floor, in lengths of the agent."""
FOV = 1.0


class Ride:
    """One browser's ride on the agent of one identity."""

    def __init__(
        self, picture: Picture, row: int, aside: np.ndarray, side: int, before: CameraView
    ) -> None:
        """`aside` (3,) is where the room of the flock `side` stands."""
        self.side, self.before = side, before
        self.identity = int(picture.frame.ids[row])
        self._place = self._seen = picture.at[row] + aside
        self._ahead = limited_direction(picture.frame.heading[row])
        self.view = self._look(picture, row, aside)

    def move(self, picture: Picture, aside: np.ndarray, passed: float) -> bool:
        """Go on to a new frame, `passed` seconds after the last; whether the agent is there."""
        rows = np.flatnonzero(picture.frame.ids == self.identity)
        if not len(rows):
            return False
        row = int(rows[0])
        at = picture.at[row] + aside
        step = at - self._seen
        # Through a seam the camera goes with its agent, and only the rest of the way smoothly.
        self._place = self._place + step - nearest_image(step[None], picture.stage.period)[0]
        self._place = self._place + (1.0 - np.exp(-passed / CATCH_UP)) * (at - self._place)
        self._seen = at
        if not picture.frame.is_down[row]:
            heading = limited_direction(picture.frame.heading[row])
            ahead = self._ahead + (1.0 - np.exp(-passed / TURN)) * (heading - self._ahead)
            if np.linalg.norm(ahead) > 1e-3:
                self._ahead = limited_direction(ahead)
        self.view = self._look(picture, row, aside)
        return True

    def _look(self, picture: Picture, row: int, aside: np.ndarray) -> CameraView:
        dim, length = picture.stage.dim, picture.length * float(picture.size[row])
        up = np.array([0.0, 0.0, 1.0])
        position = self._place + length * (OVER[dim] * up - BEHIND[dim] * self._ahead)
        position[2] = max(position[2], picture.stage.floor + aside[2] + ABOVE_FLOOR * length)
        return CameraView(position, self._place + AHEAD[dim] * length * self._ahead, FOV)


def limited_direction(heading: np.ndarray) -> np.ndarray:
    """A direction (2,) or (3,) as a unit vector (3,) that is no steeper than STEEPEST."""
    level = np.array([heading[0], heading[1], 0.0])
    across = float(np.linalg.norm(level))
    level = level / across if across > 1e-9 else np.array([1.0, 0.0, 0.0])
    rise = 0.0 if len(heading) == 2 else np.arctan2(heading[2], across)
    rise = float(np.clip(rise, -STEEPEST, STEEPEST))
    return np.cos(rise) * level + np.array([0.0, 0.0, np.sin(rise)])
