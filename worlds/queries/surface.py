"""Find the nearest surface to a place, through the cells of `Surroundings`.

Each cell of the plan lists the solids that come within reach of it, nearest first, and of each
outline the runs of edges that can be nearest to a place in the cell.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from worlds.compilation import compiled


class Surface(NamedTuple):
    """The place of a solid's surface that is nearest to an agent."""

    distance: float
    """Signed distance, length: negative inside the solid; inf if none is within reach."""
    x: float
    y: float
    z: float
    nx: float
    """Unit normal at the agent, away from the solid; from a corner it points to the agent."""
    ny: float
    nz: float
    smooth: float
    """1 where the surface has a tangent, 0 at a corner and on a rim."""


class NearbySolids(NamedTuple):
    """The solids listed near a place, numbered from 0 on: planes, then entries."""

    first: int
    number: int


@compiled
def nowhere():
    """No surface."""
    return Surface(math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@compiled
def solids_around(surroundings, x, y):
    """The solids that may be within reach of a place, `NearbySolids`: a cursor for `surface`.

    Solid edges of the box come first, then outlines and spheres, by least distance of the cell.
    """
    planes = surroundings.plane.shape[0]
    column = math.floor((x - surroundings.left) * surroundings.inverse)
    row = math.floor((y - surroundings.front) * surroundings.inverse)
    if not (0.0 <= column < surroundings.columns and 0.0 <= row < surroundings.rows):
        return NearbySolids(0, planes)
    cell = int(row) * surroundings.columns + int(column)
    first = surroundings.cell_start[cell]
    return NearbySolids(first, planes + surroundings.cell_start[cell + 1] - first)


@compiled
def solid_of(surroundings, nearby, k):
    """The id of the k-th solid around: outlines 0, 1, ..., then spheres, then solid edges."""
    planes = surroundings.plane.shape[0]
    if k < planes:
        return surroundings.span.shape[0] + surroundings.ball.shape[0] + k
    return surroundings.entry_solid[nearby.first + k - planes]


@compiled
def within_arc(at, wx, wy):
    """Whether the direction (wx, wy) from its circle's centre goes through an arc, ends not."""
    past_begin = (at[0] - at[8]) * wy - (at[1] - at[9]) * wx
    before_end = wx * (at[3] - at[9]) - wy * (at[2] - at[8])
    return (past_begin * at[10] > 0.0) & (before_end * at[10] > 0.0)


@compiled
def distance_to_arc(at, x, y):
    """Signed distance of a place to the circle of an arc, positive on the free side."""
    wx, wy = x - at[8], y - at[9]
    away = math.sqrt(wx * wx + wy * wy) - math.fabs(at[10])
    return math.copysign(1.0, at[10]) * away


@compiled
def side_of(surroundings, edge, t, x, y):
    """> 0 if a place is on the free side of the edge that it is nearest to, at the share t of it.

    Beyond an end that is the side of the corner, found by the sum of the normals there.
    """
    at = surroundings.edge[edge]
    if t <= 0.0:
        corner = surroundings.corner[edge]
        return (x - at[0]) * corner[0] + (y - at[1]) * corner[1]
    if t >= 1.0:
        corner = surroundings.corner[surroundings.after[edge]]
        return (x - at[2]) * corner[0] + (y - at[3]) * corner[1]
    if at[10] != 0.0:
        return distance_to_arc(at, x, y)
    return (x - at[0]) * at[6] + (y - at[1]) * at[7]


@compiled
def from_arc(at, x, y):
    """0, 1 or between as the start of an arc, its end or neither is nearest; squared distance."""
    if within_arc(at, x - at[8], y - at[9]):
        d = distance_to_arc(at, x, y)
        return 0.5, d * d
    wx, wy = x - at[0], y - at[1]
    vx, vy = x - at[2], y - at[3]
    first, last = wx * wx + wy * wy, vx * vx + vy * vy
    return (0.0, first) if first <= last else (1.0, last)


@compiled
def nearest_edge(surroundings, entry, x, y):
    """Of an outline listed in a cell: the nearest edge, the share t along it, squared distance.

    Of an arc t only says whether an end of it is nearest: 0 or 1, else it is between. Outlines may
    touch themselves in a corner; then the side that is free counts.
    """
    best, share, least2 = -1, 0.0, math.inf
    for run in range(surroundings.entry_run[entry], surroundings.entry_run[entry + 1]):
        for i in range(surroundings.run[run, 0], surroundings.run[run, 1]):
            at = surroundings.edge[i]
            if at[10] != 0.0:
                t, d2 = from_arc(at, x, y)
            else:
                dx, dy = x - at[0], y - at[1]
                t = dx * at[4] + dy * at[5]
                if t >= 1.0:
                    dx, dy = x - at[2], y - at[3]
                if (t > 0.0) & (t < 1.0):
                    d = dx * at[6] + dy * at[7]
                    d2 = d * d
                else:
                    d2 = dx * dx + dy * dy
            if d2 < least2 or (d2 == least2 and side_of(surroundings, i, t, x, y) > 0.0):
                best, share, least2 = i, t, d2
    return best, share, least2


@compiled
def prism_distance(flat, height):
    """Signed distance to a prism, from that to its outline and that to its slab of heights."""
    if flat > 0.0:
        return math.hypot(flat, height) if height > 0.0 else flat
    return max(flat, height)


@compiled
def plane_distance(surroundings, k, x, y, z):
    """Signed distance to the k-th solid edge of the box, negative beyond it."""
    at = surroundings.plane[k]
    return x * at[0] + y * at[1] + z * at[2] - at[3]


@compiled
def entry_distance(surroundings, entry, x, y, z):
    """Signed distance to a solid listed in a cell; and for an outline edge and share, else -1."""
    solid = surroundings.entry_solid[entry]
    outlines = surroundings.span.shape[0]
    if solid >= outlines:
        ball = surroundings.ball[solid - outlines]
        dx, dy, dz = x - ball[0], y - ball[1], z - ball[2]
        return math.sqrt(dx * dx + dy * dy + dz * dz) - ball[3], -1, 0.0
    edge, t, d2 = nearest_edge(surroundings, entry, x, y)
    flat = math.copysign(math.sqrt(d2), side_of(surroundings, edge, t, x, y))
    height = max(surroundings.span[solid, 0] - z, z - surroundings.span[solid, 1])
    return prism_distance(flat, height), edge, t


@compiled
def plane_surface(surroundings, k, distance, x, y, z):
    """The surface of a solid edge of the box."""
    nx, ny, nz = surroundings.plane[k, 0], surroundings.plane[k, 1], surroundings.plane[k, 2]
    return Surface(
        distance, x - distance * nx, y - distance * ny, z - distance * nz, nx, ny, nz, 1.0
    )


@compiled
def ball_surface(ball, distance, x, y, z):
    """The surface of a sphere; from its centre the nearest place is taken to be along +x."""
    d = distance + ball[3]
    if d > 0.0:
        nx, ny, nz = (x - ball[0]) / d, (y - ball[1]) / d, (z - ball[2]) / d
    else:
        nx, ny, nz = 1.0, 0.0, 0.0
    r = ball[3]
    return Surface(distance, ball[0] + r * nx, ball[1] + r * ny, ball[2] + r * nz, nx, ny, nz, 1.0)


@compiled
def outline_surface(surroundings, edge, t, x, y):
    """The nearest place of an outline on the plan, as a Surface with z = 0 and nz = 0."""
    at = surroundings.edge[edge]
    if (t > 0.0) & (t < 1.0) & (at[10] != 0.0):
        sign = math.copysign(1.0, at[10])
        d = distance_to_arc(at, x, y)
        away = sign * d + math.fabs(at[10])
        nx, ny = sign * (x - at[8]) / away, sign * (y - at[9]) / away
        return Surface(d, x - d * nx, y - d * ny, 0.0, nx, ny, 0.0, 1.0)
    if (t > 0.0) & (t < 1.0):
        d = (x - at[0]) * at[6] + (y - at[1]) * at[7]
        return Surface(d, x - d * at[6], y - d * at[7], 0.0, at[6], at[7], 0.0, 1.0)
    corner = edge if t <= 0.0 else surroundings.after[edge]
    qx, qy = surroundings.edge[corner, 0], surroundings.edge[corner, 1]
    mx, my, smooth = (
        surroundings.corner[corner, 0],
        surroundings.corner[corner, 1],
        surroundings.corner[corner, 2],
    )
    dx, dy = x - qx, y - qy
    d = math.sqrt(dx * dx + dy * dy)
    if d == 0.0:
        return Surface(0.0, qx, qy, 0.0, mx, my, 0.0, smooth)
    d = math.copysign(d, dx * mx + dy * my)
    return Surface(d, qx, qy, 0.0, dx / d, dy / d, 0.0, smooth)


@compiled
def prism_surface(surroundings, solid, flat, x, y, z):
    """The nearest place of a prism, from that of its outline on the plan."""
    bottom, top = surroundings.span[solid, 0], surroundings.span[solid, 1]
    over = z - top >= bottom - z
    height = z - top if over else bottom - z
    cap = top if over else bottom
    up = 1.0 if over else -1.0
    if flat.distance > 0.0 and height > 0.0:
        d = math.hypot(flat.distance, height)
        nx, ny, nz = (x - flat.x) / d, (y - flat.y) / d, (z - cap) / d
        return Surface(d, flat.x, flat.y, cap, nx, ny, nz, 0.0)
    if flat.distance >= height:
        return Surface(flat.distance, flat.x, flat.y, z, flat.nx, flat.ny, 0.0, flat.smooth)
    return Surface(height, x, y, cap, 0.0, 0.0, up, 1.0)


@compiled
def entry_surface(surroundings, entry, edge, t, distance, x, y, z):
    """The surface of a solid listed in a cell, from what `entry_distance` has found."""
    solid = surroundings.entry_solid[entry]
    outlines = surroundings.span.shape[0]
    if solid >= outlines:
        return ball_surface(surroundings.ball[solid - outlines], distance, x, y, z)
    return prism_surface(surroundings, solid, outline_surface(surroundings, edge, t, x, y), x, y, z)


@compiled
def surface(surroundings, nearby, k, x, y, z):
    """The nearest surface of the k-th solid around a place; distance inf if it is out of reach."""
    planes = surroundings.plane.shape[0]
    if k < planes:
        d = plane_distance(surroundings, k, x, y, z)
        return plane_surface(surroundings, k, d, x, y, z) if d <= surroundings.reach else nowhere()
    entry = nearby.first + k - planes
    d, edge, t = entry_distance(surroundings, entry, x, y, z)
    return (
        entry_surface(surroundings, entry, edge, t, d, x, y, z)
        if d <= surroundings.reach
        else nowhere()
    )


@compiled
def is_beyond(surroundings, entry, x, y, r):
    """True only if an outline listed in a cell is further than r from a place, by its box alone."""
    solid = surroundings.entry_solid[entry]
    if solid >= surroundings.span.shape[0]:
        return False
    box = surroundings.box[solid]
    dx = max(max(box[0] - x, x - box[2]), 0.0)
    dy = max(max(box[1] - y, y - box[3]), 0.0)
    return dx * dx + dy * dy > r * r


@compiled
def nearest_solid(surroundings, x, y, z, first, r):
    """The solid of least signed distance, at most r and the reach: distance, plane, entry, edge, t.

    `plane` and `entry` are -1 where it is not one, both if there is none. Planes count from the
    number `first` on: 0 for all of them, surroundings.plane.shape[0] for obstacles only.
    """
    planes = surroundings.plane.shape[0]
    distance, plane, entry, edge, share = min(r, surroundings.reach), -1, -1, -1, 0.0
    for k in range(first, planes):
        d = plane_distance(surroundings, k, x, y, z)
        if d <= distance:
            distance, plane = d, k
    nearby = solids_around(surroundings, x, y)
    last = nearby.first + nearby.number - planes
    for e in range(nearby.first, last):
        if surroundings.entry_least[e] > distance:
            break
        # r = 0 asks whether a place is inside: boxes rule out little of what is listed then.
        if r > 0.0 and is_beyond(surroundings, e, x, y, distance):
            continue
        d, i, t = entry_distance(surroundings, e, x, y, z)
        if d < distance or (d == distance and plane < 0 and entry < 0):
            distance, plane, entry, edge, share = d, -1, e, i, t
    return distance, plane, entry, edge, share


@compiled
def nearest_surface(surroundings, x, y, z):
    """The nearest surface to a place, of obstacles and solid edges of the box: a `Surface`.

    Where solids overlap, that of the least signed distance: exact outside, and inside a lower bound
    of how far it is out of all of them. At a distance inf if none is in reach.
    """
    return surface_within(surroundings, x, y, z, surroundings.reach)


@compiled
def surface_within(surroundings, x, y, z, r):
    """The `nearest_surface` if it is within r (length), to the bit; else at a distance inf.

    What is further away is not looked at, so it costs less the smaller r is.
    """
    if surroundings.solids == 0:
        return nowhere()
    d, plane, entry, edge, t = nearest_solid(surroundings, x, y, z, 0, r)
    if plane >= 0:
        return plane_surface(surroundings, plane, d, x, y, z)
    if entry >= 0:
        return entry_surface(surroundings, entry, edge, t, d, x, y, z)
    return nowhere()


@compiled
def signed_distance(surroundings, x, y, z):
    """Signed distance of a place to the nearest surface, length; see `nearest_surface`."""
    if surroundings.solids == 0:
        return math.inf
    d, plane, entry, _, _ = nearest_solid(surroundings, x, y, z, 0, surroundings.reach)
    return d if plane >= 0 or entry >= 0 else math.inf
