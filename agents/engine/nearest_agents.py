"""The k nearest agents, whatever their distance: the topological range of Ballerini et al. 2008.

They are looked for in the cells around an agent's own, which are made so wide that they hold them
as a rule. Where the k-th is further off than those cells are sure to reach, everybody is looked at.
So the answer is exact, and dear only for agents that are far from the others.
"""

from __future__ import annotations

import math

from agents.engine.cells import copy_run, number_of
from worlds.compilation import compiled

SURE = 1.0 - 1e-9
"""Times the width of a cell: who is nearer is in the cells around, after any rounding."""


@compiled
def width_for(space, position, k):
    """Side (length) of cells that hold about k + 1 agents each; 0 where all are in one spot."""
    n, dim = position.shape
    volume = 1.0
    for axis in range(dim):
        if space.wraps[axis]:
            volume *= space.size[axis]
        else:
            low, high = math.inf, -math.inf
            for i in range(n):
                low = min(low, position[i, axis])
                high = max(high, position[i, axis])
            volume *= high - low
    wide = (volume * (k + 1.0) / n) ** (1.0 / dim)
    return wide if wide < math.inf else 0.0


@compiled
def covered_distance(grid, dim):
    """Distance (length) from an agent within which the cells around hold everybody."""
    smallest_side = math.inf
    for axis in range(dim):
        if grid.shape[axis] > 1:
            smallest_side = min(smallest_side, 1.0 / grid.inverse[axis])
    return SURE * smallest_side


@compiled
def rank(block, at, m, dim, me, k, distance2, nearest):
    """Which of the m agents of a block are the k nearest, nearest first; how many there are.

    Positions start at row `at` of the block. `nearest` receives their columns, `distance2`
    the squares of their distances; of two equally far the one that stands first. An agent in the
    same spot is no neighbour, as with a radius.
    """
    n = 0
    for j in range(m):
        dx, dy = block[at, j] - me.x, block[at + 1, j] - me.y
        d2 = dx * dx + dy * dy
        if dim == 3:
            dz = block[at + 2, j] - me.z
            d2 += dz * dz
        if not d2 > 0.0 or (n == k and d2 >= distance2[n - 1]):
            continue
        place = n if n < k else k - 1
        while place > 0 and distance2[place - 1] > d2:
            distance2[place] = distance2[place - 1]
            nearest[place] = nearest[place - 1]
            place -= 1
        distance2[place] = d2
        nearest[place] = j
        n = min(n + 1, k)
    return n


@compiled
def fill_all(grid, slots, block, signals):
    """Copy all agents that have not crashed into the block; how many."""
    return copy_run(slots, block, signals, 0, 0, grid.start[number_of(grid)], 0.0, 0.0, 0.0)


@compiled
def all_images(space, block, m, x, y, z, dim):
    """Rows 6 to 8 of the block: the image of each of m agents that is nearest to (x, y, z)."""
    for axis in range(dim):
        coordinate = x if axis == 0 else (y if axis == 1 else z)
        length = space.size[axis]
        for j in range(m):
            d = block[axis, j] - coordinate
            near = coordinate + (d - length * math.floor(d / length + 0.5))
            block[6 + axis, j] = near if space.images[axis] else block[axis, j]
