"""The keys of a laboratory of real cars: two that stop, and some that only change the view."""

from __future__ import annotations

import html

from app.viewer.scene.static_files import static_folder

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


def everywhere() -> str:
    """HTML by which a page hears the emergency stop's keys wherever its focus is.

    A script that comes as HTML after a page has loaded is not run; the handler of a picture is.
    """
    script = (static_folder() / "stop-key.js").read_text()
    return f'<img hidden alt="" src="data:," onerror="{html.escape(script)}">'
