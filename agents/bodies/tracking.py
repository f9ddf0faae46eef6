"""Errors of motion capture: noise of positions, and frames in which a car is not seen."""

from __future__ import annotations

import math

from agents.engine.noise import cos_sin, uniform
from agents.models.declare import Parameters, parameter
from worlds.compilation import compiled

RADIUS, ANGLE, YAW_RADIUS, YAW_ANGLE, SEEN = 4, 5, 6, 7, 8
"""Draws of the tracking's own noise."""


class Tracking(Parameters):
    """Parameters of the tracking, which rules and bodies share."""

    dt: float = parameter(
        0.01,
        "Time of a tick: a frame of the tracking and a command",
        words="Time of a tick",
        symbol="\\Delta t",
        unit="s",
        low=0.001,
        high=0.1,
        step=0.001,
        source="Jacobs and Koessler: the cameras have 100 Hz",
    )
    noise_xy: float = parameter(
        0.0005,
        "Noise of the tracked positions: standard deviation along each axis",
        words="Noise of positions",
        symbol="\\sigma_x",
        unit="m",
        low=0.0,
        high=0.2,
        proposed=(0.0, 0.005),
        step=0.0005,
        source="ours: what such cameras have",
        noise=True,
    )
    noise_yaw: float = parameter(
        0.005,
        "Noise of the tracked headings: standard deviation",
        words="Noise of headings",
        symbol="\\sigma_\\psi",
        unit="rad",
        low=0.0,
        high=0.5,
        proposed=(0.0, 0.05),
        step=0.001,
        source="ours: what such cameras have",
        noise=True,
    )
    dropout: float = parameter(
        0.0,
        "Share of the frames in which a car is not seen: it counts as where it was seen last, and "
        "its last command is sent again",
        words="Frames not seen",
        symbol="p_{drop}",
        low=0.0,
        high=1.0,
        step=0.01,
        source="ours: Jacobs and Koessler had ambiguous markers now and then",
        noise=True,
    )


@compiled
def normal_pair(key, agent, radius, angle):
    """Two independent normal numbers of variance 1, from the draws `radius` and `angle`."""
    length = math.sqrt(-2.0 * math.log(1.0 - uniform(key, agent, radius)))
    c, s = cos_sin(2.0 * math.pi * uniform(key, agent, angle))
    return length * c, length * s


@compiled
def is_seen(me, p):
    """Whether the tracking sees this car in this tick's frame."""
    return uniform(me.key, me.id, SEEN) >= p.dropout


@compiled
def error_of(me, p, x, y):
    """The error (m) of the position that the tracking tells of a car in this frame.

    (x, y) is the error if the car is not seen, infinite where it never was.
    """
    if is_seen(me, p) or not (math.fabs(x) < math.inf):
        nx, ny = normal_pair(me.key, me.id, RADIUS, ANGLE)
        return p.noise_xy * nx, p.noise_xy * ny
    return x, y


@compiled
def stale_error(me, p, x, y):
    """The error (m) that (x, y) becomes if the car is not seen in the next frame.

    It then counts as where it was, and has gone on, by about its velocity times the tick.
    """
    travelled = me.speed * p.dt
    return x - travelled * me.ux, y - travelled * me.uy


@compiled
def yaw_error(me, p):
    """The error (rad) of the heading that the tracking tells of a car in this frame."""
    n, _ = normal_pair(me.key, me.id, YAW_RADIUS, YAW_ANGLE)
    return p.noise_yaw * n
