"""Naive inertial spin model of Attanasi et al. 2014, from its equations; nothing of the engine."""

import numpy as np


def images(d, size):
    """Separations (dim,) to the nearest image; none where `size` is None."""
    return d if size is None else d - size * np.round(d / size)


def in_space(v):
    """A vector of the plane as one of space."""
    return np.append(v, 0.0) if len(v) == 2 else np.asarray(v)


def turned(v, axis, angle):
    """v turned about a unit axis (Rodrigues)."""
    return (
        v * np.cos(angle)
        + np.cross(axis, v) * np.sin(angle)
        + axis * (axis @ v) * (1 - np.cos(angle))
    )


def step(x, u, s, p, size=None):
    """Positions (N, dim), headings (N, dim) and spins (N, 3) after a tick without noise.

    `p` has r, J, chi, eta, v0, dt.
    """
    dim = x.shape[1]
    new_u, new_s = np.empty_like(u), np.empty_like(s)
    for i in range(len(x)):
        v = in_space(p["v0"] * u[i])
        pull = np.zeros(3)
        for j in range(len(x)):
            if j != i and np.linalg.norm(images(x[j] - x[i], size)) <= p["r"]:
                pull += in_space(p["v0"] * u[j])
        torque = p["J"] / p["v0"] ** 2 * np.cross(v, pull)
        # the torque at once, then ds/dt = - v x (eta / v0^2) dv/dt = -(eta / chi) s, solved
        spin = s[i] + p["dt"] * torque
        a = p["dt"] * p["eta"] / p["chi"]
        angle = np.linalg.norm(spin) / p["chi"] * p["dt"] * (-np.expm1(-a) / a if a > 0 else 1)
        if angle > 0:
            v = turned(v, spin / np.linalg.norm(spin), angle)
        spin = np.exp(-a) * spin
        new_s[i], new_u[i] = spin, v[:dim] / p["v0"]
    return x + p["dt"] * p["v0"] * new_u, new_u, new_s
