"""One step of the informed groups of Couzin et al. 2005 without error, agent by agent.

Source: Couzin, Krause, Franks and Levin 2005, Nature 433, 513; the sum over headings leaves the
agent itself out, and who is too near to another goes by nothing else.
"""

import math
from dataclasses import dataclass

import numpy as np

from .couzin import turned


@dataclass(frozen=True)
class Agent:
    """The paper's symbols of one agent; angles in degrees."""

    omega: float = 0.0
    g: float = 0.0
    alpha: float = 1.0
    rho: float = 6.0
    s: float = 1.0
    theta: float = 114.59
    dt: float = 0.2


def unit(vector):
    """The vector at length 1; None for one without a direction."""
    length = math.sqrt(vector @ vector)
    return vector / length if length > 1e-12 else None


def wanted(i, position, heading, agent):
    """The direction d_i' that an agent wants, a unit vector; None for none."""
    away, social = [], []
    for j in range(len(position)):
        gap = position[j] - position[i]
        d = math.sqrt(gap @ gap)
        if d == 0:
            continue
        if d < agent.alpha:
            away.append(-gap / d)
        elif d <= agent.rho:
            social.append(gap / d + heading[j])
    if away:
        return unit(np.sum(away, axis=0))
    direction = unit(np.sum(social, axis=0)) if social else None
    direction = heading[i] if direction is None else direction
    angle = math.radians(agent.g)
    return unit(direction + agent.omega * np.array([math.cos(angle), math.sin(angle)]))


def step(position, heading, agents):
    """All agents at once: (position, heading) at t + dt; `agents` has the numbers of each."""
    new = heading.copy()
    for i, agent in enumerate(agents):
        direction = wanted(i, position, heading, agent)
        if direction is not None:
            new[i] = turned(heading[i], direction, math.radians(agent.theta) * agent.dt)
    way = np.array([agent.s * agent.dt for agent in agents])
    return position + way[:, None] * new, new
