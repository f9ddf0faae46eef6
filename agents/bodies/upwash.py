"""Upwash: the share of a bird's induced drag that the vortices of the birds around it take away.

Every bird is a lifting line of elliptic loading whose wake is a pair of vortices pi b / 4 apart,
b the wing span (thesis 2.3; lift and spacing fix the circulation). Each leg of the pair begins at
the bird and runs straight back against its heading. The upwash that a leg makes is averaged over
the span of another bird with that bird's own loading as the weight: this is, by the theorem of
Kutta and Joukowski, the tilt of its lift, and its ratio to the bird's own downwash is the share of
induced drag saved.

Assumed: wings are level and parallel, loadings are equal and elliptic, flapping is averaged out,
wakes are straight, and the bound vortex (which by Munk's stagger theorem only moves drag from one
bird to another) is left out.
"""

from __future__ import annotations

import math

from worlds.compilation import compiled

LEG = math.pi / 8.0
"""Distance of either leg from the middle of the bird, in spans: half of pi / 4."""
CORE = 0.04
"""Radius of the core of a vortex, in spans."""
WITHIN = 6.0
"""Birds further away than this, in spans, are left out."""
FADES = 10.0
"""Distance behind a bird in which its wake fades to 1/e, in spans."""
NOTHING = 1e-24
"""Keeps a division by the square of a length from being one by 0."""
ALIGNED = math.cos(math.radians(30.0))
"""Least cosine of the angle between the headings of two birds that are aligned."""


@compiled
def along_span(y, h):
    """Mean of Re 1/(y + eta/2 + i h) over a span, eta in [-1, 1], with weight sqrt(1 - eta^2).

    It is 4 Re(z - sqrt(z^2 - 1)), z = 2 (y + i h), the root that falls off to both sides. `y` is
    how far the middle of the span is to the side of a line vortex, `h` >= 0 how far off its plane,
    both in spans; the value is in 1/span, to 7 digits after the point.
    """
    x = 2.0 * y
    k = 2.0 * h
    re = x * x - k * k - 1.0
    im = 2.0 * x * k
    real = math.sqrt(max(0.0, 0.5 * (math.sqrt(re * re + im * im) + re)))
    return 4.0 * (x - math.copysign(real, x))


@compiled
def leg(dx, dy, dz, core):
    """Upwash share of one leg: it begins dx ahead; the middle of the span is dy aside, dz above.

    All lengths are in spans. A half-infinite vortex makes the part
    k = (1 + dx / sqrt(dx^2 + d^2)) / 2 of what an infinite one does, d being its distance from the
    middle of the span. A core rounds distances off: d^2 + core^2 (Rosenhead 1930).
    """
    h2 = dz * dz + core * core
    k = 0.5 * (1.0 + dx / math.sqrt(max(dx * dx + dy * dy + h2, NOTHING)))
    return k * along_span(dy, math.sqrt(h2)) / math.pi


@compiled
def relief(dx, dy, dz, core):
    """Share of its own induced drag that a bird saves by another; negative in the downwash.

    It flies `dx` behind the other (negative: ahead), `dy` to its right (or left: the share is the
    same), `dz` above, and the vortices have cores of radius `core` >= 0, all in spans.
    """
    return leg(dx, dy - LEG, dz, core) - leg(dx, dy + LEG, dz, core)


@compiled
def wake_decay(dx):
    """exp(-dx / FADES) of a wake `dx` spans old, 1 ahead of it; to 10 digits up to 6 spans.

    The series of exp(-dx / 8 FADES), then squared three times: the library's exponential would keep
    the loop from becoming vector instructions.
    """
    x = max(dx, 0.0) * (-0.125 / FADES)
    y = 1.0 + x * (1.0 + x * (1 / 2 + x * (1 / 6 + x * (1 / 24 + x * (1 / 120 + x / 720)))))
    y = y * y
    y = y * y
    return y * y


@compiled
def counts(me, near, j, limit):
    """Whether a bird of the block is another one, aligned and at most `limit` (a length) away."""
    dx, dy, dz = me.x - near.x[j], me.y - near.y[j], me.z - near.z[j]
    d2 = dx * dx + dy * dy + dz * dz
    ux, uy, uz = near.ux[j], near.uy[j], near.uz[j]
    aligned = ux * me.ux + uy * me.uy + uz * me.uz >= ALIGNED
    return (d2 > 0.0) & (d2 <= limit * limit) & aligned & (ux * ux + uy * uy > NOTHING)


@compiled
def share_of(me, near, j, b):
    """Share that this bird saves by one of the block, seen in that one's frame."""
    ux, uy, uz = near.ux[j], near.uy[j], near.uz[j]
    ex, ey, ez = (me.x - near.x[j]) / b, (me.y - near.y[j]) / b, (me.z - near.z[j]) / b
    level2 = ux * ux + uy * uy
    level = math.sqrt(max(level2, NOTHING))
    dx = -(ex * ux + ey * uy + ez * uz)
    dy = (ex * uy - ey * ux) / level
    dz = (level2 * ez - uz * (ex * ux + ey * uy)) / level
    return relief(dx, dy, dz, CORE) * wake_decay(dx)


@compiled
def drag_saving_within(me, near, b, limit):
    """As `drag_saving`, with the birds up to `limit` away: a length, at most 6 spans."""
    neighbours = near.spare[0]
    n = 0
    for j in range(near.n):
        neighbours[n] = j
        n += 1 if counts(me, near, j, limit) else 0
    total = 0.0
    for k in range(n):
        total += share_of(me, near, int(neighbours[k]), b)
    return total


@compiled
def drag_saving(me, near, b):
    """Share of its own induced drag that this bird saves by all birds around; not clipped.

    Summed over the birds within 6 spans whose heading is within 30 degrees of its own, ahead and
    behind: k gives those behind the little that their wake's beginning makes ahead of them. Each
    is seen in its own frame: dx back along its heading, dy along its level wings, dz up from them,
    so that height counts in three dimensions. The wake fades as exp(-dx / 10 b). `b` is the wing
    span, a length > 0. A bird that flies straight up or down has no level wings and adds nothing.
    The share is negative in the downwash behind a bird, and may exceed 1 between two.
    """
    return drag_saving_within(me, near, b, WITHIN * b)
