"""One step of the thesis's zones, literal and safe, agent by agent, without wrapping.

Source: the thesis, (3.6) to (3.12), (4.1) and (4.2) with the sign that repels; for the safe ones
the text that says what was added. Solids are those of `oracles.solids`.
"""

import math
from dataclasses import dataclass

import numpy as np

from oracles.couzin import in_view, turned


@dataclass(frozen=True)
class Zones:
    """Symbols of the thesis, angles in degrees; d_s to g are those of the safe zones."""

    d_r: float = 1.34
    d_o: float = 2.5
    d_a: float = 5.0
    alpha: float = 90.0
    gain: float = 10.0
    Q: float = 5.0
    m: float = 1.0
    v0: float = 3.0
    v_min: float = 0.0
    v_max: float = 3.0
    a_max: float = 1.0
    theta_max: float = 120.0
    tau: float = 0.1
    body: float = 0.75
    d_s: float = 5.0
    t_s: float = 1.5
    miss: float = 1.1
    g: float = 1.0


def unit(vector):
    """The vector at length 1, zeros if it has none."""
    length = np.linalg.norm(vector)
    return vector / length if length > 1e-12 else np.zeros_like(vector)


def field(place, heading, solids, p):
    """Sum of -grad U of (4.1) over the solids whose nearest place is ahead."""
    total = np.zeros(len(place))
    for solid in solids:
        distance, normal = solid(place)
        skin = max(distance - p.body / 2, 0.05)
        if skin <= p.Q and (normal @ heading <= 0 or distance < 0):
            total += p.gain * (1 / skin - 1 / p.Q) / skin**2 * normal
    return total


def sorted_out(i, position, heading, p, all_round):
    """The sums v_r, v_o and v_a of agent i, and whether anyone is in the zone of repulsion."""
    away, along, towards = [], [], []
    for j in range(len(position)):
        gap = position[j] - position[i]
        d = math.sqrt(gap @ gap)
        if d == 0:
            continue
        seen = in_view(heading[i], gap, p.alpha)
        if d < p.d_r:
            if seen or all_round:
                away.append(-gap / d)
        elif seen and d < p.d_o:
            along.append(heading[j])
        elif seen and d <= p.d_a:
            towards.append(gap / d)
    nothing = np.zeros(position.shape[1])
    return [sum(some, nothing) for some in (away, along, towards)], bool(away)


def literal(i, position, heading, speed, solids, p):  # noqa: ARG001 - as `safe`
    """The velocity that the thesis's rule wants."""
    (v_r, v_o, v_a), crowded = sorted_out(i, position, heading, p, False)
    direction = unit(v_r if crowded else v_o + v_a)
    if not direction.any():
        direction = heading[i]
    force = field(position[i], heading[i], solids, p)
    return p.v0 * unit(p.v0 * direction + p.tau / p.m * force)


def safe(i, position, heading, speed, solids, p):
    """The velocity that the safe zones want."""
    (_, v_o, v_a), _ = sorted_out(i, position, heading, p, True)
    total = p.g * unit(v_o + v_a)
    for j in range(len(position)):
        gap = position[j] - position[i]
        d = math.sqrt(gap @ gap)
        if j == i or d == 0:
            continue
        weight = 10 * (1 - d / p.d_r) if d < p.d_r else 0.0
        wind = speed[j] * heading[j] - speed[i] * heading[i]
        if d <= p.d_s and wind @ wind > 1e-12:
            t = -(gap @ wind) / (wind @ wind)
            if 0 < t <= p.t_s and np.linalg.norm(gap + t * wind) < p.miss:
                weight += min(10.0, 1 / t)
        total -= weight * gap / d
    total += p.tau / p.m / p.v0 * field(position[i], heading[i], solids, p)
    return p.v0 * (unit(total) if np.linalg.norm(total) > 1e-12 else heading[i])


def flown(i, position, heading, speed, want, p):
    """Position, heading and speed of agent i after a tick with the wanted velocity."""
    asked = math.sqrt(want @ want)
    course = heading[i]
    if asked > 1e-12:
        course = unit(turned(heading[i], want / asked, math.radians(p.theta_max) * p.tau))
    else:
        asked = p.v0
    aim = min(max(asked, p.v_min), p.v_max)
    step = min(max(aim - speed[i], -p.a_max * p.tau), p.a_max * p.tau)
    now = speed[i] + step
    return position[i] + now * p.tau * course, course, now


def tick(rule, position, heading, speed, solids, p):
    """Positions, headings and speeds after a tick of all agents at once."""
    moved = []
    for i in range(len(position)):
        want = rule(i, position, heading, speed, solids, p)
        moved.append(flown(i, position, heading, speed, want, p))
    place, course, pace = zip(*moved, strict=True)
    return np.array(place), np.array(course), np.array(pace)


def touching(position, solids, body):
    """What each agent touches: 1 another, 2 something solid, 0 nothing."""
    gap = np.linalg.norm(position[:, None] - position[None], axis=2)
    np.fill_diagonal(gap, np.inf)
    found = np.zeros(len(position), int)
    for i, place in enumerate(position):
        if gap[i].min() <= body:
            found[i] = 1
        elif any(solid(place)[0] <= body / 2 for solid in solids):
            found[i] = 2
    return found
