"""Where the goal is: the gamma agent goes along its route at constant speed."""

from __future__ import annotations

import numpy as np

from worlds.mission import Goal


def along_route(goal: Goal, time) -> np.ndarray:
    """Positions (T, dim) of the gamma agent at times (T,) >= 0, length.

    It stays at the end of its route, or goes round if the route is closed.
    """
    route = np.array(goal.route, float)
    if goal.closed:
        route = np.vstack([route, route[:1]])
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(route, axis=0), axis=1))])
    gone = goal.speed * np.asarray(time, float)
    if goal.closed and length[-1] > 0.0:
        gone = gone % length[-1]
    return np.column_stack([np.interp(gone, length, axis) for axis in route.T])
