"""Boundary-point flocking, agent by agent, from Wu et al. 2023, 3, and how it is read here.

An agent is in the way of nothing (FREE) or goes along a boundary (FOLLOW). Phases are sorted, as
printed. `slack` as in `olfati_saber`.
"""

import math
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from .olfati_saber import bump, gradient, neighbours, phi_alpha, range_alpha, sigma_norm

FREE, FOLLOW = "free", "follow"


@dataclass(frozen=True)
class Memory:
    """What one agent remembers."""

    state: str = FREE
    blocked: bool = False
    split: np.ndarray = field(default_factory=lambda: np.zeros(2))
    rejoin: np.ndarray = field(default_factory=lambda: np.zeros(2))
    aim: np.ndarray = field(default_factory=lambda: np.zeros(2))
    scenario: int = 0


def warning_distance(p):
    return p.d_min + 2 * p.p_max * p.dt


def eta(distance, p, slack):
    """(12)."""
    d_e = warning_distance(p)
    slack += [abs(distance - d_e), abs(distance - p.d)]
    if distance < d_e:
        return p.tau_s
    if distance <= p.d:
        return p.tau_e
    return p.tau_a


def perceived(q, points, p, slack):
    """K: the boundary points within r."""
    found = []
    for point in points:
        distance = np.linalg.norm(point - q)
        slack.append(abs(distance - p.r))
        if distance <= p.r:
            found.append(point)
    return found


def in_the_way(q, seen, q_gamma, p, slack):
    """Whether a perceived point lies ahead, before the gamma agent, within d_e of the line."""
    away = np.linalg.norm(q_gamma - q)
    forward = (q_gamma - q) / away
    left = np.array([-forward[1], forward[0]])
    found = False
    for point in seen:
        ahead = np.dot(point - q, forward)
        aside = abs(np.dot(point - q, left))
        slack += [abs(ahead), abs(ahead - away), abs(aside - warning_distance(p))]
        found = found or (0 < ahead <= away and aside <= warning_distance(p))
    return found


def by_phase(q, seen, towards, p, slack):
    """q_k(m) of (15), (16): phases from the axis to `towards`, sorted and compared in order."""
    axis = math.atan2(*(towards - q)[::-1])
    phases = sorted(
        ((math.atan2(*(point - q)[::-1]) - axis) % math.tau, tuple(point)) for point in seen
    )
    slack += [min(phase, math.tau - phase) for phase, _ in phases]
    if p.sense == "clockwise":
        phases = phases[::-1]
    for (one, point), (following, _) in pairwise(phases):
        slack += [abs(abs(following - one) - p.dtheta), abs(following - one)]
        if abs(following - one) >= p.dtheta:
            return np.array(point)
    return np.array(phases[-1][1])


def expected(q, memory, seen, goal, p, slack):
    """The memory after this look around: split and rejoin point, expected position (table 2)."""
    if goal is None:
        return replace(memory, scenario=0)
    q_gamma = goal[0]
    blocked = in_the_way(q, seen, q_gamma, p, slack)
    new = replace(memory, blocked=blocked)
    if memory.state == FREE:
        if not blocked:
            return replace(new, aim=q_gamma, scenario=4)
        return splits(q, new, seen, q_gamma, 1, p, slack)
    away, then = np.linalg.norm(q - q_gamma), np.linalg.norm(memory.split - q_gamma)
    slack.append(abs(away - then))
    if away <= then:
        new = replace(new, rejoin=q)
        if blocked:
            return splits(q, new, seen, q_gamma, 3, p, slack)
        return replace(new, state=FREE, aim=q_gamma, scenario=4)
    if blocked and not memory.blocked:
        return splits(q, new, seen, q_gamma, 1, p, slack)
    new = replace(new, scenario=2)
    return replace(new, aim=by_phase(q, seen, memory.split, p, slack)) if seen else new


def splits(q, memory, seen, q_gamma, scenario, p, slack):
    """An agent at a split point."""
    aim = by_phase(q, seen, q_gamma, p, slack)
    return replace(memory, state=FOLLOW, split=q, aim=aim, scenario=scenario)


def alpha(q, v, i, p, slack):
    """(13) and the consensus term of (8)."""
    force, consensus = np.zeros(2), np.zeros(2)
    for j in neighbours(q, i, p, slack):
        z = q[j] - q[i]
        s = sigma_norm(z, p.eps)
        weight = eta(np.linalg.norm(z), p, slack)
        force += weight * phi_alpha(s, p) * gradient(z, p.eps)
        consensus += bump(s / range_alpha(p), p.h) * (v[j] - v[i])
    return p.c1a * force, p.c2a * consensus


def beta(q, v, seen, memory, p, slack):
    """(14) and (18)."""
    force, tow = np.zeros(2), np.zeros(2)
    for point in seen:
        z = point - q
        s = sigma_norm(z, p.eps)
        force += eta(np.linalg.norm(z), p, slack) * phi_alpha(s, p) * gradient(z, p.eps)
        if memory.scenario:
            tow += bump(s / range_alpha(p), p.h) * ((memory.aim - q) / p.dt - v)
    return p.c1b * force, p.c2b * tow


def gamma(q, v, goal, p):
    if goal is None:
        return np.zeros(2)
    return -p.c1g * (q - goal[0]) - p.c2g * (v - goal[1])


def forces(q, v, memories, points, goal, p, slack):
    """The five terms of u_i (19), (N, 5, 2), and the new memories."""
    terms, after = [], []
    for i in range(len(q)):
        seen = perceived(q[i], points, p, slack)
        memory = expected(q[i], memories[i], seen, goal, p, slack)
        after.append(memory)
        terms.append(
            [
                *alpha(q, v, i, p, slack),
                *beta(q[i], v[i], seen, memory, p, slack),
                gamma(q[i], v[i], goal, p),
            ]
        )
    return np.array(terms), after
