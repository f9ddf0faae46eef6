"""Where neighbours are, seen from an individual that moves, and how it turns by their places."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from agents.engine.cache import compile_to_disk
from agents.observables.array_checks import box, integers, length, numbers
from worlds.input_error import InputError


class NeighbourMap(NamedTuple):
    """Maps (B, B) about an individual that heads up: `[row, column]`, rows from behind to ahead,
    columns from left to right."""

    edges: np.ndarray
    """Of the cells along either axis, (B + 1,), length, from -reach to reach."""
    pairs: np.ndarray
    """How often a neighbour was in each cell, int."""
    individuals: int
    """Individuals with a place and a heading, over all frames."""
    turn: np.ndarray | None
    """The individual's mean turn to the left with a neighbour in each cell, in the unit of the
    turns given; NaN where nobody was."""
    turns: np.ndarray | None
    """How many turns each mean is of, int."""

    @property
    def density(self) -> np.ndarray:
        """Neighbours per area, 1/length^2: what N places at random in an area A have is (N - 1)/A
        everywhere."""
        area = (self.edges[1] - self.edges[0]) ** 2
        return self.pairs / (max(self.individuals, 1) * area)

    @property
    def odd_turn(self) -> np.ndarray | None:
        """The part of `turn` that is the other way for a neighbour on the other side.

        A flock that mills turns whatever is where: that part is the same on both sides, and not in
        this one. NaN where one of two cells that mirror each other has none.
        """
        return None if self.turn is None else (self.turn - self.turn[:, ::-1]) / 2.0


@compile_to_disk
def add_neighbours(x, y, ux, uy, turn, side, reach, pairs, counted, sums):
    """Add up neighbours and turns of frames: arrays are (T, N), NaN where there is none.

    `side` (2,) are the sides of the box along axes with images, 0 along others. `pairs`, `counted`
    and `sums` (B, B) are added to: neighbours, those beside a turn, and these turns. Returns how
    many individuals there were.
    """
    frames, n = x.shape
    bins = pairs.shape[0]
    per_length = bins / (2.0 * reach)
    turns_x = 1.0 / side[0] if side[0] > 0.0 else 0.0
    turns_y = 1.0 / side[1] if side[1] > 0.0 else 0.0
    individuals = 0
    for t in range(frames):
        for i in range(n):
            xi, yi, ci, si, turning = x[t, i], y[t, i], ux[t, i], uy[t, i], turn[t, i]
            total = xi + yi + ci + si
            if total != total:  # NaN, which fast mathematics lets `isfinite` overlook
                continue
            individuals += 1
            has_turn = turning == turning
            for j in range(n):
                dx, dy = x[t, j] - xi, y[t, j] - yi
                dx -= side[0] * math.floor(dx * turns_x + 0.5)
                dy -= side[1] * math.floor(dy * turns_y + 0.5)
                ahead, right = dx * ci + dy * si, dx * si - dy * ci
                # False for what is not seen: a comparison with NaN is
                if abs(ahead) < reach and abs(right) < reach and j != i:
                    row = min(int((ahead + reach) * per_length), bins - 1)
                    column = min(int((right + reach) * per_length), bins - 1)
                    pairs[row, column] += 1
                    if has_turn:
                        counted[row, column] += 1
                        sums[row, column] += turning
    return individuals


def neighbour_map(
    position: np.ndarray,
    heading: np.ndarray,
    size: np.ndarray,
    images: np.ndarray,
    reach: float,
    bins: int = 40,
    turn: np.ndarray | None = None,
) -> NeighbourMap:
    """Where others are about an individual, and how it turns by that (Katz et al. 2011).

    Parameters
    ----------
    position, heading: (N, 2) of one moment, or (T, N, 2), of which NaN is a gap: nobody is told.
        Headings are unit vectors.
    size: (2,) sides of the box > 0; images: (2,) bool, axes seen across the seam.
    reach: half the side of the map, length > 0; bins: cells along it, 2 to 400.
    turn: (N,) or (T, N), how each turns to the left, in any unit; None for a map without turns.

    Along an axis without images nobody is seen beyond the edge of what is tracked, so the map is
    thinner far out. Raises InputError.

    >>> abreast = np.array([[0.0, 0.0], [0.0, 1.0]])
    >>> east = np.array([[1.0, 0.0], [1.0, 0.0]])
    >>> left_and_right = neighbour_map(abreast, east, np.ones(2), np.zeros(2, bool), 1.5, 3)
    >>> left_and_right.pairs.tolist()
    [[0, 0, 0], [1, 0, 1], [0, 0, 0]]
    """
    position, heading = numbers("position", position), numbers("heading", heading)
    if position.ndim == 2 and heading.ndim == 2:
        position, heading = position[None], heading[None]
        turn = None if turn is None else numbers("turn", turn)[None]
    shape = position.shape
    if len(shape) != 3 or shape[2] != 2 or heading.shape != shape:
        raise InputError(
            f"position has shape {shape} and heading {heading.shape}: (T, N, 2) is needed for both"
        )
    turns = np.full(shape[:2], np.nan) if turn is None else numbers("turn", turn)
    if turns.shape != shape[:2]:
        raise InputError(f"turn has shape {turns.shape}: {shape[:2]} is needed")
    size, images = box(size, images, 2)
    reach = length("reach", reach, positive=True)
    bins = int(integers("bins", bins, 2, 401))
    squares = (heading**2).sum(axis=2)
    if (np.abs(squares[np.isfinite(squares)] - 1.0) > 0.04).any():
        raise InputError("heading has rows that are no unit vectors; nan for no direction")
    pairs, counted = np.zeros((bins, bins), np.int64), np.zeros((bins, bins), np.int64)
    sums = np.zeros((bins, bins))
    columns = [
        np.where(np.isfinite(a).all(axis=2), a[..., k], np.nan)
        for a in (position, heading)
        for k in (0, 1)
    ]
    turns = np.where(np.isfinite(turns), turns, np.nan)
    individuals = add_neighbours(
        *columns, turns, np.where(images, size, 0.0), reach, pairs, counted,
        sums,
    )  # fmt: skip
    edges = np.linspace(-reach, reach, bins + 1)
    mean = np.full((bins, bins), np.nan)
    np.divide(sums, counted, out=mean, where=counted > 0)
    return NeighbourMap(
        edges, pairs, int(individuals), *((None, None) if turn is None else (mean, counted))
    )
