"""What the picture shows, and from where."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import viser

from app.viewer.panels.form import Form
from app.viewer.scene.shown.control import Control
from app.viewer.scene.shown.look import CAMERAS, Look
from app.viewer.web.values import show

Point = Callable[[viser.ClientHandle, str], None]
"""Turns the camera of a browser."""


class ViewPanel:
    """Makes the `Look`; the cameras are each browser's own."""

    def __init__(
        self,
        gui: viser.GuiApi,
        look: Look,
        controls: Mapping[str, Control],
        point: Point,
        followed: str = "agent",
    ):
        self.point = point
        self.form = Form(gui, look, controls)
        self.camera = gui.add_button_group(
            "Camera",
            CAMERAS,
            hint=f"For this browser only; follow goes after the clicked {followed}",
        )
        self.camera.on_click(self.pointed)

    async def pointed(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self.point(event.client, event.target.value)

    def next_colour(self) -> None:
        """Colour by the next quantity."""
        colour = self.form["colour"]
        place = colour.options.index(colour.value) + 1
        show(colour, colour.options[place % len(colour.options)])

    def look(self) -> Look:
        """The drawing as the controls have it."""
        return self.form.read()
