"""Active Brownian particles one by one; noise apart, and what is known of a free one."""

import numpy as np


def velocities(x, u, p):
    """v0 u_i + mu sum_j k (d - r_ij) away from j, (N, dim)."""
    found = p.v0 * u
    for i in range(len(x)):
        for j in range(len(x)):
            r = np.linalg.norm(x[i] - x[j])
            if 0.0 < r < p.d:
                found[i] = found[i] + p.mu * p.k * (p.d - r) * (x[i] - x[j]) / r
    return found


def squared_displacement(t, dim, v0, D_r, D_t=0.0):
    """Mean square displacement of a free particle after a time, length^2."""
    tau = 1.0 / ((dim - 1) * D_r)
    return 2 * dim * D_t * t + 2 * (v0 * tau) ** 2 * (t / tau - 1 + np.exp(-t / tau))
