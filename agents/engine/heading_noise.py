"""From a rule's wish to the wanted heading: the noise, and what keeps a heading."""

from __future__ import annotations

import math

from agents.engine.block import Decision
from agents.engine.noise import VECTORIAL, random_direction, turned
from agents.engine.vector_lanes import where
from worlds.compilation import compiled

KEEP = 1e-12
"""A wish shorter than this has no direction: the heading is kept."""


@compiled
def headed(me, wish, noise, eta, dim):
    """The wanted heading, a unit Wish: the wish with its noise; without a wish, the old one."""
    x, y, z = wish.x, wish.y, wish.z
    if noise == VECTORIAL and eta > 0.0:
        lost = x * x + y * y + z * z < KEEP * KEEP
        ex, ey, ez = random_direction(me.key, me.id, dim)
        x = where(lost, me.ux, x) + eta * ex
        y = where(lost, me.uy, y) + eta * ey
        z = where(lost, me.uz, z) + eta * ez
    length = math.sqrt(x * x + y * y + z * z)
    lost = length < KEEP
    length = where(lost, 1.0, length)
    x = where(lost, me.ux, x / length)
    y = where(lost, me.uy, y / length)
    z = where(lost, me.uz, z / length)
    if noise != VECTORIAL and eta > 0.0:
        x, y, z = turned(x, y, z, eta, me.key, me.id, dim)
    return Decision(x, y, z)
