"""What the picture of a live room shows, and from where."""

from __future__ import annotations

from collections.abc import Callable

import viser

from app.viewer.scene.shown.look import CAMERAS, LIVE_COLOURINGS, RIBBON, TRAILS, Look
from app.viewer.web.values import show

LENGTH = 400
"""How far back a trail reaches at first, ticks."""


class LiveView:
    """Makes the `Look`; the cameras are each browser's own."""

    def __init__(self, gui: viser.GuiApi, point: Callable[[viser.ClientHandle, str], None]):
        self.point = point
        self.colour = gui.add_dropdown(
            "Colour by", LIVE_COLOURINGS, hint="What a car's colour means"
        )
        self.trails = gui.add_dropdown(
            "Trail",
            TRAILS,
            initial_value=RIBBON,
            hint="Where each car has been; rising in time: its way through space and time, time "
            "upwards (look at it from the side)",
        )
        self.length = gui.add_slider(
            "Trail length", 50, 2000, 50, LENGTH, hint="How far back, ticks of the loop"
        )
        self.fence = gui.add_checkbox("Fence", True, hint="Where the cars are stopped")
        self.injected = gui.add_checkbox("Injected car", True, hint="The car that they follow")
        self.size = gui.add_slider("Car size", 1.0, 3.0, 0.1, 1.0)
        self.shadows = gui.add_checkbox("Shadows", True)
        self.camera = gui.add_button_group(
            "Camera", CAMERAS, hint="For this browser only; follow goes after the clicked car"
        )
        self.camera.on_click(self.pointed)

    async def pointed(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self.point(event.client, event.target.value)

    def next_colour(self) -> None:
        """Colour by the next quantity."""
        place = LIVE_COLOURINGS.index(self.colour.value) + 1
        show(self.colour, LIVE_COLOURINGS[place % len(LIVE_COLOURINGS)])

    def look(self) -> Look:
        """The drawing as the controls have it."""
        return Look(
            colour=self.colour.value,
            trails=self.trails.value,
            trail_length=self.length.value,
            fence=self.fence.value,
            mission=self.injected.value,
            agent_size=self.size.value,
            shadows=self.shadows.value,
        )
