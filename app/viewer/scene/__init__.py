"""What the browser's three-dimensional view shows of a flock."""

from app.viewer.scene.look import (
    CAMERAS,
    COLOURINGS,
    LIVE_COLOURINGS,
    MEASURED,
    RIDE,
    STATE,
    STEP_OFF,
    TRAILS,
    Look,
)
from app.viewer.scene.scene import Scene

__all__ = [
    "CAMERAS",
    "COLOURINGS",
    "LIVE_COLOURINGS",
    "MEASURED",
    "RIDE",
    "STATE",
    "STEP_OFF",
    "TRAILS",
    "Look",
    "Scene",
]
