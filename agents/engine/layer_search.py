"""Layers: how many hops an agent is from an information agent (Liu et al. 2021, section 2.1)."""

from __future__ import annotations

import math

from agents.engine.block import adjacent
from agents.engine.cells import cell_around
from worlds.compilation import compiled

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
def visit(space, grid, slots, slot, r, k, tail):
    """Give the unvisited neighbours of a slot the next layer and queue them; returns the tail."""
    layer = slots.signal[k]
    flat = slots.z.shape[0] == 0
    for c in range(27):
        cell, sx, sy, sz = cell_around(grid, space, slots.cell[slots.row[slot]], c)
        if cell < 0:
            continue
        for j in range(grid.start[cell], grid.start[cell + 1]):
            if layer[j] < UNKNOWN:
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
    lowest = UNKNOWN
    layer = near.signal[k]
    for j in range(near.n):
        if adjacent(me, near, j, r) > 0.0 and layer[j] < lowest:
            lowest = layer[j]
    return lowest + 1.0 if lowest < me.flock_size else UNKNOWN
