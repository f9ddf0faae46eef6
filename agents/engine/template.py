"""The parts of a loop that a rule may leave out; these defaults do nothing.

Also stands in, for type checkers, for the names that `agents.engine.compiled_loop` puts into a
loop.
"""

from __future__ import annotations

from agents.engine.block import BodyMove, Decision
from worlds.compilation import compiled

DIM = 2
SIGNALS = 0
"""What agents tell each other, the rule's and the body's."""
PRIVATE = 0
"""What each agent keeps to itself."""
HEADS = True
"""Whether the rule wishes a heading, which noise may turn."""
DEAFENS = False
"""Whether the last signal says who is heard: 1.0, or 0.0."""
SEES_POINTS = False
"""Whether the rule is given the boundary points of obstacles."""
SIFTS = False
"""Whether those within reach are picked out of a block before an agent decides."""
NEAREST = False
"""Whether a rule is shown the nearest agents only, whatever their distance."""
MEASURES = 0
"""What is measured of each agent in the pass."""
CRASHES = False
"""Whether agents that touch something fall."""
MEETS = 0
"""What an agent does where its step enters something solid, see `agents.engine.solid_collision`."""
SUMS = 1
"""How many sums over pairs a rule makes."""
ASKS_SPEED = True
"""Whether the rule or the body asks how fast agents are."""
WINDY = False
"""Whether a wind carries agents along."""
KINDS = False
"""Whether there are kinds of agents, and relations between them: see `agents.engine.heeding`."""
DIFFER: tuple[int, ...] = ()
"""Where agents differ, which field of `P` each column of the table `own` is; -1 for none."""
BY_LANES = False
"""Whether the rule's `answer` and the body's `move` take eight agents at once."""


@compiled
def own_of_row(p, own, row):
    """By default all agents share their parameters; see `agents.engine.own_parameters`."""
    return p


@compiled
def own_of_eight(p, own, rows, slot, last):
    """By default all agents share their parameters."""
    return p


@compiled
def view_of(p):
    """By default the field of view is all round, deg."""
    return 360.0


@compiled
def term(me, other, p):
    """By default a pair adds nothing."""
    return (0.0,)


@compiled
def answer(me, sums, surroundings, p):
    """By default the heading is kept."""
    return Decision(0.0, 0.0, 0.0)


@compiled
def holds(flock, numbers):
    """The condition that may end a run once it has held for some ticks: by default never."""
    return False


@compiled
def perceive(me, near, surroundings, p):
    """By default an agent keeps nothing in memory."""


@compiled
def decide(me, near, surroundings, p):
    """By default the heading is kept."""
    return Decision(0.0, 0.0, 0.0)


@compiled
def show(me, p, out):
    """By default the signals are those that were remembered."""


@compiled
def remember(me, near, p, out):
    """By default the signals stay as they were shown."""


@compiled
def prepare(flock, space, grid, slots, p, tick):
    """By default nothing is computed of the whole flock."""


@compiled
def measure(me, near, p, out):
    """By default nothing is measured."""


@compiled
def touches(me, near, surroundings, p):
    """By default agents are points and touch nothing."""
    return 0.0


@compiled
def passes(p):
    """By default solid surfaces stop agents."""
    return False


@compiled
def move(me, near, surroundings, want, p, out):
    """By default agents stay where they are."""
    return BodyMove(me.x, me.y, me.z, want.x, want.y, want.z, 0.0)
