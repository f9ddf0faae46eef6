"""What the picture of a flock shows, and from where."""

from __future__ import annotations

import viser

from app.viewer.panels.dials import set_visible
from app.viewer.panels.shell import add_hotkeys
from app.viewer.panels.view import Point, ViewPanel
from app.viewer.scene.shown.control import controls_of
from app.viewer.scene.shown.drawing_style import (
    AGENTS,
    RIDE,
    STEP_OFF,
    DrawingDefaults,
    DrawingStyle,
)
from app.viewer.scene.shown.frame import Frame


class FlockView(ViewPanel):
    """All that a look has, a ride on an agent, and handles to steer by."""

    def __init__(self, gui: viser.GuiApi, usual: DrawingDefaults, point: Point):
        super().__init__(gui, usual, controls_of(DrawingStyle), point)
        with self.camera:
            self.ride = gui.add_button(
                "Ride along",
                icon=viser.Icon.FEATHER,
                color="gray",
                hint="A camera on the clicked agent, in this browser; again, or Esc, to get off",
            )
        self.ride.on_click(self.ride_agent)
        with self.form.folders[AGENTS]:
            self.steer = gui.add_checkbox(
                "Steer",
                False,
                hint="Handles on the information agent: drag it about and turn it",
                visible=False,
            )
        add_hotkeys(
            gui,
            {
                "B": lambda client: self.point(client, RIDE),
                "escape": lambda client: self.point(client, STEP_OFF),
            },
        )

    async def ride_agent(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self.point(event.client, RIDE)

    def fit(self, frame: Frame, numbers: tuple[str, ...] = (), is_steerable: bool = True) -> None:
        super().fit(frame, numbers)
        set_visible(self.steer, is_steerable and bool(frame.informed.any()))
