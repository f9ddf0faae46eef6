"""The page of a room with real cars: a picture of it, and panels to arm, stop and steer it."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import viser

from app.front.notices import Notices
from app.front.origin import AllowedHost, local_address
from app.front.page_front import Front
from app.front.server import admit_browsers, close_server, on_emergency_stop, open_server
from app.live.operating.lab_choices import Choices
from app.viewer.live.panels.live_plots import LivePlots
from app.viewer.live.panels.log_panel import LogPanel
from app.viewer.live.panels.recording_panel import (
    RecordingPanel,
    ReplayPanel,
    describe_moment,
)
from app.viewer.live.panels.room_monitors import BLOCKS, contents
from app.viewer.live.panels.room_panel import CONTROLS, RoomPanel, room_defaults
from app.viewer.live.panels.rule_panel import RulePanel
from app.viewer.live.panels.state_panel import StatePanel
from app.viewer.live.room_frame import roster
from app.viewer.live.session import Session
from app.viewer.live.session_requests import DragHandle
from app.viewer.panels.monitors import Monitors
from app.viewer.panels.shell import add_hotkeys, dock, set_look
from app.viewer.panels.view import ViewPanel
from app.viewer.scene.drawing import PANELS, Drawing
from app.viewer.scene.scene import Scene
from app.viewer.scene.shown.drawing_style import DrawingStyle
from app.viewer.scene.shown.frame import Frame

BANNER = 0.1
"""Time between two updates of the banner, s."""
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
STOP_KEY = "stop-key.js"
"""The script by which a page hears the emergency stop's keys wherever its focus is."""

MakeSession = Callable[[Choices, Path | None], Session]


class LivePage:
    """Serves one session to any number of browsers.

    Nothing in it can hold up the control loop, which is another process. `recording`: the folder in
    which each opening is recorded; `recordings`: that of what the page records, and lists. Raises
    InputError if the port is busy.
    """

    def __init__(
        self,
        choices: Choices,
        host: str = "127.0.0.1",
        port: int = 8080,
        recording: Path | None = None,
        recordings: Path | None = None,
        make_session: MakeSession = Session,
        allow: tuple[AllowedHost, ...] = (),
    ):
        self.front = Front(scripts=(STOP_KEY,), allow=allow)
        self.server = open_server(host, port, self.front)
        self.host = host
        self.lab = choices.lab
        try:
            self.session = make_session(choices, recording)
        except BaseException:
            close_server(self.server)
            raise
        self.session.shelf = recordings or recording
        on_emergency_stop(self.server, self.session.emergency)
        self.notices = Notices(self.server, self.session.notices)
        self.scene = Scene(self.server)
        self.hand = DragHandle(self.server.scene, self.lab.area, self.session.place)
        self.selected: int | None = None
        """Row of the car that was clicked."""
        self.banner_due = self.panels_due = 0.0
        self.furnish(choices)
        self.listen()
        self.drawing = Drawing(self.scene, self.latest, self.browsers, self.refresh, self.measure)
        self.drawing.start()
        admit_browsers(self.server)  # last: browsers find all of the above

    @property
    def port(self) -> int:
        """The port that it serves on."""
        return self.server.get_port()

    @property
    def address(self) -> str:
        """Where a browser on this machine finds it."""
        return local_address(self.host, self.port)

    def close(self) -> None:
        """Stop the cars first, then drawing and serving."""
        self.session.close()
        self.drawing.close()
        close_server(self.server)

    def furnish(self, choices: Choices) -> None:
        """Build the panels."""
        gui, lab = self.server.gui, self.lab
        set_look(gui, f"flockscope · {lab.title}" if lab.title else "flockscope live")
        self.state = StatePanel(self.server, self.session)
        self.time_line = ReplayPanel(gui, self.session)
        recorded = gui.add_html("", visible=False)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Rule"):
            self.rule = RulePanel(gui, self.session, choices.rules)
        with tabs.add_tab("Room"):
            self.place = RoomPanel(gui, self.session, choices)
        with tabs.add_tab("View"):
            self.view = ViewPanel(gui, room_defaults(lab.rate), CONTROLS, self.point, "car")
        with tabs.add_tab("Record"):
            self.recording = RecordingPanel(gui, self.session, recorded)
        with tabs.add_tab("Log"):
            self.log = LogPanel(gui, self.session)
        left = gui.add_panel()
        with left.add_tab("Monitors", viser.Icon.CHART_LINE):
            self.monitors = Monitors(gui, BLOCKS, "loop")
            self.plots = LivePlots(self.server, lab.rate, lab.title)
        dock(gui, left)

    def listen(self) -> None:
        """Connect clicks and keys."""
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
        self.session.emergency(f"browser {client.client_id}")

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

    # What the drawing thread does.

    def latest(self) -> tuple[Frame | None, DrawingStyle]:
        """The newest frame, and how to draw it."""
        return self.session.frame, self.view.drawing_style()

    def refresh(self) -> None:
        """Refresh banner and panels, whether there is anything to draw or not."""
        self.session.browsers(self.browsers())  # first: whatever fails below, it is done
        self.notices.tell()
        now = time.monotonic()
        if now < self.banner_due:
            return
        self.banner_due = now + BANNER
        state, status = self.session.state, self.session.status
        self.state.refresh(state, status)
        if self.lab.injected.path == "hand" and self.session.frame is not None:
            self.hand.draw(self.session.frame)
        if now < self.panels_due:
            return
        self.panels_due = now + PANELS
        armed = status is not None and status.arm == "armed" and state.phase == "open"
        self.rule.refresh(state, armed)
        self.place.refresh(state, status, armed)
        self.recording.refresh(state, armed)
        self.time_line.refresh()
        self.log.refresh()

    def measure(self) -> None:
        """Show what is measured."""
        status, readings = self.session.status, self.session.readings
        if self.drawing.drawn is None or status is None:
            return
        frame, drawn_as = self.drawing.drawn
        played = self.session.replaying
        when = "" if played is None else describe_moment(played)
        shown = contents(status, frame, readings, self.browsers(), self.selected, when)
        self.monitors.show(shown)
        self.view.fit(frame)
        self.monitors.colours(drawn_as, frame)
        if frame.cars is not None:
            self.plots.refresh(readings, roster(status), frame.cars.length)

    def browsers(self) -> int:
        """Number of browsers that watch."""
        return len(self.server.get_clients())
