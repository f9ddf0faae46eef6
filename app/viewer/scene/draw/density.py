"""A picture of so many agents in the plane that none can be told apart: where they are dense, and
where they head.

Hue is the mean heading, strength the density, and what heads different ways is grey.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from agents.engine.cache import compile_to_disk
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.frame import Frame
from worlds.compilation import compiled

CELLS = 512
"""Cells along a side of a square picture at most."""
PER_CELL = 2.0
"""Agents in a cell on average, at least: of fewer agents in sight the cells are larger."""
COARSE = 32
"""Cells along a side are a multiple of this, so that few pictures have others than the last."""
BORDER = 2
"""Cells at each side of a picture that its smoothing reaches."""
WEIGHTS = 256.0 / 70.0
"""A cell is smoothed with its neighbours by binomial weights, (1, 4, 6, 4, 1) / 16 along each axis:
as many cells along each axis count as one."""


@dataclass(frozen=True)
class PlaneRegion:
    """A rectangle in a flat world, length."""

    low: tuple[float, float]
    high: tuple[float, float]

    @property
    def sides(self) -> tuple[float, float]:
        """Width and depth, length."""
        return self.high[0] - self.low[0], self.high[1] - self.low[1]

    @property
    def area(self) -> float:
        """Length squared."""
        return self.sides[0] * self.sides[1]

    def contains(self, other: PlaneRegion) -> bool:
        """Whether another lies in it."""
        return bool(
            np.all(np.less_equal(self.low, other.low))
            and np.all(np.greater_equal(self.high, other.high))
        )

    def intersection(self, other: PlaneRegion) -> PlaneRegion | None:
        """What two have in common; None if nothing."""
        low, high = np.maximum(self.low, other.low), np.minimum(self.high, other.high)
        if not np.all(low < high):
            return None
        return PlaneRegion((float(low[0]), float(low[1])), (float(high[0]), float(high[1])))

    def grown(self, share: float) -> PlaneRegion:
        """With so much more at each side, as a share of its sides."""
        more = share * np.array(self.sides)
        low, high = np.array(self.low) - more, np.array(self.high) + more
        return PlaneRegion((float(low[0]), float(low[1])), (float(high[0]), float(high[1])))


@dataclass(frozen=True)
class DensityPicture:
    """The picture of a region."""

    region: PlaneRegion
    pixels: np.ndarray
    """(rows, columns, 3) uint8, sRGB; the first row is the lowest y."""
    typical: float
    """The density that has half the strength: what an agent has around it on average, per length
    squared."""


def flock_region(frame: Frame) -> PlaneRegion:
    """The box of a flat world, and the flock where it has flown out of it."""
    corners = np.array([frame.low, frame.low + frame.size])
    if not frame.wraps.all():
        fill_extent(frame.position, corners)
        corners[1] = np.nextafter(corners[1], np.inf)  # a region ends before its upper corner
    low, high = corners.tolist()
    return PlaneRegion((low[0], low[1]), (high[0], high[1]))


def density_picture(
    position: np.ndarray, heading: np.ndarray, region: PlaneRegion, count: int
) -> DensityPicture:
    """The picture of a region with about `count` of the agents at `position` (N, 2), which go along
    `heading` (N, 2), unit vectors."""
    rows, columns = grid_shape(region, count)
    sums = smoothed_sums(position, heading, region, rows, columns)
    typical = typical_count(sums)
    pixels = np.empty((rows, columns, 3), np.uint8)
    fill_pixels(sums, typical, palette.density_table(), pixels)
    return DensityPicture(region, pixels, typical * rows * columns / region.area)


def smoothed_sums(
    position: np.ndarray, heading: np.ndarray, region: PlaneRegion, rows: int, columns: int
) -> np.ndarray:
    """How many agents there are about each cell of a region, and the sum of their headings,
    (rows, columns, 3) float32."""
    wide, deep = region.sides[0] / columns, region.sides[1] / rows
    # Those just outside count for the cells at the edge.
    low = region.low[0] - BORDER * wide, region.low[1] - BORDER * deep
    sums = np.zeros((rows + 2 * BORDER, columns + 2 * BORDER, 3), np.float32)
    fill_sums(position, heading, *low, wide, deep, sums)
    return smooth_sums(sums)


def smooth_sums(sums: np.ndarray) -> np.ndarray:
    """Of sums (rows + 4, columns + 4, 3) those about all cells inside, (rows, columns, 3)."""
    rows, columns = sums.shape[0] - 2 * BORDER, sums.shape[1] - 2 * BORDER
    across = np.empty((rows + 2 * BORDER, columns, 3), np.float32)
    smooth_columns(sums, across)
    about = np.empty((rows, columns, 3), np.float32)
    smooth_columns(across.transpose(1, 0, 2), about.transpose(1, 0, 2))
    return about


def typical_count(sums: np.ndarray) -> float:
    """How many agents an agent has about its cell on average, of smoothed sums (rows, columns, 3);
    1 if there are none."""
    inside = sums[..., 0]
    crowd = float(inside.sum())
    return float(np.vdot(inside, inside)) / crowd if crowd > 0.0 else 1.0


def grid_shape(region: PlaneRegion, count: int) -> tuple[int, int]:
    """Rows and columns of the picture of a region with so many agents; its cells are square.

    >>> square = PlaneRegion((0.0, 0.0), (10.0, 10.0))
    >>> grid_shape(square, 1_000_000), grid_shape(square, 50_000)
    ((512, 512), (128, 128))
    """
    side = int(math.sqrt(count / PER_CELL)) // COARSE * COARSE
    cell = math.sqrt(region.area) / min(max(side, COARSE), CELLS)
    wide, deep = (min(max(round(length / cell), 1), 2 * CELLS) for length in region.sides)
    return deep, wide


@compile_to_disk
def count_within(position, low_x, low_y, high_x, high_y):
    """How many agents at `position` (N, 2) are in a region."""
    count = 0
    for i in range(len(position)):
        x, y = position[i, 0], position[i, 1]
        count += (x >= low_x) & (x < high_x) & (y >= low_y) & (y < high_y)
    return count


@compile_to_disk
def fill_extent(position, corners):
    """Move the corners (2, 2) of a region, the lower first, out to where agents (N, 2) are."""
    for i in range(len(position)):
        for axis in range(2):
            corners[0, axis] = min(corners[0, axis], position[i, axis])
            corners[1, axis] = max(corners[1, axis], position[i, axis])


@compile_to_disk
def fill_rows_within(position, low_x, low_y, high_x, high_y, rows):
    """Fill `rows` (M,) with those of the first M agents in a region; returns how many there are."""
    count = 0
    for i in range(len(position)):
        x, y = position[i, 0], position[i, 1]
        if x >= low_x and x < high_x and y >= low_y and y < high_y and count < len(rows):
            rows[count] = i
            count += 1
    return count


@compile_to_disk
def fill_sums(position, heading, low_x, low_y, wide, deep, sums):
    """Add to `sums` (rows, columns, 3) how many agents are in each cell, and the sum of their
    headings; the cells are `wide` and `deep`, from a lower corner on."""
    rows, columns, _ = sums.shape
    for i in range(len(position)):
        x, y = (position[i, 0] - low_x) / wide, (position[i, 1] - low_y) / deep
        if x >= 0.0 and x < columns and y >= 0.0 and y < rows:
            row, column = int(y), int(x)
            sums[row, column, 0] += 1.0
            sums[row, column, 1] += heading[i, 0]
            sums[row, column, 2] += heading[i, 1]


@compile_to_disk
def smooth_columns(sums, smoothed):
    """Smooth `sums` (rows, columns + 4, 3) along its rows by binomial weights into `smoothed`
    (rows, columns, 3)."""
    rows, columns, _ = smoothed.shape
    for row in range(rows):
        for column in range(columns):
            for k in range(3):
                smoothed[row, column, k] = (
                    6.0 * sums[row, column + 2, k]
                    + 4.0 * (sums[row, column + 1, k] + sums[row, column + 3, k])
                    + sums[row, column, k]
                    + sums[row, column + 4, k]
                ) / 16.0


@compiled
def local_order(number, x, y):
    """How much agents head the same way, in [0, 1]: 0 as by chance, 1 all alike.

    Their sum of headings is (x, y); `number` is how many there are in a smoothed cell, which stands
    for `WEIGHTS` squared as many agents. The mean of few random headings is long: what it is on
    average is taken off.
    """
    if number <= 0.0:
        return 0.0
    share = (x * x + y * y) / (number * number)
    met = number * WEIGHTS * WEIGHTS
    if met > 1.0:
        share = (share * met - 1.0) / (met - 1.0)
    return math.sqrt(min(max(share, 0.0), 1.0))


@compile_to_disk
def fill_pixels(sums, typical, table, pixels):
    """Fill `pixels` (rows, columns, 3), bytes, with the colours of smoothed sums, by the `table` of
    the palette."""
    rows, columns, _ = sums.shape
    strengths, orders, hues, _ = table.shape
    for row in range(rows):
        for column in range(columns):
            number = sums[row, column, 0]
            x, y = sums[row, column, 1], sums[row, column, 2]
            strength = number / (number + typical) if number > 0.0 else 0.0
            order = local_order(number, x, y)
            turn = math.atan2(y, x) / (2.0 * math.pi) if number > 0.0 else 0.0
            s = int(strength * (strengths - 1) + 0.5)
            o = int(order * (orders - 1) + 0.5)
            h = math.floor(turn * hues + 0.5) % hues
            for k in range(3):
                pixels[row, column, k] = table[s, o, h, k]
