"""The keys of a laboratory of real cars: two that stop, and some that only change the view."""

from __future__ import annotations

KEYS = {
    "space": "EMERGENCY STOP",
    "escape": "EMERGENCY STOP: this key too",
    "1": "Camera: top-down",
    "2": "Camera: perspective",
    "3": "Camera: side",
    "F": "Camera: follow the clicked car",
    "C": "Colour by the next quantity",
}
"""Key -> what it does. No key arms, and none but the first two reaches the cars."""
STOP_KEY = "stop-key.js"
"""The script by which a page hears the emergency stop's keys wherever its focus is."""
