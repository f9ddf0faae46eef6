"""Chen and Kolokolnikov's prey and their predator, agent by agent, and the ring at rest."""

import numpy as np


def prey_velocities(x, z, a, b, r):
    """dx_j/dt of prey (N, 2) beside a predator at z (2,), or None, (N, 2).

    1/N sum_k [(x_j - x_k) / |x_j - x_k|^2 - a (x_j - x_k)] + b (x_j - z) / |x_j - z|^2, where N
    are those within r.
    """
    found = np.zeros_like(x)
    for j in range(len(x)):
        n = 1
        for k in range(len(x)):
            away = x[j] - x[k]
            d2 = away @ away
            if 0.0 < d2 <= r * r:
                found[j] += away / d2 - a * away
                n += 1
        found[j] /= n
        if z is not None:
            found[j] += b * (x[j] - z) / ((x[j] - z) @ (x[j] - z))
    return found


def predator_velocity(x, z, c, p):
    """dz/dt = c/N sum_k (x_k - z) / |x_k - z|^p, (2,)."""
    to = x - z
    return c * (to / np.linalg.norm(to, axis=1)[:, None] ** p).mean(axis=0)


def step(x, z, dt, a, b, c, p, r=np.inf):
    """Prey and predator after a step of Euler."""
    return (
        x + dt * prey_velocities(x, z, a, b, r),
        z + dt * predator_velocity(x, z, c, p),
    )


def mean_square_at_rest(n, a, b):
    """Mean square distance of n prey to their centre where nobody moves, exactly."""
    return (1.0 - 1.0 / n + 2.0 * b) / (2.0 * a)
