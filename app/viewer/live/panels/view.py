"""What the picture of a live room shows."""

from __future__ import annotations

from app.viewer.scene.shown.control import Control
from app.viewer.scene.shown.look import LIVE_COLOURINGS, RIBBON, STATE, TRAILS, Look

LOOK = Look(colour=STATE, trails=RIBBON, trail_length=400)
"""At first."""
CONTROLS = {
    "colour": Control("Colour by", "What a car's colour means", LIVE_COLOURINGS),
    "trails": Control(
        "Trail",
        "Where each car has been; rising in time: its way through space and time, time upwards "
        "(look at it from the side)",
        TRAILS,
    ),
    "trail_length": Control(
        "Trail length", "How far back, ticks of the loop", low=50, high=2000, step=50
    ),
    "fence": Control("Fence", "Where the cars are stopped"),
    "mission": Control("Injected car", "The car that they follow"),
    "agent_size": Control("Car size", low=1.0, high=3.0, step=0.1),
    "shadows": Control("Shadows"),
}
