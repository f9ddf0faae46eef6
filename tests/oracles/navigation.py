"""One step of a navigating flock among obstacles in the open plane, agent by agent.

Source: Liu et al., Aerospace 2021, 8, 286, sections 2.3, 2.4 and 3.2, with the choices that its
reading makes: neighbours that avoid an obstacle count 0 in (18); of the two tangents the one within
90 degrees of the previous heading; a corner has no tangent; the guard keeps agents out.
"""

import math
from dataclasses import dataclass

import numpy as np
import shapely

from . import vicsek_family as family
from .topology import contact, next_layers


@dataclass(frozen=True)
class Navigation:
    """The symbols of section 3.2."""

    family: family.Parameters
    c_align: float = 1.0
    c_rep: float = 0.1
    r_rep: float = 0.7
    c_att: float = 0.003
    r_att: float = 1.0
    r_avoid: float = 0.5
    theta_obstruct: float = round(11 * math.pi / 20, 4)
    guard: bool = True


@dataclass(frozen=True)
class Surface:
    """The nearest point of the obstacles' outline, seen from an agent."""

    distance: float  # signed, negative inside
    point: np.ndarray
    away: np.ndarray  # unit vector from the solid into the free
    corner: bool


def corners(outline):
    """Vertices (M, 2) at which the outline turns by 20 degrees or more."""
    found = []
    for polygon in getattr(outline, "geoms", [outline]):
        for ring in (polygon.exterior, *polygon.interiors):
            at = np.array(ring.coords)[:-1]
            before, after = at - np.roll(at, 1, axis=0), np.roll(at, -1, axis=0) - at
            turn = np.arctan2(after[:, 1], after[:, 0]) - np.arctan2(before[:, 1], before[:, 0])
            turn = np.abs((turn + math.pi) % math.tau - math.pi)
            found.append(at[turn >= math.radians(20)])
    return np.vstack(found)


@dataclass(frozen=True)
class Area:
    """What is solid: a shapely area of straight edges, and discs that touch nothing else."""

    outline: shapely.Geometry
    discs: tuple  # of (centre, radius)

    def meets(self, a, b):
        """Whether the way from a to b goes through it."""
        way = shapely.LineString([a, b])
        return way.intersects(self.outline) or any(
            way.distance(shapely.Point(c)) <= r for c, r in self.discs
        )


def nearest(area, x):
    """The Surface nearest to a place (2,)."""
    found = [nearest_edge(area.outline, x)]
    for centre, radius in area.discs:
        out = x - np.array(centre)
        away = out / math.hypot(*out)
        found.append(Surface(math.hypot(*out) - radius, centre + radius * away, away, False))
    return min(found, key=lambda one: one.distance)


def nearest_edge(outline, x):
    """The Surface of a shapely area that is nearest to a place."""
    point = np.array(shapely.shortest_line(outline.boundary, shapely.Point(x)).coords[0])
    inside = bool(shapely.contains_xy(outline, *x))
    gap = x - point
    d = math.hypot(*gap)
    away = gap / d if d > 0 else np.zeros(2)
    at_corner = bool((np.hypot(*(corners(outline) - point).T) < 1e-9).any())
    return Surface(-d if inside else d, point, -away if inside else away, at_corner)


def genuine(model, i, state, touch, heard, p):
    """(18): the direction that neighbours who avoid nothing agree on, a unit vector."""
    rule = model.removesuffix("-nav")
    seen = touch & heard[None, :]
    if rule == "ivem-a" and not (seen[i] & state.informed).any():
        return family.unit(family.ivem_angle(i, state.heading, seen))
    weight = family.weights(rule, i, state.layer, touch, state.informed, p) * heard
    weight[i] = 0.0  # b_ii: nobody contributes to its own direction
    if weight.sum() == 0:
        return state.heading[i]
    mean = (weight[:, None] * state.heading).sum(axis=0)
    return mean / math.hypot(*mean)


def between(a, b):
    """Angle between two directions, rad in [0, pi]."""
    turn = math.atan2(a[1], a[0]) - math.atan2(b[1], b[0])
    return abs((turn + math.pi) % math.tau - math.pi)


def avoided(theta, surface, x, heading, p):
    """(20) to (22): the heading at k + 1, and whether it is one of avoidance."""
    if surface.distance > p.r_avoid or surface.corner:
        return theta, False
    if between(theta, surface.point - x) > p.theta_obstruct:
        return theta, False
    tangent = np.array([-surface.away[1], surface.away[0]])
    return (tangent if tangent @ heading >= 0 else -tangent), True


def pushes(i, position, p):
    """(23), (24): attraction and repulsion of agent i, with the sign that does as its name says."""
    attraction, repulsion = np.zeros(2), np.zeros(2)
    for j in range(len(position)):
        gap = position[i] - position[j]
        d = math.hypot(*gap)
        if 0 < d <= p.r_rep:
            repulsion += (p.r_rep - d) / p.r_rep * gap / d
        elif p.r_rep < d <= min(p.r_att, p.family.r):
            attraction += (p.r_rep - d) / (p.r_att - p.r_rep) * gap / d
    return attraction, repulsion


def held_back(outline, surface, x, v, p):
    """The guard: nothing inward within half the range, at most half the distance further out."""
    allowed = 0.0 if surface.distance <= p.r_avoid / 2 else surface.distance / 2
    inward = -(v @ surface.away)
    if inward > allowed:
        v = v + (inward - allowed) * surface.away
    least = min(surface.distance, 0.01 * p.r_avoid)
    then = nearest(outline, x + v)
    if then.distance < least:
        v = v + max(0.0, -(v @ then.away)) * then.away
        if nearest(outline, x + v).distance < least:
            return np.zeros(2)
    return v


def step(model, state, heard, outline, p, turn):
    """All agents at once: (position, heading, heard, layer) at k + 1; the informed go straight.

    `outline` is the Area of all obstacles, `turn` (N,) the noise in rad.
    """
    f = p.family
    touch = contact(state.position, f.r, (1.0, 1.0), "open")
    position, heading, hears = (
        state.position.copy(),
        state.heading.copy(),
        np.ones(len(heard), bool),
    )
    for i in range(len(heard)):
        x = state.position[i]
        if state.informed[i]:
            position[i] = x + f.v0 * state.heading[i]
            continue
        wanted = genuine(model, i, state, touch, heard, f)
        wanted = family.unit(math.atan2(wanted[1], wanted[0]) + turn[i])
        surface = nearest(outline, x)
        heading[i], avoids = avoided(wanted, surface, x, state.heading[i], p)
        hears[i] = not avoids
        attraction, repulsion = pushes(i, state.position, p)
        v = p.c_align * f.v0 * heading[i] + p.c_rep * repulsion + p.c_att * attraction
        v = v * min(1.0, f.v0 / math.hypot(*v))
        if p.guard and surface.distance <= p.r_avoid:
            v = held_back(outline, surface, x, v, p)
        position[i] = x + v
    return position, heading, hears, next_layers(state.layer, touch, state.informed)
