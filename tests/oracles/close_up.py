"""One agent of a flock as its rule sees it, put together without the engine's cells."""

import numpy as np

from agents.engine.block import Me, NeighbourBlock


def close_up(flock, row):
    """`Me` and `NeighbourBlock` of a row: everybody is in the block, and the boundary points within
    reach."""
    n = len(flock.ids)
    shared = len(flock.model.signals)
    signals = flock.signals()
    told, own = signals[:shared].copy(), signals[:, row].copy()
    q, u = np.zeros((3, n)), np.zeros((3, n))
    q[: flock.world.dim], u[: flock.world.dim] = flock.position.T, flock.heading.T
    me = Me(
        *q[:, row],
        *u[:, row],
        float(flock.speed[row]),
        own[:shared],
        own[shared:],
        False,
        1.0,
        int(flock.ids[row]),
        flock.tick,
        np.uint64(0),
        n,
        float(flock.kind_numbers[row]),
    )
    surroundings = flock.engine.surroundings
    away = np.hypot(surroundings.point_x - q[0, row], surroundings.point_y - q[1, row])
    x, y = surroundings.point_x[away <= flock.reach], surroundings.point_y[away <= flock.reach]
    spare, kind = np.empty((4, n + len(x))), flock.kind_numbers.astype(float)
    return me, NeighbourBlock(n, *q, *u, flock.speed, told, np.ones(n), len(x), x, y, spare, kind)
