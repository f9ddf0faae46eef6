"""From the world's units to the display's and back.

The longest side of the world becomes `DISPLAY_SIDE`, centred on the origin: viser's shadows reach
20 units from the camera, so the scene has to stay small whatever the world's units are.
A two-dimensional world lies on the plane z = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.viewer.frame import Frame

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

    @staticmethod
    def of(frame: Frame) -> Stage:
        return Stage(
            dim=int(frame.dim),
            size=tuple(float(side) for side in frame.size),
            wraps=tuple(bool(axis) for axis in frame.wraps),
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

    def shown(self, position: np.ndarray) -> np.ndarray:
        """Positions (..., dim) in the world -> (..., 3) on the display.

        >>> Stage(2, (20.0, 10.0), (True, True)).shown(np.array([20.0, 5.0])).tolist()
        [5.0, 0.0, 0.0]
        """
        position = np.asarray(position, dtype=float)
        shown = np.zeros((*position.shape[:-1], 3))
        shown[..., : self.dim] = (position - 0.5 * np.array(self.size)) * self.scale
        return shown

    def world(self, shown: np.ndarray) -> np.ndarray:
        """The inverse of `shown`: (..., 3) on the display -> (..., dim) in the world."""
        return np.asarray(shown, dtype=float)[..., : self.dim] / self.scale + 0.5 * np.array(
            self.size
        )

    @property
    def period(self) -> np.ndarray:
        """Sides of the box on the display for the axes that wrap, infinite for the others, (3,)."""
        period = np.full(3, np.inf)
        wraps = np.array(self.wraps)
        period[: self.dim][wraps] = (self.scale * np.array(self.size))[wraps]
        return period
