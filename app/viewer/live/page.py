"""The page of a room with real cars: a picture of it, and panels to arm, stop and steer it."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import viser

from app.live.laboratory.lab import Lab
from app.live.operating.choices import links, rules, sources
from app.viewer.live.hand import Hand
from app.viewer.live.keys import KEYS, STOP_KEY
from app.viewer.live.panels.log import LogPanel
from app.viewer.live.panels.monitors import BLOCKS, contents
from app.viewer.live.panels.plots import LivePlots
from app.viewer.live.panels.room import RoomPanel
from app.viewer.live.panels.rule import RulePanel
from app.viewer.live.panels.state import StatePanel
from app.viewer.live.panels.view import CONTROLS, LOOK
from app.viewer.live.room import Room
from app.viewer.panels.hotkeys import add_hotkeys
from app.viewer.panels.monitors import Monitors
from app.viewer.panels.shell import dock, dress, settle
from app.viewer.panels.view import ViewPanel
from app.viewer.scene.drawing import PANELS, Drawing
from app.viewer.scene.scene import Scene
from app.viewer.scene.shown.frame import Frame
from app.viewer.scene.shown.look import Look
from app.viewer.web.addresses import here
from app.viewer.web.notices import Notices
from app.viewer.web.origin import Allowed
from app.viewer.web.server import close_server, open_server, stops
from app.viewer.web.serving.front import Front

BANNER = 0.1
"""Time between two looks at how the room stands, s."""

Opening = Callable[[Lab, str | None, Path | None], Room]


class LivePage:
    """Serves one room to any number of browsers.

    Nothing in it can hold up the control loop, which is another process. Raises Refusal if the port
    is busy, or for a source that the laboratory does not have.
    """

    def __init__(
        self,
        lab: Lab,
        host: str = "127.0.0.1",
        port: int = 8080,
        source: str | None = None,
        recording: Path | None = None,
        opening: Opening = Room,
        allow: tuple[Allowed, ...] = (),
    ):
        self.front = Front(scripts=(STOP_KEY,), allow=allow)
        self.server = open_server(host, port, self.front)
        self.host = host
        self.lab = lab
        try:
            self.room = opening(lab, source, recording)
        except BaseException:
            close_server(self.server)
            raise
        stops(self.server, self.room.emergency)
        self.notices = Notices(self.server, self.room.notices)
        self.scene = Scene(self.server)
        self.hand = Hand(self.server.scene, lab.area, self.room.place)
        self.selected: int | None = None
        """Row of the car that was clicked."""
        self.banner_due = self.panels_due = 0.0
        self.furnish()
        self.listen()
        self.drawing = Drawing(self.scene, self.latest, self.browsers, self.stand, self.measure)
        self.drawing.start()

    @property
    def port(self) -> int:
        """The port that it serves on."""
        return self.server.get_port()

    @property
    def address(self) -> str:
        """Where a browser on this machine finds it."""
        return here(self.host, self.port)

    def close(self) -> None:
        """Stop the cars first, then drawing and serving."""
        self.room.close()
        self.drawing.close()
        close_server(self.server)

    def furnish(self) -> None:
        """Build the panels."""
        gui, lab = self.server.gui, self.lab
        dress(gui, f"flockscope · {lab.title}" if lab.title else "flockscope live")
        self.state = StatePanel(gui, self.room)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Rule"):
            self.rule = RulePanel(gui, self.room, rules(lab))
        with tabs.add_tab("Room"):
            self.place = RoomPanel(gui, self.room, sources(lab), links(lab))
        with tabs.add_tab("View"):
            self.view = ViewPanel(gui, LOOK, CONTROLS, self.point, "car")
        with tabs.add_tab("Log"):
            self.log = LogPanel(gui, self.room)
        left = gui.add_panel()
        with left.add_tab("Monitors", viser.Icon.CHART_LINE):
            self.monitors = Monitors(gui, BLOCKS, "loop")
            self.plots = LivePlots(gui, lab.rate)
        dock(gui, left)

    def listen(self) -> None:
        """Connect clicks and keys."""
        self.server.on_client_connect(self.settle)
        self.scene.on_clicked(self.clicked)
        add_hotkeys(
            self.server.gui,
            {
                "space": self.stop,
                "escape": self.stop,
                "1": lambda client: self.point(client, "top-down"),
                "2": lambda client: self.point(client, "perspective"),
                "3": lambda client: self.point(client, "side"),
                "F": lambda client: self.point(client, "follow"),
                "C": lambda _: self.view.next_colour(),
            },
            KEYS,
        )

    # What browsers ask for.

    def stop(self, client: viser.ClientHandle) -> None:
        """The emergency stop, by a key in one browser."""
        self.room.emergency(f"browser {client.client_id}")

    def clicked(
        self, row: int | None, _origin: np.ndarray, _direction: np.ndarray, _beside: bool = False
    ) -> None:
        """A click on a car chooses it, a click beside the cars none."""
        self.selected = row

    def point(self, client: viser.ClientHandle, camera: str) -> None:
        """Point one browser's camera."""
        if camera == "follow" and self.selected is not None:
            self.scene.follow(client, self.selected)
        else:
            self.scene.camera(client, camera)

    async def settle(self, client: viser.ClientHandle) -> None:
        """Point a new browser's camera again when its panels have taken their places."""

        def point() -> bool:
            if self.room.frame is not None:
                self.point(client, "top-down")
            return self.room.frame is not None

        settle(client, point)

    # What the drawing thread does.

    def latest(self) -> tuple[Frame | None, Look]:
        """The newest frame, and how to draw it."""
        return self.room.frame, self.view.look()

    def stand(self) -> None:
        """Say how the room stands, whether there is anything to draw or not."""
        self.room.browsers(self.browsers())  # first: whatever fails below, it is said
        self.notices.tell()
        now = time.monotonic()
        if now < self.banner_due:
            return
        self.banner_due = now + BANNER
        state, look = self.room.state, self.room.look
        self.state.refresh(state, look)
        if self.lab.injected.path == "hand" and self.room.frame is not None:
            self.hand.draw(self.room.frame)
        if now < self.panels_due:
            return
        self.panels_due = now + PANELS
        armed = look is not None and look.arm == "armed" and state.status == "open"
        self.rule.refresh(state, armed)
        self.place.refresh(state, look, armed)
        self.log.refresh()

    def measure(self) -> None:
        """Show what is measured."""
        look, readings = self.room.look, self.room.readings
        if self.drawing.drawn is None or look is None:
            return
        frame, drawn_as = self.drawing.drawn
        names = [*(car.name for car in look.cars), *(one.name for one in look.companions)]
        self.monitors.show(contents(look, frame, readings, self.browsers(), self.selected))
        self.monitors.colours(drawn_as.colour, self.scene.legend(drawn_as, frame))
        if frame.cars is not None:
            self.plots.refresh(readings, names, frame.cars.length)

    def browsers(self) -> int:
        """Number of browsers that watch."""
        return len(self.server.get_clients())
