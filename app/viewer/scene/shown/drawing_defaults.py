"""How a flock is drawn as long as nobody chooses otherwise."""

from __future__ import annotations

from dataclasses import dataclass

from agents.models.model import Model
from app.viewer.scene.shown.colouring import OWN
from app.viewer.scene.shown.drawing_style import DrawingStyle

FEW = 12
"""So many cars at most are told apart by their colours."""
TURNS = 40.0
"""How far back what rises with time goes behind cars, s: they go round their room some times, and
their ways are the helices of Jacobs and Koessler's figures."""


@dataclass(frozen=True)
class DrawingDefaults:
    """A look, and what it is with trails that rise."""

    look: DrawingStyle
    rising: int
    """Trail length where trails rise with time, ticks."""


def usual(model: Model, agents: int | None, tick: float) -> DrawingDefaults:
    """How a flock of a model is drawn whose ticks last so long, in its unit of time."""
    common = DrawingStyle()
    if model.body.vehicle is None:
        return DrawingDefaults(common, common.trail_length)
    few = agents is not None and agents <= FEW
    return DrawingDefaults(DrawingStyle(colour=OWN) if few else common, turns(tick))


def turns(tick: float) -> int:
    """`TURNS` in ticks that last so long, s."""
    return round(TURNS / tick)
