"""D'Orsogna's particles one by one, with the force as the slope of the printed potential."""

import numpy as np


def potential(x, p):
    """U (2) of all pairs, each counted once."""
    total = 0.0
    for i in range(len(x)):
        for j in range(i):
            d = np.linalg.norm(x[i] - x[j])
            total += p.C_r * np.exp(-d / p.l_r) - p.C_a * np.exp(-d / p.l_a)
    return total


def terms(x, v, p):
    """Self-propulsion, repulsion and attraction (1), (N, 3, dim)."""
    found = np.zeros((len(x), 3, x.shape[1]))
    for i in range(len(x)):
        found[i, 0] = (p.alpha - p.beta * (v[i] @ v[i])) * v[i]
        for j in range(len(x)):
            d = np.linalg.norm(x[i] - x[j])
            if d > 0.0:
                away = (x[i] - x[j]) / d
                found[i, 1] += p.C_r / p.l_r * np.exp(-d / p.l_r) * away
                found[i, 2] -= p.C_a / p.l_a * np.exp(-d / p.l_a) * away
    return found


def step(x, v, p):
    """Positions and velocities after a tick of a point mass."""
    v = v + p.dt / p.m * terms(x, v, p).sum(axis=1)
    return x + p.dt * v, v
