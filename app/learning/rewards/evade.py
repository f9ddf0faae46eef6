"""Stay alive: 1 for each tick, and -10 for being caught or for a crash."""

from __future__ import annotations

from app.learning.reward import Reward
from worlds.compilation import compiled

LOST = -10.0


@compiled
def gain(player):
    """1, or LOST for whom it is over."""
    return LOST if player.tables.is_over[player.e, player.m] else 1.0


REWARD = Reward("evade", "Stay alive: 1 a tick, -10 for being caught or crashing.", gain)
