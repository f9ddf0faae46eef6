"""Catch: 10 for each agent that one catches, and -0.01 for each tick."""

from __future__ import annotations

from app.learning.reward import Reward
from worlds.compilation import compiled

CAUGHT, WAITED = 10.0, -0.01


@compiled
def gain(player):
    """CAUGHT for each catch of the tick that has just ended."""
    return WAITED + CAUGHT * player.tables.caught[player.e, player.m]


REWARD = Reward("hunt", "Catch others: 10 for each, -0.01 a tick.", gain)
