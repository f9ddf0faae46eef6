"""What the picture shows, and from where."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import viser

from app.viewer.panels.form import Form
from app.viewer.scene.shown.control import Control
from app.viewer.scene.shown.look import CAMERAS, COLOURINGS, LIVE_COLOURINGS, MEASURED, Look
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
        self.usual = look
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

    def offer(self, numbers: tuple[str, ...]) -> None:
        """Let agents be coloured by these numbers too."""
        colour = self.form["colour"]
        choices = (*COLOURINGS, *(name for name in numbers if name not in COLOURINGS))
        if tuple(colour.options) != choices:
            chosen = colour.value
            colour.options = choices
            show(colour, chosen if chosen in choices else COLOURINGS[0])

    def next_colour(self) -> None:
        """Colour by the next quantity."""
        colour = self.form["colour"]
        choices = tuple(colour.options)
        show(colour, choices[(choices.index(colour.value) + 1) % len(choices)])

    def take(self, look: Mapping[str, Any]) -> None:
        """Show these, by the names of their controls, and all else as usual."""
        for name, control in self.form.handles.items():
            show(control, look.get(name, getattr(self.usual, name)))

    def not_usual(self) -> dict[str, Any]:
        """What is not as usual, by the names of the controls."""
        now = {name: control.value for name, control in self.form.handles.items()}
        return {name: one for name, one in now.items() if one != getattr(self.usual, name)}

    def look(self) -> Look:
        """The drawing as the controls have it."""
        chosen = self.form["colour"].value
        if chosen in (*COLOURINGS, *LIVE_COLOURINGS):
            return self.form.read()
        return self.form.read(colour=MEASURED, measured=chosen)
