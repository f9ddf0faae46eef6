"""Tracks that are played as a flock: individuals whose places come from a file, not from a rule.

A flock of it is put where a file says that it was. Nothing here decides or moves: were it run, all
would go nowhere. There is one model of it for each unit of length, so that every number that is
shown has its own.
"""

from __future__ import annotations

from agents.engine.block import BodyMove, Decision
from agents.models.declare import Body, Parameters, Rule, parameter
from worlds.compilation import compiled

SOURCE = "ours"
FARTHEST = 1e9
"""Largest distance within which individuals may be of one group, and longest time of a frame."""


def within(unit: str) -> float:
    """The declaration of the distance within which individuals are of one group."""
    return parameter(
        1.0,
        "Distance within which individuals are neighbours, and of one group",
        words="Neighbours within",
        symbol="d_n",
        unit=unit,
        low=0.0,
        high=FARTHEST,
        source=SOURCE,
    )


class TrackedInMetres(Parameters):
    """Parameters of tracks in metres."""

    within: float = within("m")


class TrackedInPixels(Parameters):
    """Parameters of tracks in the pixels of a video."""

    within: float = within("px")


class TrackedInLengths(Parameters):
    """Parameters of tracks in a length that somebody has chosen."""

    within: float = within("length")


class FrameClock(Parameters):
    """Parameters of the body of what is tracked."""

    frame_time: float = parameter(
        0.04,
        "Time from tick to tick: from frame to frame, where frames are evenly apart",
        words="Time of a frame",
        symbol="\\Delta t_f",
        unit="s",
        low=1e-9,
        high=FARTHEST,
        source=SOURCE,
    )


@compiled
def decide(me, near, surroundings, p):
    """Keep the heading."""
    return Decision(0.0, 0.0, 0.0)


@compiled
def move(me, near, surroundings, want, p, out):
    """Stay."""
    return BodyMove(me.x, me.y, me.z, me.ux, me.uy, me.uz, me.speed)


@compiled
def passes(p):
    """They are where they were seen, whatever is said to be solid there."""
    return 1.0


BODY = Body(
    name="tracked",
    title="What a tracker saw",
    source=SOURCE,
    parameters=FrameClock,
    move=move,
    passes=passes,
    passes_with="tracks",
    lasts=lambda p: p.frame_time,
    unit="s",
)


def tracked_rule(name: str, parameters: type[Parameters]) -> Rule:
    """The rule of tracks in a unit."""
    return Rule(
        name=name,
        title="Tracks",
        summary="Individuals where a file of tracks says that they were seen.",
        equation=r"x_i(t) = \text{as seen}",
        source=SOURCE,
        parameters=parameters,
        decide=decide,
        reach="within",
        led=False,
    )


METRES = tracked_rule("tracks", TrackedInMetres)
PIXELS = tracked_rule("tracks-px", TrackedInPixels)
LENGTHS = tracked_rule("tracks-lengths", TrackedInLengths)
