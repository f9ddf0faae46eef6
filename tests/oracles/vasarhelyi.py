"""Naive drones of Vasarhelyi et al. 2018, from the paper's equations; nothing of the engine."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Setting:
    """Parameters as the paper names them; v0 to a_max are the robot's."""

    r: float = 100.0
    v_flock: float = 4.0
    r0_rep: float = 25.6668
    p_rep: float = 0.13
    r0_frict: float = 85.3
    c_frict: float = 0.05
    v_frict: float = 0.63
    p_frict: float = 3.2
    a_frict: float = 4.16
    r0_shill: float = 0.3
    v_shill: float = 13.6
    p_shill: float = 3.55
    a_shill: float = 3.02
    dt: float = 0.1
    tau: float = 1.0
    a_max: float = 6.0
    v_max: float = 6.0


def braking(r, a, p):
    """The braking curve D."""
    if r <= 0:
        return 0.0
    if r * p < a / p:
        return r * p
    return np.sqrt(2 * a * r - a**2 / p**2)


def aligned(v, other, most, c):
    """What brings v nearer to `other`, if their difference is more than `most`."""
    difference = np.linalg.norm(v - other)
    if difference <= most:
        return np.zeros(len(v))
    return c * (difference - most) * (other - v) / difference


def terms(i, x, v, ahead, solids, p):
    """Self-propulsion, repulsion, alignment and shill terms of agent i, (4, dim).

    `ahead` (N, dim) are the directions of v, and at rest those last flown in.
    """
    propulsion = p.v_flock * ahead[i]
    repulsion = np.zeros(len(x[i]))
    alignment = np.zeros(len(x[i]))
    for j in range(len(x)):
        apart = x[i] - x[j]
        r = np.linalg.norm(apart)
        if j == i or r == 0 or r > p.r:
            continue
        if r < p.r0_rep:
            repulsion += p.p_rep * (p.r0_rep - r) * apart / r
        most = max(p.v_frict, braking(r - p.r0_frict, p.a_frict, p.p_frict))
        alignment += aligned(v[i], v[j], most, p.c_frict)
    shill = np.zeros(len(x[i]))
    for solid in solids:
        distance, normal = solid(x[i])
        if distance <= p.r:
            most = braking(distance - p.r0_shill, p.a_shill, p.p_shill)
            shill += aligned(v[i], p.v_shill * normal, most, 1.0)
    return np.array([propulsion, repulsion, alignment, shill])


def fly(x, v, wanted, p):
    """One tick of the robot: position and velocity."""
    speed = np.linalg.norm(wanted)
    if speed > p.v_max:
        wanted = wanted / speed * p.v_max
    change = (wanted - v) * p.dt / p.tau
    if np.linalg.norm(change) > p.a_max * p.dt:
        change = change / np.linalg.norm(change) * p.a_max * p.dt
    v = v + change
    return x + v * p.dt, v


def step(x, heading, speed, solids, p):
    """Positions and velocities (N, dim) after a tick without a guard."""
    v = speed[:, None] * heading
    flown = [
        fly(x[i], v[i], terms(i, x, v, heading, solids, p).sum(axis=0), p) for i in range(len(x))
    ]
    return np.array([a for a, _ in flown]), np.array([b for _, b in flown])
