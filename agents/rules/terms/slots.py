"""The upwash slots beside the birds ahead, and how a bird closes up to one.

A slot is the place `step` spans behind a bird, on its line of flight's height, where the wing tips
are at the spacing `tip` (thesis, 2.3).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from agents.rules.terms.zone_sums import edge_of
from worlds.compilation import compiled

CLOSE, LONG = 0.6, 4.0
"""How near to a slot a bird takes it, and how far behind a bird its downwash spoils it, spans."""
PARALLEL = math.cos(math.radians(45.0))
"""Least cosine of the angle to the heading of a bird that is followed."""
LEVEL = 1e-12
"""Square of the level part of a heading from which on it has a left and a right."""


class Slot(NamedTuple):
    """The slot that a bird goes for, and the bird ahead beside which it is."""

    ahead: int
    """Its place in the block; -1 for no slot."""
    seen: bool
    """Whether there is a bird ahead at all."""
    x: float
    """From this bird to the slot."""
    y: float
    z: float


@compiled
def is_free(me, near, ahead, x, y, z, apart2, b):
    """Whether the slot at (x, y, z) beside the bird `ahead` is free for this one.

    It is taken by a bird within 0.6 spans `b` of it that is nearer to it than this one (`apart2` is
    the square of this one's distance). It is spoilt by the downwash of a bird if it lies straight
    behind that one: within 4 spans, and less than 0.6 spans off its line of flight.
    """
    close2 = (CLOSE * b) ** 2
    against = 0.0
    for k in range(near.n):
        ex, ey, ez = x - near.x[k], y - near.y[k], z - near.z[k]
        mx, my, mz = me.x - near.x[k], me.y - near.y[k], me.z - near.z[k]
        d2 = ex * ex + ey * ey + ez * ez
        behind = -(ex * near.ux[k] + ey * near.uy[k] + ez * near.uz[k])
        other = (mx * mx + my * my + mz * mz > 0.0) & (k != ahead)
        taken = (d2 < close2) & (d2 < apart2)
        spoilt = (behind > 0.0) & (behind < LONG * b) & (d2 - behind * behind < close2)
        against += 1.0 if other & (taken | spoilt) else 0.0
    return against == 0.0


@compiled
def nearest_slot(me, near, p):
    """The nearest free slot beside a bird ahead that is seen and flies about the same way.

    Ahead is where that bird is further on along its own heading; slots are to its left and right.
    """
    edge = edge_of(p.alpha)
    aside, back = (1.0 + p.tip) * p.b, p.step * p.b
    best = math.inf
    ahead, seen = -1, False
    x = y = z = 0.0
    for j in range(near.n):
        ux, uy, uz = near.ux[j], near.uy[j], near.uz[j]
        dx, dy, dz = near.x[j] - me.x, near.y[j] - me.y, near.z[j] - me.z
        d2 = dx * dx + dy * dy + dz * dz
        level2 = ux * ux + uy * uy
        followed = (
            (d2 > 0.0)
            & (d2 <= p.d_a * p.d_a)
            & (dx * ux + dy * uy + dz * uz > 0.0)
            & (ux * me.ux + uy * me.uy + uz * me.uz >= PARALLEL)
            & (dx * me.ux + dy * me.uy + dz * me.uz >= edge * math.sqrt(d2))
            & (level2 > LEVEL)
        )
        if followed:
            seen = True
            level = math.sqrt(level2)
            for side in (-1.0, 1.0):
                sx = dx - back * ux + side * aside * uy / level
                sy = dy - back * uy - side * aside * ux / level
                sz = dz - back * uz
                a2 = sx * sx + sy * sy + sz * sz
                if a2 < best and is_free(me, near, j, me.x + sx, me.y + sy, me.z + sz, a2, p.b):
                    best, ahead, x, y, z = a2, j, sx, sy, sz
    return Slot(ahead, seen, x, y, z)


@compiled
def closing_up(near, slot, p):
    """Velocity wished for: that of the bird ahead, and towards the slot, slower once it is near."""
    pace = near.speed[slot.ahead]
    far = math.sqrt(slot.x * slot.x + slot.y * slot.y + slot.z * slot.z)
    rate = min(1.0 / p.t_c, p.c / max(far, 1e-12))
    return (
        pace * near.ux[slot.ahead] + rate * slot.x,
        pace * near.uy[slot.ahead] + rate * slot.y,
        pace * near.uz[slot.ahead] + rate * slot.z,
    )
