"""A laboratory whose desk is open, as its page sees it."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import Any, Protocol

from app.live.control.arm import Request
from app.live.control.events import Event
from app.live.control.look import Look
from app.viewer.live.framing import Setting, frame_of
from app.viewer.live.readings import RoomReadings
from app.viewer.live.tuning import Tuning
from app.viewer.live.worth_telling import notice_of
from app.viewer.scene.shown.frame import Frame

SILENCE = 1.0
"""Seconds without a new look after which the loop is said not to answer."""
LOOKS = 10
"""Looks that are kept to tell speeds by."""
BROWSER = "browser"
"""What the causes of requests begin with that come from a browser."""
GONE = "the last browser is gone"


class Log(Protocol):
    """Events as `app.live.control.events.Events` has them, by their number since the first."""

    def __len__(self) -> int: ...
    def __getitem__(self, which: slice, /) -> list[Event]: ...


class Counter(Protocol):
    """What a room uses of a `app.live.operating.desk.Desk`."""

    @property
    def events(self) -> Log:
        """What has happened."""
        ...

    trouble: str

    @property
    def alive(self) -> bool:
        """Whether the loop runs."""
        ...

    def ask(self, request: Request) -> None:
        """Ask for something."""
        ...

    def place(self, x: float, y: float) -> None:
        """Move the injected car of the hand, m."""
        ...

    def look(self) -> Look | None:
        """The newest look."""
        ...

    def close(self) -> None:
        """Stop the cars and end the loop."""
        ...


class Opened:
    """One opening of a room; `poll` is called by one thread, again and again."""

    def __init__(
        self,
        setting: Setting,
        desk: Counter,
        values: dict[str, Any],
        notify: Callable[[str], None],
    ):
        self.setting = setting
        self.desk = desk
        self.values = values
        """The parameters as the loop has them; replaced, never changed."""
        self.notify = notify
        self.tuning = Tuning(notify)
        self.newest: Look | None = None
        self.look: Look | None = None
        """The one that the frame is of."""
        self.frame: Frame | None = None
        self.readings = RoomReadings(setting.lab.injected)
        self.past: deque[Look] = deque(maxlen=LOOKS)
        self.heard = time.monotonic()
        self.known = 0
        """Events of the desk that have been passed on."""
        self.armed_by = ""
        """Who armed the cars; empty while they are not armed."""
        self.asked_to_hold = False
        """Whether this arming was asked to end because no browser is left."""

    @property
    def armed(self) -> bool:
        """Whether the cars are armed, as far as is known."""
        return self.armed_by != "" or (self.look is not None and self.look.arm == "armed")

    def poll(self) -> list[Event]:
        """Look at the loop; the events that are new."""
        self.newest = self.desk.look()
        known = len(self.desk.events)
        events = self.desk.events[self.known : known]
        self.known = known
        for event in events:
            self.hear(event)
        self.tuning.give_up()
        return events

    def hear(self, event: Event) -> None:
        """Take note of what an event says, and tell what is to be told of it."""
        words = notice_of(event, self.armed_by)
        if words:
            self.notify(words)
        taken = self.tuning.hear(event)
        if taken:
            self.values = self.values | taken
        if event.kind == "arm" and not self.armed_by:
            self.armed_by, self.asked_to_hold = event.cause, False
        elif event.kind in ("disarm", "hold", "emergency", "reset"):
            self.armed_by = ""

    def see(self) -> None:
        """Make of the newest look what there is to draw and to plot."""
        look = self.newest
        if look is None or look is self.look:
            return
        self.look = look
        self.heard = time.monotonic()
        self.frame = frame_of(self.setting, look, self.values, tuple(self.past))
        self.readings.note(look)
        self.past.append(look)

    def deserted(self) -> None:
        """No browser is left: hold the cars if it was a browser that armed them."""
        if self.armed_by.startswith(BROWSER) and not self.asked_to_hold:
            self.asked_to_hold = True
            self.desk.ask(Request("hold", GONE))

    @property
    def ended(self) -> str:
        """Why the loop has ended, if it has."""
        if self.desk.trouble:
            return self.desk.trouble
        return "" if self.desk.alive else "the control loop has ended: the cars stop themselves"

    @property
    def silence(self) -> str:
        """Says so if the loop has not been heard of for too long."""
        if time.monotonic() - self.heard < SILENCE:
            return ""
        return "the control loop does not answer: what is shown is old"
