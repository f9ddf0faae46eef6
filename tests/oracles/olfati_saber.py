"""Olfati-Saber's flocking, agent by agent, as Wu et al. 2023, 2.2, print it.

Velocities are clamped before positions follow, with a step of h seconds. `p` has the parameters by
name. Whatever is compared with a threshold is noted in `slack`, as the distance to it, so that a
test can leave out what hangs on the last bits.
"""

import math

import numpy as np
import shapely


def sigma_norm(z, eps):
    return (math.sqrt(1 + eps * np.dot(z, z)) - 1) / eps


def gradient(z, eps):
    """n_ij: the gradient of the sigma-norm at z."""
    return z / math.sqrt(1 + eps * np.dot(z, z))


def bump(z, h):
    if 0 <= z < h:
        return 1.0
    if h <= z <= 1:
        return 0.5 * (1 + math.cos((z - h) * math.pi / (1 - h)))
    return 0.0


def sigma_1(z):
    """Of a number or a vector."""
    return z / math.sqrt(1 + np.dot(z, z))


def phi(z, p):
    c = abs(p.a - p.b) / math.sqrt(4 * p.a * p.b)
    return 0.5 * ((p.a + p.b) * sigma_1(z + c) + (p.a - p.b))


def range_alpha(p):
    return sigma_norm(np.array([p.r]), p.eps)


def phi_alpha(s, p):
    return bump(s / range_alpha(p), p.h) * phi(s - sigma_norm(np.array([p.d]), p.eps), p)


def phi_beta(s, p):
    d_beta = sigma_norm(np.array([p.d_beta]), p.eps)
    return bump(s / d_beta, p.h) * (sigma_1(s - d_beta) - 1)


def neighbours(q, i, p, slack):
    """N_i^alpha (3)."""
    found = []
    for j in range(len(q)):
        if j != i:
            distance = np.linalg.norm(q[j] - q[i])
            slack.append(abs(distance - p.r))
            if distance <= p.r:
                found.append(j)
    return found


def alpha(q, v, i, p, slack):
    """Gradient and consensus terms of (8)."""
    force = np.zeros_like(q[i])
    consensus = np.zeros_like(q[i])
    for j in neighbours(q, i, p, slack):
        z = q[j] - q[i]
        s = sigma_norm(z, p.eps)
        force += phi_alpha(s, p) * gradient(z, p.eps)
        consensus += bump(s / range_alpha(p), p.h) * (v[j] - v[i])
    return p.c1a * force, p.c2a * consensus


def shadows(obstacles, q):
    """The nearest point of each obstacle (`worlds.obstacles`); none of them touch."""
    return [shadow(one, q) for one in obstacles]


def shadow(obstacle, q):
    """The nearest point of a sphere or a disc or, in the plane, of an outline without holes."""
    if obstacle.shape in ("sphere", "disc"):
        centre = np.array(obstacle.centre)
        return centre + obstacle.radius * (q - centre) / np.linalg.norm(q - centre)
    ring = obstacle.footprint().exterior
    return np.array(ring.interpolate(ring.project(shapely.Point(q))).coords[0])


def beta(points, q, v, p, slack):
    """Gradient and consensus terms of (10) for beta agents at `points` with velocities P p."""
    force, consensus = np.zeros_like(q), np.zeros_like(q)
    d_beta = sigma_norm(np.array([p.d_beta]), p.eps)
    for q_hat in points:
        z = q_hat - q
        slack.append(abs(np.linalg.norm(z) - p.r))
        if np.linalg.norm(z) > p.r:
            continue
        s = sigma_norm(z, p.eps)
        a_k = -z / np.linalg.norm(z)
        projection = np.eye(len(q)) - np.outer(a_k, a_k)
        p_hat = projection @ v
        if p.beta == "printed":
            force += phi_beta(s, p) * gradient(z, p.eps)
            consensus += bump(s / d_beta, p.h) * (p_hat - v)
        else:
            force += phi_alpha(s, p) * gradient(z, p.eps)
            consensus += bump(s / range_alpha(p), p.h) * (p_hat - v)
    return p.c1b * force, p.c2b * consensus


def gamma(q, v, goal, p):
    """(11); `goal` is (2, dim) or None."""
    if goal is None:
        return np.zeros_like(q)
    return -p.c1g * sigma_1(q - goal[0]) - p.c2g * (v - goal[1])


def forces(q, v, nearest, goal, p, slack):
    """The five terms of u_i for every agent, (N, 5, dim); `nearest` has each agent's `shadows`."""
    return np.array(
        [
            [
                *alpha(q, v, i, p, slack),
                *beta(nearest[i], q[i], v[i], p, slack),
                gamma(q[i], v[i], goal, p),
            ]
            for i in range(len(q))
        ]
    )


def moved(q, v, u, p):
    """One step of h seconds of (2): the velocity first, clamped, then the position."""
    h = p.dt / round(p.n_sub)
    v = v + h * u
    for i in range(len(v)):
        speed = np.linalg.norm(v[i])
        if speed > p.p_max:
            v[i] = v[i] * p.p_max / speed
    return q + h * v, v
