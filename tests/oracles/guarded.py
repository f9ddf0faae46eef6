"""One step of the guarded zones, agent by agent, without wrapping.

Written from the text of the guard: an escape is flown corner by corner, its last circle is drawn
through three corners, and the steps are listed in the order of wishes. Solids are those of
`oracles.solids`.
"""

import math
from dataclasses import dataclass

import numpy as np

from oracles.zones import Zones, field, sorted_out, unit

SKIN = 0.01


@dataclass(frozen=True)
class Guarded(Zones):
    """The thesis's parameters as the model has them, and those of the calls."""

    d_r: float = 2.0
    alpha: float = 270.0
    v0: float = 1.0
    v_min: float = 0.5
    v_max: float = 1.5
    w_a: float = 0.1
    w_c: float = 0.5
    d_c: float = 10.0


def turn(heading, side, angle):
    """The heading turned by an angle towards a unit vector at right angles to it."""
    return math.cos(angle) * heading + math.sin(angle) * side


def across(heading, vector):
    """The unit vector at right angles to the heading nearest to a vector; to the left if none."""
    rest = vector - (vector @ heading) * heading
    if np.linalg.norm(rest) > 1e-9:
        return unit(rest)
    left = np.zeros(len(heading))
    left[:2] = -heading[1], heading[0]
    return unit(left) if left.any() else np.eye(len(heading))[0]


def changed(speed, to, p):
    """The speed a tick later, on the way to another."""
    return speed + min(max(to - speed, -p.a_max * p.tau), p.a_max * p.tau)


def flight(speed, p, ticks):
    """Corners of the escape in its plane: from the origin, along (1, 0), turning to (0, 1)."""
    theta = math.radians(p.theta_max) * p.tau
    at = np.zeros(2)
    corners = [at]
    for k in range(1, ticks + 1):
        speed = changed(speed, p.v_min, p)
        at = at + speed * p.tau * np.array([math.cos(k * theta), math.sin(k * theta)])
        corners.append(at)
    return np.array(corners)


def circumcentre(a, b, c):
    """The place that three places of the plane are as far from."""
    return np.linalg.solve(2.0 * np.array([b - a, c - a]), [b @ b - a @ a, c @ c - a @ a])


def room(place, heading, side, speed, p):
    """Centre and radius of the room from a place, escaping to a side."""
    slowing = math.ceil(abs(speed - p.v_min) / (p.a_max * p.tau)) + 1
    corners = flight(speed, p, slowing + 3)
    centre = circumcentre(*corners[-3:])
    radius = np.linalg.norm(corners - centre, axis=1).max()
    return place + centre[0] * heading + centre[1] * side, radius


def wish(i, position, heading, solids, p):
    """The unit vector that flocking asks for."""
    (v_r, v_o, v_a), _ = sorted_out(i, position, heading, p, True)
    gaps = np.delete(position, i, axis=0) - position[i]
    far = np.linalg.norm(gaps, axis=1)
    heard = (gaps / far[:, None])[far <= p.d_c]
    calls = heard.mean(axis=0) if len(heard) else np.zeros(position.shape[1])
    total = unit(v_r + unit(v_o + p.w_a * v_a) + p.w_c * calls)
    if not total.any():
        total = heading[i]
    pushed = p.v0 * total + p.tau / p.m * field(position[i], heading[i], solids, p)
    return unit(pushed) if np.linalg.norm(pushed) > 1e-12 else heading[i]


def steps(place, heading, speed, told, want, p):
    """The steps in the order in which they are tried: heading, speed, centre and radius."""
    eighths = [0, 45, -45, 90, -90, 135, -135, 180]
    if len(heading) == 2:
        eighths = [0, 180]
    most = math.radians(p.theta_max) * p.tau
    toward = across(heading, want)
    out = told[0] - place
    angle = min(most, math.acos(min(1.0, max(-1.0, want @ heading))))
    headings = [turn(heading, toward, angle), heading]
    headings += [turn(heading, about(heading, toward, e), most) for e in eighths[1:]]
    for course in headings:
        for pace in (changed(speed, p.v0, p), changed(speed, p.v_min, p)):
            there = place + pace * p.tau * course
            for eighth in eighths:
                side = about(course, across(course, across(heading, out)), eighth)
                yield course, pace, *room(there, course, side, pace, p)
    yield turn(heading, across(heading, out), most), changed(speed, p.v_min, p), *told


def about(axis, vector, degrees):
    """A vector at right angles to an axis turned about it; in the plane only by 0 or 180."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    if len(axis) == 2:
        return c * vector
    return c * vector + s * np.cross(axis, vector)


def overlap(i, told, then, solids, p):
    """By how much a room is over the planes of agent i to all others, and in solids."""
    centre, radius = told[i]
    total = 0.0
    for j, (other, wide) in enumerate(told):
        if j == i:
            continue
        e = (other - centre) / np.linalg.norm(other - centre)
        # The plane halfway between the surfaces of both rooms, bodies and skins among them.
        one = centre @ e + radius + p.body / 2 + SKIN
        two = other @ e - wide - p.body / 2 - SKIN
        total += max(0.0, then[0] @ e + then[1] + p.body / 2 + SKIN - (one + two) / 2)
    clear = min((solid(then[0])[0] for solid in solids), default=math.inf)
    return total + max(0.0, then[1] + p.body / 2 + SKIN - clear)


def chosen(i, position, heading, speed, told, solids, p):
    """The step of agent i: the first that is safe, else the one that overlaps least."""
    want = wish(i, position, heading, solids, p)
    best, least = None, math.inf
    for step in steps(position[i], heading[i], speed[i], told[i], want, p):
        over = overlap(i, told, step[2:], solids, p)
        if over < least:
            best, least = step, over
        if over <= 1e-9:
            break
    return best


def first_rooms(position, heading, speed, p):
    """What agents tell that have not told anything yet: they would escape to their left."""
    return [
        room(place, u, across(u, u), v, p)
        for place, u, v in zip(position, heading, speed, strict=True)
    ]


def tick(position, heading, speed, told, solids, p):
    """Positions, headings, speeds and rooms after a tick of all agents at once."""
    found = [chosen(i, position, heading, speed, told, solids, p) for i in range(len(position))]
    course = np.array([step[0] for step in found])
    pace = np.array([step[1] for step in found])
    place = position + p.tau * pace[:, None] * course
    return place, course, pace, [step[2:] for step in found]
