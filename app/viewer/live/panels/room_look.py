"""What the picture of a live room shows."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from app.viewer.scene.shown.colouring import COLOURINGS, OWN
from app.viewer.scene.shown.control import controls_of
from app.viewer.scene.shown.drawing_defaults import DrawingDefaults, turns
from app.viewer.scene.shown.drawing_style import AGENTS, RIBBON, DrawingStyle

CARS = "Cars"
"""What agents are here."""
OF_CARS = [name for name, colouring in COLOURINGS.items() if colouring.of_cars]
FOR_CARS: dict[str, dict[str, Any]] = {
    "colour": {
        "hint": "What a car's colour means; its state is the outline around it",
        "choices": (
            OWN,
            *(name for name, one in COLOURINGS.items() if one.of_cars and name != OWN),
        ),
        "only": {},
    },
    "trails": {
        "hint": "Where each car has been; rising in time: its way through space and time, time "
        "upwards"
    },
    "trail_length": {"hint": "How far back, ticks of the loop", "low": 50, "step": 50},
    "agent_size": {"label": "Car size", "low": 1.0},
    "shadows": {},
    "fence": {"hint": "Where the cars are stopped"},
    "mission": {"label": "Injected car", "hint": "The car that they follow"},
}
"""Those controls that mean something for real cars, and what is otherwise about each."""
CONTROLS = {
    name: replace(one, **FOR_CARS[name], group=CARS if one.group == AGENTS else one.group)
    for name, one in ((name, controls_of(DrawingStyle)[name]) for name in FOR_CARS)
}


def usual(rate: float) -> DrawingDefaults:
    """How a room is drawn at first whose loop runs so often (Hz)."""
    return DrawingDefaults(
        DrawingStyle(colour=OWN, trails=RIBBON, trail_length=400), turns(1.0 / rate)
    )
