"""Upwash between birds, by quadrature over the span and vectors in space, bird by bird.

Source: the law of Biot and Savart for half-infinite vortices with Rosenhead's core; a lifting line
of elliptic loading, whose downwash is Gamma / (2 b), with its lift carried by two vortices
pi b / 4 apart. All lengths in wing spans, Gamma = 1.
"""

import math

import numpy as np

NODES = 4000
ANGLE = (np.arange(NODES) + 0.5) * math.pi / NODES
ALONG = -0.5 * np.cos(ANGLE)
"""Places along a span of 1, dense at the tips."""
LOADING = np.sin(ANGLE) ** 2 / np.sum(np.sin(ANGLE) ** 2)
"""Share of the lift at each place: sqrt(1 - eta^2) d eta, eta = -cos(angle)."""


def vertical_wind(behind, aside, above, core):
    """Upward wind of a vortex that starts `behind` ahead and runs back; it turns up its right."""
    d2 = aside**2 + above**2 + core**2
    share = (1.0 + behind / np.sqrt(behind**2 + d2)) / 2.0
    return share, aside / (2.0 * math.pi * d2)


def share(dx, dy, dz, core, exact=False):
    """Upwash over the bird's own downwash 1/2; `exact` takes the wake's beginning place by place.

    Otherwise as at the middle of the span.
    """
    total = 0.0
    for sign in (1.0, -1.0):
        start = dy - sign * math.pi / 8.0
        begins, wind = vertical_wind(dx, start + ALONG, dz, core)
        if not exact:
            begins, _ = vertical_wind(dx, start, dz, core)
        total += sign * np.sum(LOADING * begins * wind)
    return total / 0.5


def saved(position, heading, span):
    """What each bird of a flock in open space saves, 2-D or 3-D."""
    pad = 3 - position.shape[1]
    position = np.pad(position, ((0, 0), (0, pad))) / span
    heading = np.pad(heading, ((0, 0), (0, pad)))
    total = np.zeros(len(position))
    for i, me in enumerate(position):
        for j, other in enumerate(position):
            gap = me - other
            if i == j or np.linalg.norm(gap) > 6.0:
                continue
            angle = math.acos(min(1.0, heading[i] @ heading[j]))
            if math.degrees(angle) > 30.0:
                continue
            right = np.cross(heading[j], [0.0, 0.0, 1.0])
            right /= np.linalg.norm(right)
            up = np.cross(right, heading[j])
            dx = -(gap @ heading[j])
            age = max(dx, 0.0)
            total[i] += share(dx, gap @ right, gap @ up, 0.04) * math.exp(-age / 10.0)
    return total
