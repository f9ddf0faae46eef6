"""Tell whether one place can be seen from another, past the obstacles."""

from __future__ import annotations

import math

from worlds.compilation import compiled
from worlds.queries.surface import entry_distance, nearest_solid

SLACK = 1e-9
"""Share of a cell by which rows and columns are taken wider, so that rounding hides no edge."""
ENDS = 1e-12
"""Share of its radius by which an arc is taken longer, so that there is no gap where two meet."""


@compiled
def arc_shares(at, ax, ay, dx, dy):
    """The shares at which the way from a along d meets the circle of an arc, inf for none."""
    wx, wy = ax - at[8], ay - at[9]
    r = math.fabs(at[10])
    b = wx * dx + wy * dy
    d2 = dx * dx + dy * dy
    out = math.sqrt(wx * wx + wy * wy)
    c = (out - r) * (out + r)
    root = b * b - d2 * c
    if root < 0.0 or d2 == 0.0:
        return math.inf, math.inf
    q = -(b + math.copysign(math.sqrt(root), b))
    first_share, second_share = q / d2, c / q if q != 0.0 else 0.0
    return min(first_share, second_share), max(first_share, second_share)


@compiled
def is_on_arc(at, wx, wy, close):
    """Whether a place w from its circle's centre, on the circle, is on an arc or `close` to it."""
    past_begin = (at[0] - at[8]) * wy - (at[1] - at[9]) * wx
    before_end = wx * (at[3] - at[9]) - wy * (at[2] - at[8])
    sign = math.copysign(1.0, at[10])
    tolerance = -close * math.fabs(at[10])
    return (sign * past_begin >= tolerance) & (sign * before_end >= tolerance)


@compiled
def meets_arc(at, bottom, top, ax, ay, az, dx, dy, dz):
    """Whether the way from a along d goes through the upright face of an arc, its ends included."""
    share_a, share_b = arc_shares(at, ax, ay, dx, dy)
    for t in (share_a, share_b):
        if 0.0 <= t <= 1.0 and bottom <= az + t * dz <= top:
            x, y = ax + t * dx, ay + t * dy
            if is_on_arc(at, x - at[8], y - at[9], ENDS * math.fabs(at[10])):
                return True
    return False


@compiled
def meets_edges(surroundings, entry, bottom, top, ax, ay, az, dx, dy, dz):
    """Whether the way from a along d goes through an upright face of an outline in a cell."""
    for run in range(surroundings.entry_run[entry], surroundings.entry_run[entry + 1]):
        for i in range(surroundings.run[run, 0], surroundings.run[run, 1]):
            at = surroundings.edge[i]
            if at[10] != 0.0:
                if meets_arc(at, bottom, top, ax, ay, az, dx, dy, dz):
                    return True
                continue
            ex, ey = at[2] - at[0], at[3] - at[1]
            wx, wy = at[0] - ax, at[1] - ay
            turn = dx * ey - dy * ex
            if turn != 0.0:
                t = (wx * ey - wy * ex) / turn
                u = (wx * dy - wy * dx) / turn
                z = az + t * dz
                if 0.0 <= t <= 1.0 and 0.0 <= u <= 1.0 and bottom <= z <= top:
                    return True
    return False


@compiled
def meets_cap(surroundings, entry, height, low, high, ax, ay, az, dx, dy, dz):
    """Whether the way goes through the top or bottom face of a prism, within shares [low, high]."""
    t = (height - az) / dz
    if not (low <= t <= high):
        return False
    d, _, _ = entry_distance(surroundings, entry, ax + t * dx, ay + t * dy, height)
    return d <= 0.0


@compiled
def meets_ball(ball, ax, ay, az, dx, dy, dz):
    """Whether the way from a along d comes within a sphere."""
    wx, wy, wz = ball[0] - ax, ball[1] - ay, ball[2] - az
    length2 = dx * dx + dy * dy + dz * dz
    t = (wx * dx + wy * dy + wz * dz) / length2 if length2 > 0.0 else 0.0
    t = min(max(t, 0.0), 1.0)
    wx, wy, wz = wx - t * dx, wy - t * dy, wz - t * dz
    return wx * wx + wy * wy + wz * wz <= ball[3] * ball[3]


@compiled
def meets_entry(surroundings, entry, low, high, ax, ay, az, dx, dy, dz):
    """Whether the way meets a solid listed in a cell that it crosses at the shares [low, high]."""
    solid = surroundings.entry_solid[entry]
    outlines = surroundings.span.shape[0]
    if solid >= outlines:
        return meets_ball(surroundings.ball[solid - outlines], ax, ay, az, dx, dy, dz)
    bottom, top = surroundings.span[solid, 0], surroundings.span[solid, 1]
    if meets_edges(surroundings, entry, bottom, top, ax, ay, az, dx, dy, dz):
        return True
    if dz == 0.0:
        return False
    return meets_cap(surroundings, entry, bottom, low, high, ax, ay, az, dx, dy, dz) or meets_cap(
        surroundings, entry, top, low, high, ax, ay, az, dx, dy, dz
    )


@compiled
def shares_within(a, d, low, high):
    """The shares of the way from a along d (one axis) that lie in [low, high], within [0, 1]."""
    if d == 0.0:
        return (0.0, 1.0) if low <= a <= high else (1.0, 0.0)
    share_a, share_b = (low - a) / d, (high - a) / d
    return max(0.0, min(share_a, share_b)), min(1.0, max(share_a, share_b))


@compiled
def cells_between(low, high, origin, inverse, number):
    """First and last cell along an axis that the interval [low, high] touches."""
    first = max(math.floor((low - origin) * inverse - SLACK), 0.0)
    last = min(math.floor((high - origin) * inverse + SLACK), number - 1.0)
    return int(min(first, 2.0**30)), int(max(last, -1.0))


@compiled
def line_of_sight(surroundings, ax, ay, az, bx, by, bz):
    """Whether the segment from a to b meets no obstacle (solid edges of the box are none).

    Looks into the cells along the segment, row by row. A segment inside an obstacle meets it.
    """
    if surroundings.columns == 0:
        return True
    planes = surroundings.plane.shape[0]
    d, _, entry, _, _ = nearest_solid(surroundings, ax, ay, az, planes, 0.0)
    if entry >= 0 and d < 0.0:
        return False
    dx, dy, dz = bx - ax, by - ay, bz - az
    side = 1.0 / surroundings.inverse
    slack = SLACK * side
    first, last = cells_between(
        min(ay, by), max(ay, by), surroundings.front, surroundings.inverse, surroundings.rows
    )
    for row in range(first, last + 1):
        front = surroundings.front + row * side
        low, high = shares_within(ay, dy, front - slack, front + side + slack)
        if low > high:
            continue
        x_low, x_high = ax + low * dx, ax + high * dx
        left, right = cells_between(
            min(x_low, x_high),
            max(x_low, x_high),
            surroundings.left,
            surroundings.inverse,
            surroundings.columns,
        )
        for column in range(left, right + 1):
            x = surroundings.left + column * side
            enter, leave = shares_within(ax, dx, x - slack, x + side + slack)
            enter, leave = max(enter, low), min(leave, high)
            cell = row * surroundings.columns + column
            for e in range(surroundings.cell_start[cell], surroundings.cell_start[cell + 1]):
                if surroundings.entry_least[e] > 0.0:
                    break
                if meets_entry(surroundings, e, enter, leave, ax, ay, az, dx, dy, dz):
                    return False
    return True
