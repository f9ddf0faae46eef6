"""The energy of a flock of Wu et al. 2023, and what their theorem 1 says of it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from agents.observables.array_checks import drop_bad_rows, is_finite, length, numbers, vectors
from worlds.input_error import InputError

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)


def sigma_norm(distance, eps: float):
    """|z|_sigma = (sqrt(1 + eps |z|^2) - 1) / eps of distances |z| >= 0, same shape; eps > 0.

    nan where a distance is. Raises InputError.

    >>> float(sigma_norm(4.0, 0.5))
    4.0
    """
    eps = length("eps", eps, positive=True)
    return (np.sqrt(1.0 + eps * np.square(numbers("distance", distance))) - 1.0) / eps


def action(s, p: Any):
    """phi_alpha(s) (8) at sigma-norms s >= 0, same shape, m/s^2; < 0 repels."""
    c = abs(p.a - p.b) / math.sqrt(4.0 * p.a * p.b)
    z = s - sigma_norm(p.d, p.eps) + c
    share = s / sigma_norm(p.r, p.eps)
    fade = 0.5 * (1.0 + np.cos(np.pi * np.clip((share - p.h) / (1.0 - p.h), 0.0, 1.0)))
    return fade * 0.5 * ((p.a + p.b) * z / np.sqrt(1.0 + z * z) + (p.a - p.b))


def integral(low, high, p: Any):
    """Integral of phi_alpha between sigma-norms (M,), by Gauss and Legendre on unit panels."""
    panels = math.ceil(sigma_norm(p.r, p.eps))
    at = (np.arange(panels)[:, None] + 0.5 * (NODES + 1.0)).ravel() / panels
    weight = np.tile(0.5 * WEIGHTS / panels, panels)
    span = high - low
    return span * (action(low[:, None] + span[:, None] * at, p) @ weight)


def potential(distance, p: Any) -> np.ndarray:
    """psi_alpha(|z|_sigma) (8) of distances (M,), m, in m^2/s^2: 0 at d, constant beyond r.

    nan where a distance is. Raises InputError for what are no numbers.
    Within 1e-12 of its largest value, since the two smooth pieces of the bump are integrated apart.
    """
    end = sigma_norm(p.r, p.eps)
    knot = np.full(1, p.h * end)

    def from_zero(s):
        return integral(np.zeros_like(s), np.minimum(s, knot), p) + integral(
            np.broadcast_to(knot, s.shape), np.maximum(s, knot), p
        )

    s = np.minimum(sigma_norm(np.atleast_1d(numbers("distance", distance)), p.eps), end)
    return from_zero(s) - from_zero(np.full(1, sigma_norm(p.d, p.eps)))


def urgency(distance, p: Any) -> np.ndarray:
    """eta (12) of distances (M,), m: tau_s nearer than d_e, tau_e up to d, tau_a beyond.

    nan where a distance is. Raises InputError for what are no numbers.
    """
    warning = p.d_min + 2.0 * p.p_max * p.dt
    distance = numbers("distance", distance)
    eta = np.where(distance < warning, p.tau_s, np.where(distance <= p.d, p.tau_e, p.tau_a))
    return np.where(np.isnan(distance), np.nan, eta)


def potential_sum(position: np.ndarray, other: np.ndarray, p: Any) -> float:
    """Sum of eta psi_alpha over all pairs within r of places (N, dim) and places (M, dim)."""
    if not len(position) or not len(other):
        return 0.0
    distance = np.linalg.norm(position[:, None] - other[None], axis=2)
    distance = distance[(distance > 0.0) & (distance <= p.r)]
    return float((urgency(distance, p) * potential(distance, p)).sum())


def hamiltonian(position, velocity, goal, points, p: Any) -> float:
    """H(q, p) (20) to (22) of a flock under boundary-point flocking, m^2/s^2.

    Parameters
    ----------
    position, velocity: (N, dim), m and m/s. goal: (2, dim), position and velocity of the gamma
        agent. points: (M, dim), all boundary points, m; M may be 0. Agents and points of which a
        number is missing are left out, with a warning.
    p: parameters of the model `boundary-points` (a flock's `parameters`).

    The potential of a pair counts once from either side, as printed: 1/2 (V_ij + V_ji). Nobody has
    the energy 0. Raises InputError. One agent alone:

    >>> from flockscope import model
    >>> p = model("boundary-points").parameters()
    >>> hamiltonian([[3.0, 4.0]], [[0.0, 1.0]], [[0.0, 0.0], [0.0, 0.0]], [], p)
    13.0
    """
    position, velocity = vectors("position", position), vectors("velocity", velocity)
    _, position, velocity = drop_bad_rows(position=position, velocity=velocity)
    dim = position.shape[1]
    ends = numbers("goal", goal)
    if ends.shape != (2, dim) or not is_finite(ends):
        raise InputError(
            f"goal = {ends.tolist()} is not allowed: a position and a velocity, (2, {dim}) finite "
            "numbers, are needed"
        )
    at, speed = ends
    points = numbers("points", points)
    points = vectors("points", points) if points.size else np.empty((0, dim))
    if points.shape[1] != dim:
        raise InputError(f"points have {points.shape[1]} axes and positions {dim}")
    _, points = drop_bad_rows(points=points)
    flock = p.c1a * potential_sum(position, position, p)
    boundary = 2.0 * p.c1b * potential_sum(position, points, p)
    pull = p.c1g * float(np.square(position - at).sum())
    return 0.5 * (flock + boundary + pull + float(np.square(velocity - speed).sum()))


def furthest(energy: float, p: Any) -> float:
    """sqrt(2 H_0 / c_1^gamma): no agent is ever further from a static gamma agent, m (theorem 1).

    `energy` is H at the start, m^2/s^2, >= 0, `p` the parameters as for `hamiltonian`. Without a
    pull to the gamma agent there is no bound: inf. Raises InputError.
    """
    energy = length("energy", energy)
    return math.sqrt(2.0 * energy / p.c1g) if p.c1g > 0.0 else math.inf
