"""Points of view: presets fitted to the world, and following an agent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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
        seen = (upwards - lift) / (distance - nearer)
        lift += 0.5 * distance * (float(np.max(seen)) + float(np.min(seen)))
    target = centre + lift * over
    return CameraView(target + distance * back, target, preset.fov)
