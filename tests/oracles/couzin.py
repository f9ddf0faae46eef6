"""One step of Couzin's zones without noise, agent by agent, in open space.

Source: Couzin et al. 2002, J. theor. Biol. 218, equations (1) to (3) and the text around them.
"""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Zones:
    """The paper's symbols; angles in degrees as in its table 1."""

    r_r: float = 1.0
    dr_o: float = 3.0
    dr_a: float = 10.0
    alpha: float = 270.0
    s: float = 3.0
    theta: float = 40.0
    tau: float = 0.1


def in_view(heading, gap, alpha):
    """Whether a place at `gap` is not in the blind cone behind."""
    cosine = heading @ gap / math.sqrt(gap @ gap)
    return cosine >= math.cos(math.radians(alpha / 2))


def wanted(i, position, heading, p):
    """The desired direction d_i, not brought to length 1; None for none."""
    away, along, towards = [], [], []
    for j in range(len(position)):
        gap = position[j] - position[i]
        d = math.sqrt(gap @ gap)
        if d == 0 or d > p.r_r + p.dr_o + p.dr_a:
            continue
        if d < p.r_r:
            away.append(-gap / d)
        elif in_view(heading[i], gap, p.alpha):
            if d < p.r_r + p.dr_o:
                along.append(heading[j])
            else:
                towards.append(gap / d)
    if away:
        total = np.sum(away, axis=0)
    elif along and towards:
        total = 0.5 * (np.sum(along, axis=0) + np.sum(towards, axis=0))
    elif along or towards:
        total = np.sum(along or towards, axis=0)
    else:
        return None
    return total if math.sqrt(total @ total) > 1e-12 else None


def turned(heading, direction, most):
    """The heading turned towards a unit direction by at most `most` rad, in the plane of both."""
    angle = math.acos(min(1.0, max(-1.0, heading @ direction)))
    if angle <= most:
        return direction
    across = direction - (heading @ direction) * heading
    across = across / math.sqrt(across @ across)
    return math.cos(most) * heading + math.sin(most) * across


def step(position, heading, p):
    """All agents at once: (position, heading) at t + tau."""
    return step_of_each(position, heading, [p] * len(position))


def step_of_each(position, heading, zones):
    """The same where every agent has zones of its own, a list of them."""
    new = heading.copy()
    for i, p in enumerate(zones):
        direction = wanted(i, position, heading, p)
        if direction is not None:
            unit = direction / math.sqrt(direction @ direction)
            new[i] = turned(heading[i], unit, math.radians(p.theta) * p.tau)
    way = np.array([p.s * p.tau for p in zones])
    return position + way[:, None] * new, new
