"""Find where a step from one place to another first enters something solid.

Only what is entered counts, never what is left: who is inside can get out. Places count as on a
surface within a share of `skin`, so that rounding opens no gap between edges that meet.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from worlds.compilation import compiled, shared
from worlds.queries.sight_lines import SLACK, cells_between, is_on_arc, shares_within
from worlds.queries.surface import entry_distance, solids_around

RELATIVE = 1e-9
"""Skin of a surface, for each unit of length that a place is away from the origin."""
CLOSE = 0.25
"""Share of the skin within which a place counts as on a surface."""


class Crossing(NamedTuple):
    """The first surface that a step enters."""

    share: float
    """Share of the step up to it, in [0, 1]; inf if none is entered."""
    nx: float
    """Unit normal there, away from the solid."""
    ny: float
    nz: float


@compiled
def skin(x, y, z):
    """The distance (length) that is kept to a surface that has been met, more than rounding is."""
    return RELATIVE * (1.0 + math.fabs(x) + math.fabs(y) + math.fabs(z))


@compiled
def is_far(surroundings, x, y, z, r):
    """True only if nothing solid is within r of a place; where it is False, something may be."""
    if surroundings.solids == 0:
        return True
    if not (r < surroundings.reach):
        return False
    for k in range(surroundings.plane.shape[0]):
        at = surroundings.plane[k]
        if x * at[0] + y * at[1] + z * at[2] - at[3] <= r:
            return False
    nearby = solids_around(surroundings, x, y)
    listed = nearby.number - surroundings.plane.shape[0]
    return listed == 0 or surroundings.entry_least[nearby.first] > r


@compiled
def entry_through_plane(at, close, ax, ay, az, dx, dy, dz):
    """The share at which the way from a along d goes beyond a solid edge of the box, or inf."""
    offset = ax * at[0] + ay * at[1] + az * at[2] - at[3]
    gain = dx * at[0] + dy * at[1] + dz * at[2]
    if offset < -close or gain >= 0.0 or offset + gain >= 0.0:
        return math.inf
    return min(max(offset / -gain, 0.0), 1.0)


@compiled
def entry_through_edge(at, bottom, top, close, ax, ay, az, dx, dy, dz):
    """The share at which the way from a along d goes in through an edge of an outline, or inf."""
    wx, wy = ax - at[0], ay - at[1]
    offset = wx * at[6] + wy * at[7]
    gain = dx * at[6] + dy * at[7]
    if offset < -close or gain >= 0.0 or offset + gain >= 0.0:
        return math.inf
    t = min(max(offset / -gain, 0.0), 1.0)
    ex, ey = at[2] - at[0], at[3] - at[1]
    length = math.sqrt(ex * ex + ey * ey)
    along = ((wx + t * dx) * ex + (wy + t * dy) * ey) / length
    z = az + t * dz
    hits = (-close <= along) & (along <= length + close) & (bottom - close <= z <= top + close)
    return t if hits else math.inf


@compiled
def entry_through_arc(at, bottom, top, close, ax, ay, az, dx, dy, dz):
    """The share at which the way from a along d goes in through an arc of an outline, or inf.

    It goes into a round solid where it comes into the circle, and into what is round a hole where
    it goes out of it.
    """
    wx, wy = ax - at[8], ay - at[9]
    r = math.fabs(at[10])
    out = math.sqrt(wx * wx + wy * wy)
    b = wx * dx + wy * dy
    d2 = dx * dx + dy * dy
    c = (out - r) * (out + r)
    root = b * b - d2 * c
    if root <= 0.0:
        return math.inf
    if at[10] > 0.0:
        if b >= 0.0 or out - r < -close:
            return math.inf
        t = c / (math.sqrt(root) - b)
    else:
        if r - out < -close:
            return math.inf
        t = -c / (b + math.sqrt(root)) if b > 0.0 else (math.sqrt(root) - b) / d2
    if t > 1.0:
        return math.inf
    t = max(t, 0.0)
    z = az + t * dz
    hits = is_on_arc(at, wx + t * dx, wy + t * dy, close)
    return t if hits and bottom - close <= z <= top + close else math.inf


@compiled
def entry_into_ball(ball, close, ax, ay, az, dx, dy, dz):
    """The share at which the way from a along d goes into a sphere, or inf."""
    wx, wy, wz = ax - ball[0], ay - ball[1], az - ball[2]
    b = wx * dx + wy * dy + wz * dz
    d2 = dx * dx + dy * dy + dz * dz
    out = math.sqrt(wx * wx + wy * wy + wz * wz)
    c = (out - ball[3]) * (out + ball[3])
    root = b * b - d2 * c
    if b >= 0.0 or root <= 0.0 or out - ball[3] < -close:
        return math.inf
    t = c / (math.sqrt(root) - b)
    return max(t, 0.0) if t <= 1.0 else math.inf


@compiled
def entry_through_cap(surroundings, entry, height, up, close, low, high, ax, ay, az, dx, dy, dz):
    """The share at which the way goes in through the top (up = 1) or bottom (-1) of a prism.

    Only within the shares [low, high], at which it is in the cell of the entry; else inf.
    """
    offset = up * (az - height)
    if not (offset >= -close and offset + up * dz < 0.0):
        return math.inf
    t = min(max(offset / (-up * dz), 0.0), 1.0)
    if not (low <= t <= high):
        return math.inf
    d, _, _ = entry_distance(surroundings, entry, ax + t * dx, ay + t * dy, height)
    return t if d <= close else math.inf


@compiled
def entry_share(surroundings, entry, first, close, low, high, ax, ay, az, dx, dy, dz):
    """The earlier of a crossing and that of a solid listed in a cell, crossed at [low, high]."""
    solid = surroundings.entry_solid[entry]
    outlines = surroundings.span.shape[0]
    best = first
    if solid >= outlines:
        ball = surroundings.ball[solid - outlines]
        t = entry_into_ball(ball, close, ax, ay, az, dx, dy, dz)
        if t < best.share:
            x, y, z = ax + t * dx - ball[0], ay + t * dy - ball[1], az + t * dz - ball[2]
            size = math.sqrt(x * x + y * y + z * z)
            best = Crossing(t, x / size, y / size, z / size)
        return best
    bottom, top = surroundings.span[solid, 0], surroundings.span[solid, 1]
    for run in range(surroundings.entry_run[entry], surroundings.entry_run[entry + 1]):
        for i in range(surroundings.run[run, 0], surroundings.run[run, 1]):
            at = surroundings.edge[i]
            if at[10] != 0.0:
                t = entry_through_arc(at, bottom, top, close, ax, ay, az, dx, dy, dz)
                if t < best.share:
                    x, y = ax + t * dx - at[8], ay + t * dy - at[9]
                    size = math.copysign(math.sqrt(x * x + y * y), at[10])
                    best = Crossing(t, x / size, y / size, 0.0)
                continue
            t = entry_through_edge(at, bottom, top, close, ax, ay, az, dx, dy, dz)
            if t < best.share:
                best = Crossing(t, at[6], at[7], 0.0)
    if dz != 0.0:
        up = -1.0 if dz > 0.0 else 1.0
        height = bottom if dz > 0.0 else top
        t = entry_through_cap(
            surroundings, entry, height, up, close, low, high, ax, ay, az, dx, dy, dz
        )
        if t < best.share:
            best = Crossing(t, 0.0, 0.0, up)
    return best


@shared
def first_crossing(surroundings, ax, ay, az, dx, dy, dz):
    """The first surface that the way from a along d (its length is the step's) enters: `Crossing`.

    Looks into the cells along the way, row by row, as `worlds.queries.sight_lines.line_of_sight`
    does.
    """
    best = Crossing(math.inf, 0.0, 0.0, 0.0)
    reach = math.fabs(dx) + math.fabs(dy) + math.fabs(dz)
    if not (reach < math.inf):
        return best
    close = CLOSE * (skin(ax, ay, az) + RELATIVE * reach)
    for k in range(surroundings.plane.shape[0]):
        at = surroundings.plane[k]
        t = entry_through_plane(at, close, ax, ay, az, dx, dy, dz)
        if t < best.share:
            best = Crossing(t, at[0], at[1], at[2])
    if surroundings.columns == 0:
        return best
    by = ay + dy
    side = 1.0 / surroundings.inverse
    slack = SLACK * side + close
    front, back = min(ay, by) - close, max(ay, by) + close
    first, last = cells_between(
        front, back, surroundings.front, surroundings.inverse, surroundings.rows
    )
    for row in range(first, last + 1):
        y = surroundings.front + row * side
        low, high = shares_within(ay, dy, y - slack, y + side + slack)
        if low > high:
            continue
        x_low, x_high = ax + low * dx, ax + high * dx
        left, right = min(x_low, x_high) - close, max(x_low, x_high) + close
        left, right = cells_between(
            left, right, surroundings.left, surroundings.inverse, surroundings.columns
        )
        for column in range(left, right + 1):
            x = surroundings.left + column * side
            enter, leave = shares_within(ax, dx, x - slack, x + side + slack)
            enter, leave = max(enter, low), min(leave, high)
            cell = row * surroundings.columns + column
            for e in range(surroundings.cell_start[cell], surroundings.cell_start[cell + 1]):
                if surroundings.entry_least[e] > close:
                    break
                best = entry_share(
                    surroundings, e, best, close, enter, leave, ax, ay, az, dx, dy, dz
                )
    return best


@compiled
def is_crossed(surroundings, ax, ay, az, bx, by, bz):
    """Whether a step from a to b enters something solid on its way."""
    dx, dy, dz = bx - ax, by - ay, bz - az
    if is_far(surroundings, ax, ay, az, math.sqrt(dx * dx + dy * dy + dz * dz)):
        return False
    return first_crossing(surroundings, ax, ay, az, dx, dy, dz).share <= 1.0
