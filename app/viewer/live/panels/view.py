"""What the picture of a live room shows."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from app.viewer.scene.shown.control import controls_of
from app.viewer.scene.shown.look import LIVE_COLOURINGS, OWN, RIBBON, Look

LOOK = Look(colour=OWN, trails=RIBBON, trail_length=400)
"""At first."""
FOR_CARS: dict[str, dict[str, Any]] = {
    "colour": {
        "hint": "What a car's colour means; its state is the outline around it",
        "choices": LIVE_COLOURINGS,
        "only": {},
    },
    "trails": {
        "hint": "Where each car has been; rising in time: its way through space and time, time "
        "upwards (look at it from the side)"
    },
    "trail_length": {"hint": "How far back, ticks of the loop", "low": 50, "step": 50},
    "agent_size": {"label": "Car size", "low": 1.0},
    "shadows": {},
    "fence": {"hint": "Where the cars are stopped"},
    "mission": {"label": "Injected car", "hint": "The car that they follow"},
}
"""Those controls that mean something for real cars, and what is otherwise about each."""
CONTROLS = {name: replace(controls_of(Look)[name], **more) for name, more in FOR_CARS.items()}
