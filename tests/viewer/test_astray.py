"""An agent that is where it cannot be is a notice in the laboratory, once."""

from agents import Flock
from app.viewer.run.flock_run import FlockRun, StrayAgentError, describe_error
from app.viewer.run.frame_builder import FrameRequest
from worlds.obstacles import Box
from worlds.world import World

YARD = World(
    "yard", (10.0, 10.0), ("solid", "solid"), obstacles=(Box(low=(4.0, 4.0), high=(6.0, 6.0)),)
)


def test_it_is_told_once():
    flock = Flock("vem", agents=5, world=YARD, rng=1)
    run = FlockRun(flock, 1, FrameRequest())
    run.look(closely=False)
    assert not any(isinstance(trouble, StrayAgentError) for trouble in run.troubles)
    flock.position[1] = (5.0, 5.5)
    run.look(closely=False)
    flock.position[1] = (5.0, 5.6)
    run.look(closely=False)
    [trouble] = [trouble for trouble in run.troubles if isinstance(trouble, StrayAgentError)]
    assert describe_error(trouble) == (
        f"agent {flock.ids[1]} where it cannot be: 0.5 inside what is solid at (5, 5.5), tick 0"
    )
