"""Naive boids of Reynolds 1987 and 1999, written from the texts; nothing of the engine."""

from dataclasses import dataclass

import numpy as np

from .solids import nearest


@dataclass(frozen=True)
class Setting:
    """Radii, weights and limits; `fov` in degrees."""

    r: float = 5.0
    fov: float = 270.0
    r_separation: float = 1.5
    r_alignment: float = 4.0
    r_cohesion: float = 5.0
    w_separation: float = 2.0
    w_alignment: float = 2.0
    w_cohesion: float = 0.6
    w_avoidance: float = 4.0
    look_ahead: float = 4.0
    clearance: float = 1.0
    w_seek: float = 0.5
    dt: float = 0.05
    max_force: float = 8.0
    max_speed: float = 4.0
    min_speed: float = 2.0
    probes: int = 5


def truncate(vector, most):
    """The vector, at most `most` long."""
    length = np.linalg.norm(vector)
    return vector * most / length if length > most else vector


def angle_off(heading, to):
    """Angle (degrees) between the heading and the direction `to`."""
    cosine = heading @ to / np.linalg.norm(to)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def neighbourhood(i, x, heading, radius, p):
    """Those whom i sees within the radius."""
    found = []
    for j in range(len(x)):
        to = x[j] - x[i]
        d = np.linalg.norm(to)
        near = 0 < d <= min(radius, p.r)
        if near and (p.fov >= 360 or angle_off(heading[i], to) <= p.fov / 2):
            found.append(j)
    return found


def separation(i, x, heading, p):
    """Away from each neighbour with weight 1/r."""
    away = np.zeros(len(x[i]))
    for j in neighbourhood(i, x, heading, p.r_separation, p):
        d = np.linalg.norm(x[i] - x[j])
        away += (x[i] - x[j]) / d * (p.r_separation / d)
    return truncate(away, 1)


def alignment(i, x, heading, v, p):
    """Towards the mean velocity."""
    others = neighbourhood(i, x, heading, p.r_alignment, p)
    if not others:
        return np.zeros(len(x[i]))
    return truncate((v[others].mean(axis=0) - v[i]) / p.max_speed, 1)


def cohesion(i, x, heading, p):
    """Towards the centre."""
    others = neighbourhood(i, x, heading, p.r_cohesion, p)
    if not others:
        return np.zeros(len(x[i]))
    return truncate((x[others].mean(axis=0) - x[i]) / p.r_cohesion, 1)


def avoidance(i, x, heading, solids, p):
    """Across the heading, away from the first surface that a probe comes too close to."""
    u = heading[i]
    for k in range(p.probes):
        distance, normal = nearest(solids, x[i] + u * p.look_ahead * k / (p.probes - 1))
        if distance >= p.clearance or normal @ u > 1e-6:
            continue
        across = normal - (normal @ u) * u
        length = np.linalg.norm(across)
        if length < 1e-6:
            flat = np.hypot(u[0], u[1])
            left = [-u[1] / flat, u[0] / flat, 0.0] if flat >= 1e-6 else [1.0, 0.0, 0.0]
            across, length = np.array(left[: len(u)]), 1.0
        return (1 - k / p.probes) * across / length
    return np.zeros(len(u))


def seek(i, x, v, goal, p):
    """The velocity that is wanted towards the goal, less one's own."""
    if goal is None:
        return np.zeros(len(x[i]))
    to = goal - x[i]
    return truncate(to / np.linalg.norm(to) - v[i] / p.max_speed, 1)


def terms(i, x, heading, speed, solids, goal, p):
    """The five weighted steering forces of boid i, (5, dim)."""
    v = speed[:, None] * heading
    return p.max_force * np.array(
        [
            p.w_separation * separation(i, x, heading, p),
            p.w_alignment * alignment(i, x, heading, v, p),
            p.w_cohesion * cohesion(i, x, heading, p),
            p.w_avoidance * avoidance(i, x, heading, solids, p),
            p.w_seek * seek(i, x, v, goal, p),
        ]
    )


def step(x, heading, speed, solids, goal, p):
    """Positions and velocities (N, dim) after a tick without a guard."""
    position, velocity = x.copy(), np.zeros_like(x)
    for i in range(len(x)):
        force = truncate(terms(i, x, heading, speed, solids, goal, p).sum(axis=0), p.max_force)
        v = speed[i] * heading[i] + p.dt * force
        length = np.linalg.norm(v)
        along = v / length if length > 0 else heading[i]
        velocity[i] = along * min(max(length, p.min_speed), p.max_speed)
        position[i] = x[i] + p.dt * velocity[i]
    return position, velocity
