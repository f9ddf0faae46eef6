"""Flocking with obstacle avoidance of Olfati-Saber 2006, as Wu et al. 2023, 2.2, repeat it.

Every agent knows the gamma agent. Each obstacle within r is a beta agent at its nearest point,
which moves along the surface as the agent's projection: p_hat = P p, for walls and curves alike.
Obstacles that touch are one obstacle. Printed, the push of a beta agent is at most 2 c_1^beta where
flock-mates push with up to 19, and agents are pushed through obstacles; so by default it pushes as
an agent does (see the parameter `beta`).
"""

from __future__ import annotations

import math
from typing import Literal

from agents.engine.block import Decision
from agents.models.declare import Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.terms.sigma import (
    FORCES,
    Interaction,
    bump,
    flockmate,
    has_goal,
    push,
    sigma_1,
    sigma_norm,
    stretch,
    weigh,
    write_forces,
)
from agents.rules.terms.sums import of_pairs, sums_around
from worlds.compilation import compiled
from worlds.queries.surroundings import solids_around, surface

PRINTED = 1.0
"""Index of `printed` among the choices of `beta`."""


class OlfatiSaber(Interaction):
    """Parameters of Olfati-Saber's rule."""

    beta: Literal["alpha-form", "printed"] = parameter(
        "alpha-form",
        "Whether obstacles act as agents do, phi_alpha within r, or with the bounded phi_beta "
        "within d_beta as printed",
        words="Force of obstacles",
        symbol="\\phi_\\beta",
        source="Wu et al. 2023, (10), (14)",
    )
    d_beta: float = parameter(
        4.0,
        "Distance at which the printed phi_beta begins to push agents off an obstacle",
        words="Distance to obstacles",
        symbol="d'",
        unit="m",
        low=0.2,
        high=30.0,
        proposed=(0.5, 15.0),
        step=0.25,
        source="Wu et al. 2023, (10); no value is given, so that of d",
    )


@compiled
def printed_push(d2, p):
    """phi_beta(|z|_sigma) / stretch and b_ik, for |z|^2 = d2: (10) with sigma_1(s - d_beta)."""
    s = sigma_norm(d2, p.eps)
    d_beta = sigma_norm(p.d_beta * p.d_beta, p.eps)
    rho = bump(s / d_beta, p.h)
    return rho * (sigma_1(s - d_beta) - 1.0) / stretch(d2, p.eps), rho


@compiled
def beta_terms(me, surroundings, p):
    """Gradient and consensus (10) summed over the solids within r, without the gains.

    With n the normal of a solid's nearest surface, P = I - n n^T, and so p_hat - p = P p - p =
    -(n . p) n.
    """
    vx, vy, vz = me.speed * me.ux, me.speed * me.uy, me.speed * me.uz
    fx = fy = fz = cx = cy = cz = 0.0
    nearby = solids_around(surroundings, me.x, me.y)
    for k in range(nearby.number):
        at = surface(surroundings, nearby, k, me.x, me.y, me.z)
        if math.fabs(at.distance) <= p.r:
            dx, dy, dz = at.x - me.x, at.y - me.y, at.z - me.z
            d2 = dx * dx + dy * dy + dz * dz
            f, rho = printed_push(d2, p) if p.beta == PRINTED else push(d2, p)
            inward = rho * (vx * at.nx + vy * at.ny + vz * at.nz)
            fx += f * dx
            fy += f * dy
            fz += f * dz
            cx -= inward * at.nx
            cy -= inward * at.ny
            cz -= inward * at.nz
    return fx, fy, fz, cx, cy, cz


@compiled
def lead(me, surroundings, p):
    """u^gamma (11); nothing where there is no gamma agent."""
    if not has_goal(surroundings):
        return 0.0, 0.0, 0.0
    x, y, z = (
        me.x - surroundings.goal[0, 0],
        me.y - surroundings.goal[0, 1],
        me.z - surroundings.goal[0, 2],
    )
    pull = p.c1g / stretch(x * x + y * y + z * z, 1.0)
    return (
        -pull * x - p.c2g * (me.speed * me.ux - surroundings.goal[1, 0]),
        -pull * y - p.c2g * (me.speed * me.uy - surroundings.goal[1, 1]),
        -pull * z - p.c2g * (me.speed * me.uz - surroundings.goal[1, 2]),
    )


@compiled
def terms(me, sums, surroundings, p):
    """The terms of u_i (7), a row (x, y, z) for each of FORCES, m/s^2."""
    fx, fy, fz, cx, cy, cz = sums
    bx, by, bz, ex, ey, ez = beta_terms(me, surroundings, p)
    return (
        (p.c1a * fx, p.c1a * fy, p.c1a * fz),
        (p.c2a * cx, p.c2a * cy, p.c2a * cz),
        (p.c1b * bx, p.c1b * by, p.c1b * bz),
        (p.c2b * ex, p.c2b * ey, p.c2b * ez),
        lead(me, surroundings, p),
    )


@compiled
def answer(me, sums, surroundings, p):
    """u_i = u_i^alpha + u_i^beta + u_i^gamma (7)."""
    f, c, b, e, g = terms(me, sums, surroundings, p)
    return Decision(
        f[0] + c[0] + b[0] + e[0] + g[0],
        f[1] + c[1] + b[1] + e[1] + g[1],
        f[2] + c[2] + b[2] + e[2] + g[2],
    )


around = sums_around(6, flockmate)


@compiled
def explain(me, near, surroundings, p, out):
    """The terms of (7) one by one."""
    write_forces(terms(me, around(me, near, p), surroundings, p), out)


RULE = Rule(
    name="olfati-saber",
    title="Olfati-Saber flocking",
    summary="Agents form a lattice of spacing d, agree on a velocity and follow a gamma agent; "
    "each obstacle near by is a beta agent at its nearest point.",
    equation=r"u_i = \sum_{j \in \mathcal{N}_i} \big[c_1^\alpha \phi_\alpha(\|q_j - q_i\|_\sigma)"
    r"\, n_{ij} + c_2^\alpha a_{ij} (p_j - p_i)\big] + \sum_{k \in \mathcal{N}_i^\beta} \big["
    r"c_1^\beta \phi_\beta(\|\hat q_{ik} - q_i\|_\sigma)\, \hat n_{ik} + c_2^\beta b_{ik} "
    r"(\hat p_{ik} - p_i)\big] - c_1^\gamma \sigma_1(q_i - q_\gamma) - c_2^\gamma (p_i - p_\gamma)",
    source="Olfati-Saber 2006; Wu et al. 2023, (7) to (11)",
    checked="among two discs and a wall: {wu2023-fig5#1} (`flockscope paper wu2023-fig5`)",
    tags=("robotics", "lattice", "formation", "obstacles", "control", "swarm"),
    parameters=OlfatiSaber,
    **of_pairs(6, flockmate, answer),
    wish="acceleration",
    weigh=weigh,
    forces=FORCES,
    explain=explain,
    sees_obstacles=True,
    led=False,
    tries=(
        LessonStep(
            "Let agents want to be 2.5 m apart instead of 4 m.",
            "The lattice draws together, so tightly that everybody has about twenty others "
            "within reach.",
            {"d": 2.5},
            LessonCheck("nearest-neighbour", "below", 2.4, 400),
            anew=True,
        ),
        LessonStep(
            "Take the pull of the gamma agent away.",
            "The flock falls into about ten groups: attraction alone reaches only so far, and "
            "it is the goal that holds all together.",
            {"c1g": 0.0, "c2g": 0.0},
            LessonCheck("groups", "above", 5, 400),
            anew=True,
        ),
        LessonStep(
            "Let agents want to be 7 m apart, and notice each other within 10 m.",
            "The lattice grows until it is nearly twice as wide.",
            {"d": 7.0, "r": 10.0},
            LessonCheck("nearest-neighbour", "above", 5.5, 400),
            anew=True,
        ),
    ),
)
