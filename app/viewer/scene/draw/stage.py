"""From the world's units to the display's and back.

The longest side of the world becomes `DISPLAY_SIDE`, centred on the origin: viser's shadows reach
20 units from the camera, so the scene has to stay small whatever the world's units are.
A two-dimensional world lies on the plane z = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.viewer.scene.shown.frame import Frame

DISPLAY_SIDE = {2: 10.0, 3: 8.0}
"""Longest side of a world on the display, by its dimension."""


@dataclass(frozen=True)
class Stage:
    """A world's box on the display; equal stages need no new floor, box or camera."""

    dim: int
    size: tuple[float, ...]
    """Sides of the world's box, (dim,), length."""
    wraps: tuple[bool, ...]
    """Whether each axis wraps, (dim,)."""
    low: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Lower corner of the box, (dim,) or more, length."""
    solid: tuple[bool, ...] = (False, False, False)
    """Whether the edges across each axis are solid, (dim,) or more."""

    @staticmethod
    def of(frame: Frame) -> Stage:
        return Stage(
            dim=int(frame.dim),
            size=tuple(float(side) for side in frame.size),
            wraps=tuple(bool(axis) for axis in frame.wraps),
            low=tuple(float(at) for at in frame.low),
            solid=tuple(edge == "solid" for edge in frame.world.edges),
        )

    @property
    def side(self) -> float:
        """Longest side of the box on the display."""
        return DISPLAY_SIDE[self.dim]

    @property
    def scale(self) -> float:
        """Display units per unit of length."""
        return self.side / max(self.size)

    @property
    def half(self) -> np.ndarray:
        """Half the sides of the box on the display, (3,); zero height in two dimensions."""
        sides = np.zeros(3)
        sides[: self.dim] = self.size
        return 0.5 * self.scale * sides

    @property
    def floor(self) -> float:
        """Height of the floor on the display."""
        return float(-self.half[2])

    @property
    def middle(self) -> np.ndarray:
        """Centre of the box in the world, (dim,), length."""
        return np.array(self.low[: self.dim]) + 0.5 * np.array(self.size)

    def to_display(self, position: np.ndarray) -> np.ndarray:
        """Positions (..., dim) in the world -> (..., 3) on the display.

        >>> Stage(2, (20.0, 10.0), (True, True)).to_display(np.array([20.0, 5.0])).tolist()
        [5.0, 0.0, 0.0]
        """
        position = np.asarray(position, dtype=float)
        placed = np.zeros((*position.shape[:-1], 3))
        shown = placed[..., : self.dim]
        np.subtract(position, self.middle, out=shown)
        shown *= self.scale
        return placed

    def place_on_display(self, points: np.ndarray) -> np.ndarray:
        """Places (..., 3) in the world, upright things standing on a flat one too -> (..., 3)."""
        placed = self.to_display(points[..., : self.dim])
        if self.dim == 2:
            placed[..., 2] = points[..., 2] * self.scale
        return placed

    def world(self, points: np.ndarray) -> np.ndarray:
        """The inverse of `points`: (..., 3) on the display -> (..., dim) in the world."""
        return np.asarray(points, dtype=float)[..., : self.dim] / self.scale + self.middle

    def place_in_world(self, points: np.ndarray) -> np.ndarray:
        """The inverse of `place_on_display`: (..., 3) on the display -> (..., 3) in the world."""
        middle = np.zeros(3)
        middle[: self.dim] = self.middle
        return np.asarray(points, dtype=float) / self.scale + middle

    @property
    def period(self) -> np.ndarray:
        """Sides of the box on the display for the axes that wrap, infinite for the others, (3,)."""
        period = np.full(3, np.inf)
        wraps = np.array(self.wraps)
        period[: self.dim][wraps] = (self.scale * np.array(self.size))[wraps]
        return period
