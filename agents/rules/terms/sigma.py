"""What two agents of Olfati-Saber do to each other: sigma-norm, bump, action function, consensus.

Everything is smooth, written without a branch and without a call into a library, so that the sum
over a neighbourhood block becomes vector instructions. Equations are numbered as in Wu et al. 2023,
who repeat those of Olfati-Saber 2006.
"""

from __future__ import annotations

import math

from agents.engine.block import adjacent, is_neighbour
from agents.engine.vector_lanes import where
from agents.models.declare import Parameters, parameter
from worlds.compilation import compiled

QUARTER = 0.25 * math.pi

FORCES = (
    "alpha gradient",
    "alpha consensus",
    "beta gradient",
    "beta consensus",
    "gamma",
)
"""The terms of the control input u_i (7), m/s^2."""


class Interaction(Parameters):
    """Parameters that both rules share: lattice, potential and gains."""

    r: float = parameter(
        6.0,
        "Distance within which agents and obstacles are noticed",
        words="Vision radius",
        symbol="r",
        unit="m",
        low=0.5,
        high=30.0,
        proposed=(1.0, 20.0),
        step=0.5,
        source="Wu et al. 2023, (3), table 3",
    )
    d: float = parameter(
        4.0,
        "Distance that agents want to keep to each other",
        words="Wanted distance",
        symbol="d",
        unit="m",
        low=0.2,
        high=30.0,
        proposed=(0.5, 15.0),
        step=0.25,
        source="Wu et al. 2023, (8), table 3",
    )
    eps: float = parameter(
        0.5,
        "How soon the sigma-norm goes over from the square of a distance to the distance",
        words="Bend of the sigma-norm",
        symbol="\\varepsilon",
        low=0.01,
        high=10.0,
        step=0.05,
        source="Wu et al. 2023, (8), table 3",
    )
    h: float = parameter(
        0.2,
        "Share of the range from which influence fades out",
        words="Where influence fades",
        symbol="h",
        low=0.0,
        high=0.99,
        step=0.05,
        source="Wu et al. 2023, (9), table 3",
    )
    a: float = parameter(
        2.0,
        "Strength of the attraction",
        words="Attraction",
        symbol="a",
        unit="m/s^2",
        low=0.1,
        high=100.0,
        proposed=(0.1, 10.0),
        step=0.5,
        source="Wu et al. 2023, (8), table 3",
    )
    b: float = parameter(
        20.0,
        "Strength of the repulsion; at least a for a push stronger than the pull",
        words="Repulsion",
        symbol="b",
        unit="m/s^2",
        low=0.1,
        high=100.0,
        proposed=(1.0, 100.0),
        step=0.5,
        source="Wu et al. 2023, (8), table 3",
    )
    c1a: float = parameter(
        1.0,
        "Gain of attraction and repulsion between agents",
        words="Gain of the distances",
        symbol="c_1^\\alpha",
        low=0.0,
        high=50.0,
        step=0.1,
        source="Wu et al. 2023, (8), table 3",
    )
    c2a: float = parameter(
        1.0,
        "Gain of the agreement on a velocity",
        words="Gain of the velocities",
        symbol="c_2^\\alpha",
        unit="1/s",
        low=0.0,
        high=50.0,
        step=0.1,
        source="Wu et al. 2023, (8), table 3",
    )
    c1b: float = parameter(
        1.0,
        "Gain of the repulsion from obstacles",
        words="Gain off obstacles",
        symbol="c_1^\\beta",
        low=0.0,
        high=50.0,
        step=0.1,
        source="Wu et al. 2023, (10), table 3",
    )
    c2b: float = parameter(
        1.0,
        "Gain of the agreement with the velocity that an obstacle suggests",
        words="Gain along obstacles",
        symbol="c_2^\\beta",
        unit="1/s",
        low=0.0,
        high=50.0,
        step=0.1,
        source="Wu et al. 2023, (10), table 3",
    )
    c1g: float = parameter(
        1.0,
        "Gain of the pull to the gamma agent",
        words="Gain to the goal",
        symbol="c_1^\\gamma",
        low=0.0,
        high=50.0,
        step=0.1,
        source="Wu et al. 2023, (11), table 3",
    )
    c2g: float = parameter(
        1.0,
        "Gain of the agreement with the velocity of the gamma agent",
        words="Gain of the goal's velocity",
        symbol="c_2^\\gamma",
        unit="1/s",
        low=0.0,
        high=50.0,
        step=0.1,
        source="Wu et al. 2023, (11), table 3",
    )


@compiled
def stretch(d2, eps):
    """sqrt(1 + eps |z|^2) for |z|^2 = d2 >= 0: what |z|_sigma and its gradient share."""
    return math.sqrt(1.0 + eps * d2)


@compiled
def sigma_norm(d2, eps):
    """|z|_sigma for |z|^2 = d2 >= 0; its gradient is n = z / stretch(d2, eps)."""
    return (stretch(d2, eps) - 1.0) / eps


@compiled
def bump(z, h):
    """rho_h(z) (9) for z >= 0: 1 up to h, then falling smoothly to 0 at 1."""
    return fade(z, (z - h) / (1.0 - h))


@compiled
def fade(z, t):
    """rho_h(z) (9) from z and t = (z - h) / (1 - h).

    1/2 (1 + cos 2y) = cos^2 y = (1 - 2 sin^2 (y / 2))^2, with the sine of fdlibm on [0, pi / 4].
    """
    y = QUARTER * min(max(t, 0.0), 1.0)
    w = y * y
    s = y + y * w * (
        -1.66666666666666324348e-01
        + w
        * (
            8.33333333332248946124e-03
            + w
            * (
                -1.98412698298579493134e-04
                + w
                * (
                    2.75573137070700676789e-06
                    + w * (-2.50507602534068634195e-08 + w * 1.58969099521155010221e-10)
                )
            )
        )
    )
    cosine = 1.0 - 2.0 * s * s
    return where(z < 1.0, cosine * cosine, 0.0)


@compiled
def sigma_1(z):
    """sigma_1(z) = z / sqrt(1 + z^2), in (-1, 1)."""
    return z / math.sqrt(1.0 + z * z)


@compiled
def phi(z, a, b):
    """phi(z) (8): from -b far below 0 over 0 at z = 0 to a far above."""
    c = math.fabs(a - b) / math.sqrt(4.0 * a * b)
    return 0.5 * ((a + b) * sigma_1(z + c) + (a - b))


@compiled
def phi_alpha(s, p):
    """phi_alpha(s) (8) at the sigma-norm s of a distance; < 0 repels."""
    return bump(s / sigma_norm(p.r * p.r, p.eps), p.h) * phi(
        s - sigma_norm(p.d * p.d, p.eps), p.a, p.b
    )


@compiled
def push(d2, p):
    """phi_alpha(|z|_sigma) / stretch and rho_h(|z|_sigma / r_alpha), for |z|^2 = d2.

    The first, times the vector z to the other, is phi_alpha(|z|_sigma) n of (8). The two quotients
    of n and of sigma_1 are one division.
    """
    c = math.fabs(p.a - p.b) / math.sqrt(4.0 * p.a * p.b)
    wide = stretch(d2, p.eps)
    s = (wide - 1.0) / p.eps
    rho = bump(s / sigma_norm(p.r * p.r, p.eps), p.h)
    x = s - sigma_norm(p.d * p.d, p.eps) + c
    root = math.sqrt(1.0 + x * x)
    return rho * 0.5 * ((p.a + p.b) * x + (p.a - p.b) * root) / (root * wide), rho


@compiled
def level(d2, alarm, d, tau_a, tau_e, tau_s):
    """eta(|z|) (12) for |z|^2 = d2: tau_s nearer than `alarm`, tau_e up to d, tau_a beyond."""
    radius = where(d2 <= d * d, tau_e, tau_a)
    return where(d2 < alarm * alarm, tau_s, radius)


@compiled
def flockmate(me, other, p):
    """What another agent adds to the sums of (8): gradient (x, y, z) and consensus (x, y, z).

    Gains are not in it.
    """
    force, rho = push(other.d2, p)
    is_near = is_neighbour(other, p.r)
    f, w = is_near * force, is_near * rho
    return (
        f * other.dx,
        f * other.dy,
        f * other.dz,
        w * (other.speed * other.ux - me.speed * me.ux),
        w * (other.speed * other.uy - me.speed * me.uy),
        w * (other.speed * other.uz - me.speed * me.uz),
    )


@compiled
def weigh(me, near, p, out):
    """a_ij = rho_h(|q_j - q_i|_sigma / r_alpha), how much an agent heeds the velocity of others."""
    for j in range(near.n):
        dx = near.x[j] - me.x
        dy = near.y[j] - me.y
        dz = near.z[j] - me.z
        _, rho = push(dx * dx + dy * dy + dz * dz, p)
        out[j] = adjacent(me, near, j, p.r) * rho


@compiled
def has_goal(surroundings):
    """Whether there is a gamma agent."""
    return surroundings.route.shape[0] > 0


@compiled
def write_forces(force, out):
    """Write the rows (x, y, z) of FORCES into out (5, 3)."""
    for row in range(5):
        for axis in range(3):
            out[row, axis] = force[row][axis]
