"""What a rule may leave out: the parts of a loop that then do nothing.

Also stands in, for type checkers, for the names that `agents.engine.loop` puts into a loop.
"""

from __future__ import annotations

from agents.engine.block import Moved, Wish
from worlds.compiled import compiled

DIM = 2
SIGNALS = 0


@compiled
def decide(me, near, p):
    """Keep the heading."""
    return Wish(0.0, 0.0, 0.0)


@compiled
def show(me, p, out):
    """Show nothing that is not remembered."""


@compiled
def remember(me, near, p, informed, out):
    """Remember what was shown."""


@compiled
def prepare(flock, space, grid, slots, p, tick):
    """Need nothing of the whole flock."""


@compiled
def move(me, ux, uy, uz, p):
    """Stand still."""
    return Moved(me.x, me.y, me.z, ux, uy, uz, 0.0)
