"""Go to the goal: the way towards it in a tick, over the reach."""

from __future__ import annotations

import math

from app.learning.reward import Reward
from worlds.compilation import compiled

REACH = 0
"""Its column of `BatchTables.numbers`."""


@compiled
def gain(player):
    """How much nearer the goal one came in the tick, over the reach; 0 for who is gone."""
    flock, tables, e = player.flock, player.tables, player.e
    row = tables.rows[e, player.m]
    if row < 0:
        return 0.0
    length2 = towards = 0.0
    for axis in range(flock.position.shape[1]):
        d = player.surroundings.goal[0, axis] - flock.position[row, axis]
        length2 += d * d
        towards += d * flock.heading[row, axis]
    if length2 == 0.0:
        return 0.0
    return towards / math.sqrt(length2) * flock.speed[row] / tables.numbers[e, REACH]


REWARD = Reward(
    "reach-goal", "Go to the goal of the world: the way towards it.", gain, needs_goal=True
)
