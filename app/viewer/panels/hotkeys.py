"""Keys for what is done often. viser itself moves the camera with W A S D Q E and the arrows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import viser

KEYS = {
    "space": "Go or pause",
    "T": "Step one tick",
    "R": "Reset: the same run from its start",
    "N": "Setup: a new flock",
    "pageup": "Faster",
    "pagedown": "Slower",
    "1": "Camera: top-down",
    "2": "Camera: perspective",
    "3": "Camera: side",
    "F": "Camera: follow the clicked agent",
    "B": "Camera: ride along on the clicked agent, and off again",
    "C": "Colour by the next quantity",
    "L": "Links on or off",
    "H": "Guide",
    "U": "Rule: undo the last change of a parameter",
    "Z": "World: undo",
    "Y": "World: redo",
    "delete": "World: delete the selected obstacle",
    "escape": "World: a click selects again; camera: the ride ends",
}
"""Key -> what it does; every one has an action in some call of `add_hotkeys`."""
OWN_KEYS = {
    "P": "Panels: hide them, or show them again",
    "M": "Light or dark",
    "X": "Size of the text: S, M or L",
    "G": "Gallery of scenes, models and worlds",
}
"""Keys that act in one browser alone, by its page: look.js, and in the laboratory gallery.js."""


def add_hotkeys(
    gui: viser.GuiApi,
    actions: dict[str, Callable[[viser.ClientHandle], Any]],
    keys: Mapping[str, str] = KEYS,
) -> None:
    """Give keys actions, which take the browser where they were pressed.

    A key may have several actions; `keys` say what each does.
    """
    for key, action in actions.items():
        command: Any = gui.add_command(keys[key], hotkey=key)  # type: ignore[arg-type]
        command.on_trigger(triggered(action))


def triggered(action: Callable[[viser.ClientHandle], Any]) -> Callable:
    """The action as viser calls it: in order, on its event loop."""

    async def run(event: Any) -> None:
        if event.client is not None:
            action(event.client)

    return run
