"""Search beyond an agent's reach: the k nearest agents, and the hops from information agents.

The k nearest, whatever their distance, are the topological range of Ballerini et al. 2008. They are
looked for in the cells around an agent's own, which are made so wide that they hold them as a rule.
Where the k-th is further off than those cells are sure to reach, everybody is looked at; eight at
once first look at more rings of cells. So the answer is exact, and dear only for agents that are
far from the others. Of those equally far the first in the order of cells are the nearest.

Layers are the hops from an information agent (Liu et al. 2021, section 2.1).
"""

from __future__ import annotations

import math

from agents.engine.block import is_neighbour, neighbour_of
from agents.engine.cells import cell_around, copy_run, number_of
from agents.engine.eight_others import eight_from, is_there, least, no_lanes, width
from agents.engine.vector_lanes import load, store, where
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
def holds_rings(grid, space, dim, rings):
    """Whether so many rings of cells around one are cells of their own, across seams too."""
    fits = True
    for axis in range(dim):
        is_seam = space.images[axis] and grid.shape[axis] > 1
        fits = fits and not (is_seam and grid.shape[axis] < 2 * rings + 1)
    return fits


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
def begin_least(least, k, seeking):
    """Nothing is found yet of the k nearest of eight agents, those of them that are `seeking`.

    `least` (k, 8) are the squares of their distances so far, in order, inf where there is none.
    """
    for place in range(k):
        store(least, place, where(seeking, math.inf, no_lanes() - 1.0))


@compiled
def keep_least(least, k, d2):
    """Keep the k least squares of distances of eight agents, those of one other with them."""
    for place in range(k):
        kept = load(least[place], 0)
        store(least, place, min(kept, d2))
        d2 = max(kept, d2)


@compiled
def count_ties(least, k):
    """How many of the k nearest of eight agents are as far from each as the last of them."""
    limit2 = load(least[k - 1], 0)
    ties = no_lanes()
    for place in range(k):
        ties += where(load(least[place], 0) == limit2, 1.0, no_lanes())
    return ties


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


# Layers: how many hops an agent is from an information agent.


UNKNOWN = math.inf
"""The layer of an agent that no information agent reaches."""


@compiled
def separation(space, grid, axis, d):
    """d along an axis of a single cell, to the nearest image if the world shows images."""
    if space.images[axis] and grid.shape[axis] == 1:
        length = space.size[axis]
        return d - length * math.floor(d / length + 0.5)
    return d


@compiled
def is_heeded(slots, j, slot):
    """Whether the agent of a slot is a neighbour of that of slot j, as far as kinds go."""
    if slots.kind.shape[0] == 0:
        return True
    kind, other = int(slots.kind[j]), int(slots.kind[slot])
    return kind >= 0 and other >= 0 and slots.heeds[kind, other] > 0.0


@compiled
def visit(space, grid, slots, slot, r, k, tail):
    """Give the unvisited neighbours of a slot the next layer and queue them; returns the tail."""
    layer = slots.signal[k]
    flat = slots.z.shape[0] == 0
    for c in range(27):
        cell, sx, sy, sz = cell_around(grid, space, slots.cell[slots.row[slot]], c)
        if cell < 0:
            continue
        for j in range(grid.start[cell], grid.start[cell + 1]):
            if layer[j] < UNKNOWN or not is_heeded(slots, j, slot):
                continue
            dx = separation(space, grid, 0, slots.x[j] + sx - slots.x[slot])
            dy = separation(space, grid, 1, slots.y[j] + sy - slots.y[slot])
            d2 = dx * dx + dy * dy
            if not flat:
                dz = separation(space, grid, 2, slots.z[j] + sz - slots.z[slot])
                d2 += dz * dz
            if 0.0 < d2 <= r * r:
                layer[j] = layer[slot] + 1.0
                slots.queue[tail] = j
                tail += 1
    return tail


@compiled
def search_layers(flock, space, grid, slots, r, k, depth):
    """Layers (4) by breadth-first search from the information agents, into signal k of the slots.

    Information agents are layer 1; the search stops at layer `depth`; all others get UNKNOWN.
    """
    n = slots.row.shape[0]
    tail = 0
    for slot in range(n):
        if flock.informed[slots.row[slot]]:
            slots.signal[k, slot] = 1.0
            slots.queue[tail] = slot
            tail += 1
        else:
            slots.signal[k, slot] = UNKNOWN
    at = 0
    while at < tail:
        slot = slots.queue[at]
        at += 1
        if slots.signal[k, slot] < depth:
            tail = visit(space, grid, slots, slot, r, k, tail)


@compiled
def next_layer(me, near, r, k):
    """l_i(k+1) = 1 + min l_j(k) over the neighbours (5); above N it is UNKNOWN.

    No agent of a flock of N can be in a layer above N: without this cap the layers of a group that
    is cut off would count up for ever.
    """
    if me.informed:
        return 1.0
    lowest = least_layer(me, near, r, k)
    return lowest + 1.0 if lowest < me.flock_size else UNKNOWN


@compiled
def least_layer(me, near, r, k):
    """The least layer among the neighbours, signal k, or UNKNOWN."""
    lowest = no_lanes() + UNKNOWN
    for first in range(0, near.n, width()):
        j = eight_from(first, near.n)
        is_near = is_there(j) & is_neighbour(neighbour_of(me, near, j), r)
        lowest = min(lowest, where(is_near, near.signal[k, j], UNKNOWN))
    return least(lowest)
