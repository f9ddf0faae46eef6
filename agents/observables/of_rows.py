"""Observables as compiled loops over a flock's arrays: what a page that runs by itself can measure.

Each takes arrays of the engine by the names of its arguments, `flock`, `space`, `surroundings`,
`context` and `tick` (`agents.engine.arrays`, `agents.engine.cells.Space`), and beside them

    together    the distance within which agents are of one group, length
    converges   whether the rule leads the flock to the information agent's heading
    cells       room for cell lists, `CellLists`
    caught      how many agents were caught so far

Rows of agents that have crashed, or that were caught and stand still, are left out. A value is that
of the observable of the same name, which is written in NumPy: tests hold one against the other.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba.core import types
from numba.core.extending import overload

from agents.observables.consistency import squared_angle
from agents.observables.order import EXACT, FEWEST
from worlds.compilation import compiled, entry
from worlds.queries.surroundings import set_goal


class CellLists(NamedTuple):
    """Room for lists of the agents of each cell; nothing of it is kept from call to call."""

    head: np.ndarray
    """First agent of each cell, int32 (cells,); -1: none."""
    after: np.ndarray
    """The next agent of the same cell, int32 (N,); -1: none."""
    parent: np.ndarray
    """An agent of the same group, int32 (N,); or its layer."""
    low: np.ndarray
    """Lower corner of the first cell, (3,), length."""
    width: np.ndarray
    """Sides of a cell, (3,), length."""
    counts: np.ndarray
    """Cells along each axis, int64 (3,)."""


def empty_cells(agents: int) -> CellLists:
    """Room for the cells of so many agents."""
    return CellLists(
        np.zeros(2 * agents + 8, np.int32),
        np.zeros(agents, np.int32),
        np.zeros(agents, np.int32),
        np.zeros(3),
        np.zeros(3),
        np.zeros(3, np.int64),
    )


NOT_ASKED = np.empty(0, np.bool_)
"""In place of `Arrays.kind` where there are no kinds: nothing of them is then in compiled code."""


def is_caught(kind, i):
    """Whether agent i stands still because it was caught; see `Arrays.kind`."""
    return kind.shape[0] > 0 and kind[i] < 0.0


@overload(is_caught)
def is_caught_compiled(kind, i):  # noqa: ARG001
    """The same, or False where nobody asks."""
    if kind.dtype == types.boolean:
        return lambda kind, i: False  # noqa: ARG005
    return lambda kind, i: kind.shape[0] > 0 and kind[i] < 0.0


@compiled
def is_active(flock, i):
    """Whether agent i has not crashed, and does not stand still because it was caught."""
    flies = flock.crash_record.shape[0] == 0 or flock.crash_record[i, 0] < 0.0
    return flies and not is_caught(flock.kind, i)


def are_of_one_kind(kind, i, j):
    """Whether agents i and j are of the same kind; see `Arrays.kind`."""
    return kind.shape[0] == 0 or kind[i] == kind[j]


@overload(are_of_one_kind)
def are_of_one_kind_compiled(kind, i, j):  # noqa: ARG001
    """The same, or True where nobody asks."""
    if kind.dtype == types.boolean:
        return lambda kind, i, j: True  # noqa: ARG005
    return lambda kind, i, j: kind.shape[0] == 0 or kind[i] == kind[j]


@compiled
def active_count(flock):
    """How many agents have not crashed."""
    count = 0
    for i in range(flock.position.shape[0]):
        count += 1 if is_active(flock, i) else 0
    return count


@compiled
def heading_sum(flock):
    """The sum of the headings, (x, y, z), and how many agents there are."""
    x = y = z = 0.0
    count = 0
    for i in range(flock.heading.shape[0]):
        if is_active(flock, i):
            count += 1
            x += flock.heading[i, 0]
            y += flock.heading[i, 1]
            if flock.heading.shape[1] == 3:
                z += flock.heading[i, 2]
    return x, y, z, count


@entry
def polarisation(flock):
    """The length of the mean heading; see `agents.observables.order.polarisation`."""
    x, y, z, count = heading_sum(flock)
    return min(1.0, math.sqrt(x * x + y * y + z * z) / count) if count > 0 else 0.0


@entry
def direction(flock):
    """The angle of the mean heading to the x axis, deg; see `agents.observables.order`."""
    x, y, z, count = heading_sum(flock)
    if math.sqrt(x * x + y * y + z * z) <= 4 * count * count * EXACT:
        return math.nan
    return math.degrees(math.atan2(math.sqrt(y * y + z * z), x))


@entry
def consistency(flock, converges):
    """The degree of consistency; see `agents.observables.consistency.consistency`."""
    x, y, z, count = heading_sum(flock)
    length = math.sqrt(x * x + y * y + z * z)
    if count == 0:
        return 1.0
    if length < 1e-12:
        x, y, z, length = 1.0, 0.0, 0.0, 1.0
    x, y, z = x / length, y / length, z / length
    leaders = 0
    for i in range(flock.heading.shape[0]):
        if converges and leaders == 0 and flock.informed[i] and is_active(flock, i):
            leaders = 1
            x, y = flock.heading[i, 0], flock.heading[i, 1]
            z = flock.heading[i, 2] if flock.heading.shape[1] == 3 else 0.0
    total = 0.0
    for i in range(flock.heading.shape[0]):
        if is_active(flock, i):
            total += squared_angle(flock.heading, i, x, y, z)
    return 1.0 - math.sqrt(total) / (count * math.pi)


@compiled
def strip_balance(flock, y, half, side, wraps):
    """Agents from y - half on and below y + half: how many more head for +x than for -x, and how
    many there are, with images where the axis wraps."""
    more = number = 0
    for j in range(flock.position.shape[0]):
        if is_active(flock, j):
            apart = flock.position[j, 1] - y
            if wraps:
                apart -= side * math.floor((apart + half) / side)
            if -half <= apart < half:
                number += 1
                more += 1 if flock.heading[j, 0] >= 0.0 else -1
    return more, number


@entry
def lane_order(flock, space):
    """How far those who pass each other keep apart; see `agents.observables.lanes.lane_order`."""
    count = active_count(flock)
    if count == 0:
        return 0.0
    side, wraps = space.size[1], space.images[1] != 0
    half = 0.25 * math.sqrt(space.size[0] * side / count)
    if wraps:
        half = min(half, 0.5 * side)
    total = 0.0
    for i in range(flock.position.shape[0]):
        if is_active(flock, i):
            more, number = strip_balance(flock, flock.position[i, 1], half, side, wraps)
            total += (more / number) ** 2
    return total / count


@compiled
def centre_along(flock, space, axis, count):
    """The centre of the agents along an axis, length: with images the mean on the circle."""
    mean = sine = cosine = 0.0
    size = space.size[axis]
    for i in range(flock.position.shape[0]):
        if is_active(flock, i):
            at = flock.position[i, axis]
            mean += at
            if space.images[axis] != 0:
                sine += math.sin(2.0 * math.pi * at / size)
                cosine += math.cos(2.0 * math.pi * at / size)
    if space.images[axis] == 0:
        return mean / count
    turn = math.atan2(sine / count, cosine / count)
    return (turn if turn >= 0.0 else turn + 2.0 * math.pi) / (2.0 * math.pi) * size


@compiled
def nearest_image(apart, space, axis):
    """A difference along an axis as it is to the nearest image, length."""
    if space.images[axis] == 0:
        return apart
    return apart - space.size[axis] * np.rint(apart / space.size[axis])


@compiled
def offset_from(flock, space, i, x, y, z):
    """How far agent i is from a place, (x, y, z), length, by the nearest image."""
    dx = nearest_image(flock.position[i, 0] - x, space, 0)
    dy = nearest_image(flock.position[i, 1] - y, space, 1)
    dz = 0.0
    if flock.position.shape[1] == 3:
        dz = nearest_image(flock.position[i, 2] - z, space, 2)
    return dx, dy, dz


@compiled
def centre(flock, space, count):
    """The centre of the agents, (x, y, z), length."""
    x = centre_along(flock, space, 0, count)
    y = centre_along(flock, space, 1, count)
    z = centre_along(flock, space, 2, count) if flock.position.shape[1] == 3 else 0.0
    return x, y, z


@entry
def angular_momentum(flock, space):
    """How much the flock mills; see `agents.observables.order.angular_momentum`."""
    count = active_count(flock)
    if count == 0:
        return 0.0
    x, y, z = centre(flock, space, count)
    largest = 0.0
    for i in range(flock.position.shape[0]):
        if is_active(flock, i):
            for axis in range(flock.position.shape[1]):
                largest = max(largest, abs(flock.position[i, axis]))
    for axis in range(flock.position.shape[1]):
        if space.images[axis] != 0:
            largest = max(largest, space.size[axis])
    error = (64 + count) * EXACT * largest
    a = b = c = 0.0
    for i in range(flock.position.shape[0]):
        if is_active(flock, i):
            dx, dy, dz = offset_from(flock, space, i, x, y, z)
            distance = math.sqrt(dx * dx + dy * dy + dz * dz)
            if distance > error:
                ux, uy = flock.heading[i, 0], flock.heading[i, 1]
                uz = flock.heading[i, 2] if flock.heading.shape[1] == 3 else 0.0
                a += (dy * uz - dz * uy) / distance
                b += (dz * ux - dx * uz) / distance
                c += (dx * uy - dy * ux) / distance
    return min(1.0, math.sqrt(a * a + b * b + c * c) / count)


@entry
def gyration_radius(flock, space):
    """How far the agents are from their centre; see `agents.observables.order.gyration_radius`."""
    count = active_count(flock)
    if count < 2:
        return 0.0
    x, y, z = centre(flock, space, count)
    total = 0.0
    for i in range(flock.position.shape[0]):
        if is_active(flock, i):
            dx, dy, dz = offset_from(flock, space, i, x, y, z)
            total += dx * dx + dy * dy + dz * dz
    return math.sqrt(total / count)


@entry
def velocity_spread(flock):
    """How far velocities differ; see `agents.observables.order.velocity_spread`."""
    count = active_count(flock)
    if count == 0:
        return 0.0
    total = 0.0
    for axis in range(flock.heading.shape[1]):
        mean = 0.0
        for i in range(flock.heading.shape[0]):
            if is_active(flock, i):
                mean += flock.heading[i, axis] * flock.speed[i]
        mean /= count
        for i in range(flock.heading.shape[0]):
            if is_active(flock, i):
                off = flock.heading[i, axis] * flock.speed[i] - mean
                total += off * off
    return math.sqrt(total / count)


@entry
def crashes(flock):
    """How many agents have crashed so far."""
    count = 0.0
    for i in range(flock.crash_record.shape[0]):
        count += 1.0 if flock.crash_record[i, 0] >= 0.0 else 0.0
    return count


@entry
def catches(caught):
    """How many agents were caught so far: the page counts them."""
    return caught


@entry
def goal_distance(flock, surroundings, context, tick):
    """How far the flock's centre is from the goal, or from the end of the path, length."""
    count = active_count(flock)
    if count == 0:
        return math.nan
    set_goal(surroundings, tick * context.lasts)
    total = 0.0
    for axis in range(flock.position.shape[1]):
        mean = 0.0
        for i in range(flock.position.shape[0]):
            if is_active(flock, i):
                mean += flock.position[i, axis]
        if surroundings.route.shape[0] > 0:
            end = surroundings.goal[0, axis]
        else:
            end = surroundings.path[surroundings.path.shape[0] - 1, axis]
        off = mean / count - end
        total += off * off
    return math.sqrt(total)


# Cell lists: who is near whom, without a look at every pair.


@compiled
def cells_within(cells, dim, width, extent):
    """How many cells of a width fill a box of sides `extent`, and their counts along the axes."""
    total = 1.0
    for axis in range(dim):
        sides = max(1.0, math.floor(extent[axis] / width))
        cells.counts[axis] = int(min(sides, 1e6))
        total *= sides
    return total


@compiled
def measure_box(flock, space, cells):
    """Write the box of the agents: along axes with images the world's; returns its largest side."""
    largest = 0.0
    for axis in range(flock.position.shape[1]):
        low, high = math.inf, -math.inf
        for i in range(flock.position.shape[0]):
            if is_active(flock, i):
                low = min(low, flock.position[i, axis])
                high = max(high, flock.position[i, axis])
        if space.images[axis] != 0:
            low, high = 0.0, space.size[axis]
        elif low > high:  # nobody is there
            low = high = 0.0
        cells.low[axis] = low
        cells.width[axis] = high - low
        largest = max(largest, high - low)
    return largest


@compiled
def cell_along(flock, space, cells, i, axis):
    """The cell of agent i along an axis."""
    at = flock.position[i, axis] - cells.low[axis]
    if space.images[axis] != 0:
        at -= space.size[axis] * math.floor(at / space.size[axis])
    found = int(at / cells.width[axis]) if cells.width[axis] > 0.0 else 0
    return min(max(found, 0), cells.counts[axis] - 1)


@compiled
def cell_of(flock, space, cells, i):
    """The number of agent i's cell."""
    found = 0
    for axis in range(flock.position.shape[1]):
        found = found * cells.counts[axis] + cell_along(flock, space, cells, i, axis)
    return found


@compiled
def list_cells(flock, space, cells, least, most):
    """List the agents of each cell: cells of a width from `least` on, and at most so many."""
    dim = flock.position.shape[1]
    largest = measure_box(flock, space, cells)
    width = max(least, 1e-9 * largest)
    if width > 0.0:
        while cells_within(cells, dim, width, cells.width) > most:
            width *= 1.25
    else:
        for axis in range(dim):
            cells.counts[axis] = 1
    total = 1
    for axis in range(dim):
        cells.width[axis] /= cells.counts[axis]
        total *= cells.counts[axis]
    for cell in range(total):
        cells.head[cell] = -1
    for i in range(flock.position.shape[0]):
        if is_active(flock, i):
            cell = cell_of(flock, space, cells, i)
            cells.after[i] = cells.head[cell]
            cells.head[cell] = i


@compiled
def first_step(space, cells, axis, at, around):
    """The first of the cells along an axis that are at most `around` cells away, each once."""
    if space.images[axis] == 0:
        return max(0, at - around)
    return 0 if 2 * around + 1 >= cells.counts[axis] else at - around


@compiled
def last_step(space, cells, axis, at, around):
    """The last of these; see `first_step`."""
    if space.images[axis] == 0:
        return min(cells.counts[axis] - 1, at + around)
    return cells.counts[axis] - 1 if 2 * around + 1 >= cells.counts[axis] else at + around


@compiled
def squared_distance(flock, space, i, j):
    """Squared distance of two agents, by the nearest image."""
    z = flock.position[j, 2] if flock.position.shape[1] == 3 else 0.0
    dx, dy, dz = offset_from(flock, space, i, flock.position[j, 0], flock.position[j, 1], z)
    return dx * dx + dy * dy + dz * dz


@compiled
def root(parent, i):
    """The agent that stands for the group of agent i; halves the way there."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


NEAREST, COUNTED, JOINED, LAYERED, MIXED = 0, 1, 2, 3, 4
"""What is made of the pairs of two cells: the least distance, how many are near, one group, or
layers that are at most one apart; of these, how many pairs were not so. Or how many are near that
are of two kinds."""


@compiled
def take_pair(flock, space, cells, i, j, limit, what, found):
    """What a pair adds to what was found."""
    if what == JOINED and root(cells.parent, i) == root(cells.parent, j):
        return found
    squared = squared_distance(flock, space, i, j)
    if what == NEAREST:
        return min(found, squared)
    if 0.0 < squared <= limit:
        if what == MIXED and are_of_one_kind(flock.kind, i, j):
            return found
        if what == LAYERED:
            below = min(cells.parent[i], cells.parent[j]) + 1
            if max(cells.parent[i], cells.parent[j]) <= below:
                return found
            cells.parent[i] = min(cells.parent[i], below)
            cells.parent[j] = min(cells.parent[j], below)
        found += 1.0
        if what == JOINED:
            a, b = root(cells.parent, i), root(cells.parent, j)
            cells.parent[max(a, b)] = min(a, b)
    return found


@compiled
def take_pairs(flock, space, cells, around, limit, what, found):
    """Go over all pairs whose cells are at most `around` cells apart."""
    dim = flock.position.shape[1]
    for i in range(flock.position.shape[0]):
        if not is_active(flock, i):
            continue
        x, y = cell_along(flock, space, cells, i, 0), cell_along(flock, space, cells, i, 1)
        z = cell_along(flock, space, cells, i, 2) if dim == 3 else 0
        first, last = 0, 0
        if dim == 3:
            first = first_step(space, cells, 2, z, around)
            last = last_step(space, cells, 2, z, around)
        columns, rows = cells.counts[0], cells.counts[1]
        layers = cells.counts[2] if dim == 3 else 1
        for a in range(
            first_step(space, cells, 0, x, around), last_step(space, cells, 0, x, around) + 1
        ):
            for b in range(
                first_step(space, cells, 1, y, around), last_step(space, cells, 1, y, around) + 1
            ):
                for c in range(first, last + 1):
                    cell = ((a + columns) % columns * rows + (b + rows) % rows) * layers
                    j = cells.head[cell + (c + layers) % layers]
                    while j >= 0:
                        if j < i:
                            found = take_pair(flock, space, cells, i, j, limit, what, found)
                        j = cells.after[j]
    return found


@entry
def nearest_neighbour(flock, space, cells):
    """The least distance between two agents, length; infinite for a lone agent."""
    count = active_count(flock)
    if count < 2:
        return math.inf
    # With fewer cells than agents two are in one cell: the nearest two are at most its diagonal
    # apart.
    list_cells(flock, space, cells, 0.0, max(1, count // 2))
    squared = 0.0
    for axis in range(flock.position.shape[1]):
        squared += cells.width[axis] * cells.width[axis]
    around = 1
    for axis in range(flock.position.shape[1]):
        if cells.counts[axis] > 1:
            around = max(around, int(math.sqrt(squared) / cells.width[axis]) + 1)
    return math.sqrt(take_pairs(flock, space, cells, around, 0.0, NEAREST, math.inf))


@entry
def mean_neighbours(flock, space, context, cells):
    """How many agents are within reach of one, mean."""
    count = active_count(flock)
    if count == 0:
        return 0.0
    reach = context.reach
    list_cells(flock, space, cells, reach, cells.head.shape[0])
    return 2.0 * take_pairs(flock, space, cells, 1, reach * reach, COUNTED, 0.0) / count


@compiled
def join_groups(flock, space, cells, together):
    """Have `cells.parent` tell the group of each agent: the least row of it."""
    for i in range(flock.position.shape[0]):
        cells.parent[i] = i
    list_cells(flock, space, cells, together, cells.head.shape[0])
    take_pairs(flock, space, cells, 1, together * together, JOINED, 0.0)


@entry
def groups(flock, space, together, cells):
    """How many connected groups there are."""
    join_groups(flock, space, cells, together)
    found = 0.0
    for i in range(flock.position.shape[0]):
        found += 1.0 if is_active(flock, i) and root(cells.parent, i) == i else 0.0
    return found


@entry
def largest_group(flock, space, together, cells):
    """How many agents the largest group has."""
    join_groups(flock, space, cells, together)
    for i in range(flock.position.shape[0]):
        cells.after[i] = 0
    largest = 0
    for i in range(flock.position.shape[0]):
        if is_active(flock, i):
            of = root(cells.parent, i)
            cells.after[of] += 1
            largest = max(largest, cells.after[of])
    return float(largest)


@entry
def layers(flock, space, context, cells):
    """Have `cells.parent` tell the layer of each agent, 1 an information agent, N + 1 unknown.

    See `agents.observables.neighbours.layers`. Returns how many agents have one.
    """
    agents = flock.position.shape[0]
    for i in range(agents):
        cells.parent[i] = 1 if flock.informed[i] and is_active(flock, i) else agents + 1
    reach = context.reach
    list_cells(flock, space, cells, reach, cells.head.shape[0])
    while take_pairs(flock, space, cells, 1, reach * reach, LAYERED, 0.0) > 0.0:
        pass
    known = 0.0
    for i in range(agents):
        known += 1.0 if cells.parent[i] <= agents else 0.0
    return known


# Agents of several kinds, and how fast each is.


@entry
def kind_distance(flock, space):
    """How far the nearest of another kind is, mean; see `agents.observables.of_flocks`.

    All pairs are looked at: the nearest may be as far away as the world is wide.
    """
    total, count = 0.0, 0
    for i in range(flock.position.shape[0]):
        if not is_active(flock, i):
            continue
        least = math.inf
        for j in range(flock.position.shape[0]):
            if is_active(flock, j) and not are_of_one_kind(flock.kind, i, j):
                least = min(least, squared_distance(flock, space, i, j))
        if least == math.inf:  # all are of one kind
            return math.nan
        total += math.sqrt(least)
        count += 1
    return total / count if count > 0 else math.nan


@entry
def kind_mixing(flock, space, context, cells):
    """The share of pairs within reach that are of two kinds."""
    first, has_others = -1, False
    for i in range(flock.position.shape[0]):
        if is_active(flock, i):
            first = i if first < 0 else first
            has_others = has_others or not are_of_one_kind(flock.kind, first, i)
    reach = context.reach
    list_cells(flock, space, cells, reach, cells.head.shape[0])
    pairs = take_pairs(flock, space, cells, 1, reach * reach, COUNTED, 0.0)
    if not has_others or pairs == 0.0:
        return math.nan
    return take_pairs(flock, space, cells, 1, reach * reach, MIXED, 0.0) / pairs


@compiled
def velocity_length(flock, i):
    """How fast agent i is, by the length of its velocity."""
    squared = 0.0
    for axis in range(flock.heading.shape[1]):
        along = flock.heading[i, axis] * flock.speed[i]
        squared += along * along
    return math.sqrt(squared)


@compiled
def place_key(flock, space, i, middle, way):
    """How far agent i is in front of a place `middle`, along a vector `way`."""
    dx, dy, dz = offset_from(flock, space, i, middle[0], middle[1], middle[2])
    return dx * way[0] + dy * way[1] + dz * way[2]


@compiled
def front_key(flock, space, i, middle, way, fastest):
    """What agents are ranked by: their speed where somebody is the fastest, else their place."""
    if fastest > 0.0:
        # The length of a vector is rounded: who is as fast as another has the same rank.
        return np.rint(velocity_length(flock, i) / fastest * 1e12)
    return place_key(flock, space, i, middle, way)


@compiled
def sift_down(flock, space, order, top, end, middle, way, fastest):
    """Let the row at `top` of a heap sink until none below it has a larger key."""
    row = order[top]
    key = front_key(flock, space, row, middle, way, fastest)
    below = 2 * top + 1
    while below < end:
        low_key = front_key(flock, space, order[below], middle, way, fastest)
        if below + 1 < end:
            other_key = front_key(flock, space, order[below + 1], middle, way, fastest)
            if other_key > low_key:
                below, low_key = below + 1, other_key
        if low_key <= key:
            break
        order[top] = order[below]
        top, below = below, 2 * below + 1
    order[top] = row


@compiled
def rank_rows(flock, space, order, count, ranks, first, middle, way, fastest):
    """Sort the first `count` rows of `order` by their keys, and write twice their ranks, from 1 on,
    to `ranks[first + row]`; equal ones have the mean of theirs. Returns whether some differ."""
    for top in range(count // 2 - 1, -1, -1):
        sift_down(flock, space, order, top, count, middle, way, fastest)
    for end in range(count - 1, 0, -1):
        order[0], order[end] = order[end], order[0]
        sift_down(flock, space, order, 0, end, middle, way, fastest)
    begin = 0
    while begin < count:
        key = front_key(flock, space, order[begin], middle, way, fastest)
        end = begin + 1
        while end < count and front_key(flock, space, order[end], middle, way, fastest) == key:
            end += 1
        for at in range(begin, end):
            ranks[first + order[at]] = begin + 1 + end
        if begin == 0 and end == count:
            return False
        begin = end
    return True


@entry
def fast_in_front(flock, space, cells):
    """Whether the faster ones are in front; see `agents.observables.order.fast_in_front`."""
    n, order, ranks = flock.position.shape[0], cells.parent, cells.head
    count, fastest = 0, 0.0
    x = y = z = 0.0
    for i in range(n):
        if is_active(flock, i):
            order[count] = i
            count += 1
            fastest = max(fastest, velocity_length(flock, i))
            x += flock.heading[i, 0] * flock.speed[i]
            y += flock.heading[i, 1] * flock.speed[i]
            if flock.heading.shape[1] == 3:
                z += flock.heading[i, 2] * flock.speed[i]
    length = math.sqrt(x * x + y * y + z * z)
    if count < FEWEST or length <= 4 * count * count * EXACT * fastest:
        return math.nan
    middle, way = centre(flock, space, count), (x / length, y / length, z / length)
    if not rank_rows(flock, space, order, count, ranks, 0, middle, way, fastest):
        return math.nan
    if not rank_rows(flock, space, order, count, ranks, n, middle, way, 0.0):
        return math.nan
    product = squares = other_squares = 0.0
    for at in range(count):
        one, other = ranks[order[at]] - count - 1.0, ranks[n + order[at]] - count - 1.0
        product += one * other
        squares += one * one
        other_squares += other * other
    return max(-1.0, min(1.0, product / math.sqrt(squares * other_squares)))
