"""What every page has in common: its look, and cameras that find their place."""

from __future__ import annotations

import time
from collections.abc import Callable

import viser

from app.viewer.panels.style import CSS

SETTLING = 5.0
"""Time in which a new browser's canvas finds its shape, s."""
LEFT, RIGHT = 310, 330
"""Widths of the panels, pixels."""


def dress(gui: viser.GuiApi, label: str) -> None:
    """Give a page the house's look."""
    gui.configure_theme(
        control_width="large",
        show_logo=False,
        show_share_button=False,
        brand_color=(28, 126, 214),
    )
    gui.set_panel_label(label)
    gui.add_html(CSS)


def dock(gui: viser.GuiApi, left: viser.PanelHandle) -> None:
    """Put the monitors to the left and the controls to the right."""
    left.dock_left()
    left.set_width(LEFT)
    gui.main_panel.dock_right()
    gui.main_panel.set_width(RIGHT)


def settle(client: viser.ClientHandle, point: Callable[[], bool]) -> None:
    """Call `point` while a new browser's panels take their places and change its canvas.

    It says whether there was something to point at; if not, it is called again.
    """
    connected, shape = time.monotonic(), client.camera.aspect

    async def reshaped(camera: viser.CameraHandle) -> None:
        nonlocal shape
        new = camera.image_width / max(1, camera.image_height)
        is_new = time.monotonic() <= connected + SETTLING and abs(new - shape) >= 0.02
        if is_new and point():
            shape = new

    client.camera.on_update(reshaped)
