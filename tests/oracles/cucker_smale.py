"""Cucker and Smale's flocking, agent by agent, as the paper of 2007 prints it.

Steps are those of a point mass: the velocity first, and the position by the new one.
"""

import numpy as np


def accelerations(x, v, p):
    """dv_i/dt = sum_j a_ij (v_j - v_i), those within r heard, (N, dim)."""
    found = np.zeros_like(v)
    for i in range(len(x)):
        for j in range(len(x)):
            d = np.linalg.norm(x[i] - x[j])
            if 0.0 < d <= p.r:
                found[i] += p.K / (p.sigma**2 + d**2) ** p.beta * (v[j] - v[i])
    return found


def step(x, v, p):
    """Positions and velocities after a tick."""
    v = v + p.dt / p.m * accelerations(x, v, p)
    return x + p.dt * v, v
