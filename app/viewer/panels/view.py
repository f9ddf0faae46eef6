"""What the picture shows, and from where."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import viser

from app.front.controls import set_value
from app.viewer.panels.dials import Form
from app.viewer.scene.shown.colouring import COLOURINGS, MEASURED
from app.viewer.scene.shown.control import Control
from app.viewer.scene.shown.drawing_style import (
    CAMERA,
    CAMERAS,
    RISING,
    DrawingDefaults,
    DrawingStyle,
)
from app.viewer.scene.shown.frame import Frame

Point = Callable[[viser.ClientHandle, str], None]
"""Turns the camera of a browser."""


class ViewPanel:
    """Makes the `DrawingStyle`; the cameras are each browser's own.

    A colouring that was chosen comes back when a flock has it again.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        usual: DrawingDefaults,
        controls: Mapping[str, Control],
        point: Point,
        followed: str = "agent",
    ):
        self.point = point
        self.usual = usual
        self.form = Form(gui, usual.look, controls)
        self.colour = usual.look.colour
        """The colouring that was chosen, which not every flock has."""
        self.offering = False
        self.offered = self.form["colour"].value
        """The colouring that was shown last."""
        self.form["colour"].on_update(self.remember_colouring)
        self.form["trails"].on_update(self.trailed)
        self.camera = gui.add_folder(CAMERA)
        with self.camera:
            presets = gui.add_button_group(
                "From", CAMERAS, hint=f"In this browser; follow goes after the clicked {followed}"
            )
        presets.on_click(self.show_hint)

    async def show_hint(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self.point(event.client, event.target.value)

    def remember_colouring(self, event: viser.GuiEvent) -> None:
        """Remember a colouring that somebody, or a scene, has chosen."""
        if event.client is not None or not self.offering:
            self.colour = event.target.value

    async def trailed(self, event: viser.GuiEvent) -> None:
        """What rises goes back as far as suits it, unless somebody has chosen how far."""
        length = self.form["trail_length"]
        common, rising = self.usual.look.trail_length, self.usual.rising
        before, now = (common, rising) if event.target.value == RISING else (rising, common)
        if event.client is not None and length.value == before:
            set_value(length, now)

    def fit(self, frame: Frame, numbers: tuple[str, ...] = ()) -> None:
        """Show what applies to a frame; agents can be coloured by these numbers too."""
        scene = [frame for frame in (frame, frame.beside) if frame is not None]
        look = self.drawing_style()
        self.form.fit(look, scene)
        offered = self.form.controls["colour"].offered(scene, look)
        self.offer((*offered, *(name for name in numbers if name not in offered)))

    def offer(self, choices: tuple[str, ...]) -> None:
        """Let agents be coloured by these: as was chosen, or else by the first of them."""
        colour = self.form["colour"]
        if (
            colour.value != self.offered
        ):  # somebody has chosen it, though `remember_colouring` is yet to run
            self.colour = colour.value
        self.offering = True
        if tuple(colour.options) != choices:
            colour.options = choices
        self.offered = self.colour if self.colour in choices else choices[0]
        set_value(colour, self.offered)
        self.offering = False

    def next_colour(self) -> None:
        """Colour by the next quantity."""
        colour = self.form["colour"]
        choices = tuple(colour.options)
        set_value(colour, choices[(choices.index(colour.value) + 1) % len(choices)])

    def take(self, look: Mapping[str, Any]) -> None:
        """Show these, by the names of their controls, and all else as usual."""
        values = self.default_values(look.get("trails", self.usual.look.trails)) | dict(look)
        self.colour = values["colour"]
        self.offer(tuple(dict.fromkeys([*self.form["colour"].options, self.colour])))
        for name, control in self.form.handles.items():
            set_value(control, values[name])

    def changed_values(self) -> dict[str, Any]:
        """What is not as usual, by the names of the controls."""
        now = {name: control.value for name, control in self.form.handles.items()}
        now["colour"] = self.colour
        usually = self.default_values(now["trails"])
        return {name: value for name, value in now.items() if value != usually[name]}

    def default_values(self, trails: str) -> dict[str, Any]:
        """What is usual with these trails, by the names of the controls."""
        values = {name: getattr(self.usual.look, name) for name in self.form.handles}
        return values | ({"trail_length": self.usual.rising} if trails == RISING else {})

    def set_defaults(self, usual: DrawingDefaults) -> None:
        """Take this for usual from now on; what was as usual is so again."""
        if usual != self.usual:
            changed, self.usual = self.changed_values(), usual
            self.take(changed)

    def drawing_style(self) -> DrawingStyle:
        """The drawing as the controls have it."""
        chosen = self.form["colour"].value
        if chosen in COLOURINGS and chosen != MEASURED:
            return self.form.read()
        return self.form.read(colour=MEASURED, measured=chosen)
