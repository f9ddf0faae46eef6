"""One browser that watches: its plots, the agent that it has chosen, and its camera."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import viser

from app.viewer.lab.panels.agent.inspector import Inspector
from app.viewer.scene.scene import Scene
from app.viewer.scene.shown.drawing_style import CAMERA, CAMERAS, RIDE
from app.viewer.scene.shown.frame import Frame
from app.viewer.watching.own_marks import AgentSelection
from app.viewer.watching.own_plots import OwnPlots


class Watcher:
    """What there is on one browser's page alone; made on viser's loop.

    `point` turns its camera. Only `choice` is set by the browser; the thread that draws does the
    rest.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        left: viser.GuiTabHandle,
        right: viser.GuiFolderHandle,
        point: Callable[[viser.ClientHandle, str], None],
    ):
        self.client, self.point = client, point
        self.choice: AgentSelection | None = None
        self.is_new = True
        """Whether nothing on its page has been brought up to date yet."""
        self.since = time.monotonic()
        """When it chose an agent last, or came, s."""
        gui = client.gui
        with left:
            self.plots = OwnPlots(gui)
        with right, gui.add_folder(CAMERA):
            presets = gui.add_button_group(
                "From", CAMERAS, hint="In this browser; follow goes after the clicked agent"
            )
            ride = gui.add_button(
                "Ride along",
                icon=viser.Icon.FEATHER,
                color="gray",
                hint="A camera on the clicked agent, in this browser; again, or Esc, to get off",
            )
        presets.on_click(self.pointed)
        ride.on_click(self.ridden)
        self.inspector = Inspector(gui, lambda: self.choose(None))

    async def pointed(self, event: viser.GuiEvent) -> None:
        self.point(self.client, event.target.value)

    async def ridden(self, _event: viser.GuiEvent) -> None:
        self.point(self.client, RIDE)

    def choose(self, choice: AgentSelection | None) -> None:
        """Inspect an agent, or none."""
        self.choice, self.since = choice, time.monotonic()

    @property
    def whom(self) -> tuple[int | None, int] | None:
        """Row and flock of its agent; None if it has none."""
        choice = self.choice
        return None if choice is None else (choice.row, int(choice.beside))

    def tell(self, frame: Frame, scene: Scene) -> None:
        """Bring the card of its agent up to date, of which `frame` is a picture of all."""
        choice = self.choice
        flock = None if choice is None else choice.side(frame)
        if choice is None or flock is None:
            if self.choice is choice:  # else a click has come meanwhile
                self.choice = None
            self.inspector.refresh(frame, None)
            return
        seen = flock.others.get(choice.row)
        at = scene.where(choice.row, int(choice.beside))
        self.inspector.refresh(replace(flock, inspected=seen), choice.row, at)
