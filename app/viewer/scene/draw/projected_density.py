"""A picture of so many agents in space that none can be told apart, as a camera sees them: how many
are behind each point of it, and where they head.

Hue is the mean heading's direction on the floor, as of single agents: it stays while the camera
goes round. Strength is how many are in a line of sight. Grey are those that head different ways,
and those that climb or dive steeply.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from agents.engine.cache import compile_to_disk
from app.viewer.scene.draw.density import (
    BORDER,
    COARSE,
    PER_CELL,
    fill_pixels,
    smooth_sums,
    typical_count,
)
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.shown import palette
from worlds.compilation import compiled

CELLS = 512 * 288
"""Cells of a picture at most."""
LONGEST = 1024
"""Cells along a side at most, however long and narrow a window is."""
FAINTEST = 0.025
"""A cell is drawn from this share of the typical number of agents on: with fewer it would be paler
than what is behind it."""
NEAREST = 0.02
"""Where drawing begins, display units from the camera."""


class Lens(NamedTuple):
    """A camera on a flock in space, as kernels take it."""

    axes: np.ndarray
    """(4, 3): where it stands in the world, then its directions to the right, upwards and ahead.
    Products with the last three are display units; in sight is whose first two are no longer than
    the third."""
    aspect: float
    """Width over height."""

    @staticmethod
    def of(
        eye: np.ndarray,
        target: np.ndarray,
        up: np.ndarray,
        fov: float,
        aspect: float,
        stage: Stage,
    ) -> Lens:
        """A camera that stands at `eye` (3,) on the display, looks at `target` (3,) and sees `fov`
        (rad) from top to bottom. What is no camera sees nobody."""
        with np.errstate(all="ignore"):  # a browser may say what it likes of its camera
            ahead = target - eye
            ahead = ahead / max(float(np.linalg.norm(ahead)), 1e-9)
            right = np.cross(ahead, up)
            right = right / max(float(np.linalg.norm(right)), 1e-9)
            over = np.cross(right, ahead)
            tall = float(np.tan(0.5 * fov))
            ways = np.stack([right / (tall * aspect), over / tall, ahead])
            return Lens(np.stack([stage.world(eye), *(stage.scale * ways)]), aspect)

    def widened(self, share: float) -> Lens:
        """One that sees so much more at each side, as a share of its sides."""
        axes = self.axes.copy()
        axes[1:3] /= 1.0 + 2.0 * share
        return Lens(axes, self.aspect)


@dataclass(frozen=True)
class ProjectedDensity:
    """The picture that a camera sees."""

    pixels: np.ndarray
    """(rows, columns, 3) uint8, sRGB; the first row is the uppermost."""
    depth: np.ndarray
    """(rows, columns) float32: how far ahead of the camera the nearest agents about a cell are,
    display units; infinite where the cell is not drawn."""


def projected_density(
    flocks: Iterable[tuple[np.ndarray, np.ndarray, Lens, float]], aspect: float, count: int
) -> ProjectedDensity:
    """The picture of flocks with about `count` agents in sight, in a window of this aspect.

    Of each flock: positions (N, 3), headings (N, 3), unit vectors, the camera on it, and how far
    ahead of it drawing begins, display units.
    """
    rows, columns = view_shape(aspect, count)
    sums = np.zeros((rows + 2 * BORDER, columns + 2 * BORDER, 3), np.float32)
    nearest = np.full(sums.shape[:2], np.inf, np.float32)
    for position, heading, lens, near in flocks:
        fill_view_sums(position, heading, lens.axes, near, sums, nearest)
    about = smooth_sums(sums)
    typical = typical_count(about)
    pixels = np.empty((rows, columns, 3), np.uint8)
    fill_pixels(about, typical, palette.density_table(), pixels)
    depth = np.empty((rows, columns), np.float32)
    fill_depth(nearest, about, FAINTEST * typical, depth)
    return ProjectedDensity(pixels, depth)


def view_shape(aspect: float, count: int) -> tuple[int, int]:
    """Rows and columns of the picture of a view with so many agents; its cells are square.

    >>> view_shape(16 / 9, 1_000_000), view_shape(16 / 9, 20_000)
    ((288, 512), (72, 128))
    """
    side = math.sqrt(min(count / PER_CELL, CELLS)) // COARSE * COARSE
    side = max(side, COARSE)
    stretch = math.sqrt(aspect)
    tall, wide = (
        min(max(round(length), 1), LONGEST) for length in (side / stretch, side * stretch)
    )
    return tall, wide


@compiled
def seen_from(axes, x, y, z):
    """A place as a camera sees it: to the right, upwards and ahead of it, see `Lens`."""
    x, y, z = x - axes[0, 0], y - axes[0, 1], z - axes[0, 2]
    return (
        x * axes[1, 0] + y * axes[1, 1] + z * axes[1, 2],
        x * axes[2, 0] + y * axes[2, 1] + z * axes[2, 2],
        x * axes[3, 0] + y * axes[3, 1] + z * axes[3, 2],
    )


@compile_to_disk
def count_by_depth(position, axes, near, step, counts):
    """Add to `counts` (K,) how many agents at `position` (N, 3) are in sight at least `near` ahead:
    by how many whole `step` ahead, the last all farther ones."""
    last = len(counts) - 1
    for i in range(len(position)):
        right, over, ahead = seen_from(axes, position[i, 0], position[i, 1], position[i, 2])
        if ahead > near and right >= -ahead and right < ahead and over > -ahead and over <= ahead:
            steps = ahead / step
            counts[int(steps) if steps < last else last] += 1


@compile_to_disk
def fill_rows_in_view(position, axes, near, far, rows):
    """Fill `rows` (M,) with those of the first M agents in sight that are farther ahead than `near`
    and not than `far`; returns how many there are."""
    count = 0
    for i in range(len(position)):
        right, over, ahead = seen_from(axes, position[i, 0], position[i, 1], position[i, 2])
        if ahead > near and right >= -ahead and right < ahead and over > -ahead and over <= ahead:
            is_near = ahead <= far
            if is_near and count < len(rows):
                rows[count] = i
                count += 1
    return count


@compile_to_disk
def fill_view_sums(position, heading, axes, near, sums, nearest):
    """Add to `sums` (rows + 4, columns + 4, 3) how many agents farther ahead than `near` each cell
    of a view has behind it, and the sum of the level parts of their headings.

    `nearest` (rows + 4, columns + 4) becomes how far ahead the nearest is. The cells at the edges
    are those just outside of the view, which its smoothing reaches.
    """
    rows, columns = sums.shape[0] - 2 * BORDER, sums.shape[1] - 2 * BORDER
    for i in range(len(position)):
        right, over, ahead = seen_from(axes, position[i, 0], position[i, 1], position[i, 2])
        if ahead > near:
            x = 0.5 * (1.0 + right / ahead) * columns + BORDER
            y = 0.5 * (1.0 - over / ahead) * rows + BORDER
            if x >= 0.0 and x < columns + 2 * BORDER and y >= 0.0 and y < rows + 2 * BORDER:
                row, column = int(y), int(x)
                sums[row, column, 0] += 1.0
                sums[row, column, 1] += heading[i, 0]
                sums[row, column, 2] += heading[i, 1]
                nearest[row, column] = min(nearest[row, column], ahead)


@compile_to_disk
def fill_depth(nearest, sums, least, depth):
    """Fill `depth` (rows, columns) with the nearest of the cells that each smoothed cell is of;
    infinite where `sums` (rows, columns, 3) has no more than `least` agents."""
    rows, columns = depth.shape
    for row in range(rows):
        for column in range(columns):
            found = np.float32(np.inf)
            if sums[row, column, 0] > least:
                for i in range(row, row + 2 * BORDER + 1):
                    for j in range(column, column + 2 * BORDER + 1):
                        found = min(found, nearest[i, j])
            depth[row, column] = found
