"""Naive pedestrians of Helbing and Molnar 1995, from the paper's potentials; nothing of the engine.

Forces are gradients of the potentials by a complex step, which is exact to rounding.
"""

from dataclasses import dataclass

import numpy as np

TINY = 1e-200


@dataclass(frozen=True)
class Setting:
    """Parameters as the paper names them."""

    r: float = 5.0
    tau: float = 0.5
    repulsion: float = 2.1
    sigma: float = 0.3
    step_time: float = 2.0
    border: float = 10.0
    r_border: float = 0.2
    fov: float = 200.0
    c: float = 0.5
    haste: float = 1.3
    dt: float = 0.05


def length(x, y):
    """Of a vector whose parts may be complex, without a conjugate."""
    return np.sqrt(x * x + y * y)


def potential(x, y, step, p):
    """V(b) at (x, y) from another whose step (2,) begins at the origin."""
    both = length(x, y) + length(x - step[0], y - step[1])
    b = np.sqrt(both * both - step @ step) / 2
    return p.repulsion * np.exp(-b / p.sigma)


def repelled(apart, speed, e, p):
    """-grad V at `apart` (2,) from another with this speed and desired direction e (2,)."""
    x, y = complex(apart[0]), complex(apart[1])
    step = p.step_time * speed * np.asarray(e)
    return -np.array(
        [
            potential(x + 1j * TINY, y, step, p).imag / TINY,
            potential(x, y + 1j * TINY, step, p).imag / TINY,
        ]
    )


def image(d, side):
    """A difference along the corridor to the nearest image."""
    return d - side * np.round(d / side)


def forces(i, x, v, e, v0, size, box, p):
    """Drive, pedestrians and walls on agent i, (3, 2), in a corridor with a box (low, high)."""
    drive = (v0[i] * e[i] - v[i]) / p.tau
    others, walls = np.zeros(2), np.zeros(2)
    for j in range(len(x)):
        apart = np.array([image(x[i, 0] - x[j, 0], size[0]), x[i, 1] - x[j, 1]])
        if j == i or np.linalg.norm(apart) > p.r:
            continue
        f = repelled(apart, np.linalg.norm(v[j]), e[j], p)
        seen = e[i] @ -f >= np.linalg.norm(f) * np.cos(np.radians(p.fov / 2))
        others += f if seen else p.c * f
    middle, half = np.add(*box) / 2, np.subtract(box[1], box[0]) / 2
    away = np.array([image(x[i, 0] - middle[0], size[0]), x[i, 1] - middle[1]])
    away -= np.clip(away, -half, half)
    gap = np.linalg.norm(away)
    for distance, normal in (
        (x[i, 1], np.array([0.0, 1.0])),
        (size[1] - x[i, 1], np.array([0.0, -1.0])),
        (gap, away / gap),
    ):
        if distance <= p.r:
            walls += p.border / p.r_border * np.exp(-distance / p.r_border) * normal
    return np.array([drive, others, walls])


def step(x, v, e, v0, size, box, p):
    """Positions and velocities (N, 2) after a tick; positions are not brought back into the box."""
    new = np.empty_like(v)
    for i in range(len(x)):
        w = v[i] + p.dt * forces(i, x, v, e, v0, size, box, p).sum(axis=0)
        most = p.haste * v0[i]
        new[i] = w * min(1.0, most / np.linalg.norm(w)) if w.any() else w
    return x + p.dt * new, new
