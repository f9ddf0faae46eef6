"""Draws the simulation's latest frame, and brings the panels up to date, in a thread of its own."""

from __future__ import annotations

import math
import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass

from app.viewer.scene.draw.drawn_frame import POINTS_BEYOND
from app.viewer.scene.scene import Scene
from app.viewer.scene.shown.drawing_style import (
    DARTS,
    DENSITY_PERIOD,
    DrawingStyle,
    drawn_form,
    shows_density,
)
from app.viewer.scene.shown.frame import Frame

PANELS = 0.25
"""Time between two refreshments of the panels, s."""
FASTEST, SLOWEST = 1 / 40, 1 / 4
"""Shortest and longest time between two frames drawn, s."""
LOOK_AGAIN = 0.005
"""Shortest time between two looks for a new frame, s."""
REST = 0.1
"""Longest time between two looks with somebody there, s: what nobody tells is seen then."""
UNSEEN = 1.0
"""The same with nobody there, s."""
BURST = 3.0
"""What the thread may have worked beyond its share, s: at first it imports and draws much once."""
BANDWIDTH = 16e6
"""What all browsers together may be sent, bytes/s."""
AGENT_BYTES = 28
"""What one agent takes in one frame, bytes."""
ANIMAL_BYTES = 74
"""What a bird takes, a body and wings of its own, and a fish at most, a trunk and a tail."""
POINT_BYTES = 9
"""What a point takes: three numbers of two bytes, and a colour."""
DENSITY_BYTES = 200_000
"""What a picture of density takes, and so the single agents of one."""


def period(
    agents: float, browsers: int, bandwidth: float = BANDWIDTH, fastest: float = FASTEST
) -> float:
    """Time between two frames, s: longer for a large flock and for many browsers.

    `bandwidth` is what all of them together may be sent, bytes/s; `fastest` the shortest time, s.

    >>> round(1 / period(1000, 1)), round(1 / period(1000, 40))
    (40, 14)
    """
    if browsers == 0:
        return SLOWEST
    return min(max(fastest, agents * AGENT_BYTES * browsers / bandwidth), max(SLOWEST, fastest))


def load(frame: Frame, look: DrawingStyle) -> float:
    """What a frame takes to send, as a number of agents."""
    if shows_density(frame):
        return DENSITY_BYTES / AGENT_BYTES
    count = len(frame.ids)
    if count > POINTS_BEYOND:
        return count * POINT_BYTES / AGENT_BYTES
    return count * (1.0 if drawn_form(frame, look) == DARTS else ANIMAL_BYTES / AGENT_BYTES)


@dataclass(frozen=True)
class Rates:
    """How often there is something new on a page, and what that may take."""

    fastest: float = FASTEST
    """Shortest time between two frames drawn, s."""
    panels: float = PANELS
    """Time between two refreshments of the panels, s."""
    unseen: float = UNSEEN
    """Time between two frames, and two refreshments, while nobody is there, s."""
    bandwidth: float = BANDWIDTH
    """What all browsers together may be sent, bytes/s."""
    share: float = 1.0
    """Of a core for the thread that draws."""


class Drawing:
    """Takes the newest frame when it is time for one; frames in between are never drawn.

    With nobody there little is drawn, so that whoever comes finds what is, and no other run.
    """

    def __init__(
        self,
        scene: Scene,
        latest: Callable[[], tuple[Frame | None, DrawingStyle]],
        browsers: Callable[[], int],
        before: Callable[[], None],
        panels: Callable[[], None],
        news: threading.Event | None = None,
        moves: Callable[[], float] = lambda: math.inf,
        rates: Rates | None = None,
        changes: Callable[[], object] = lambda: None,
        clock: Callable[[], float] = time.monotonic,
        worked: Callable[[], float] = time.thread_time,
    ):
        """`before` is called before every frame, `panels` four times a second, and as soon as
        `changes` is another than before.

        `news` is set by others whenever there may be something new, `moves` says when the picture
        will be another by itself, s of `clock`. Without `news` it looks again and again. `worked`
        says how long the thread that asks has worked, s.
        """
        self.scene = scene
        self.latest = latest
        self.browsers = browsers
        self.before = before
        self.panels = panels
        self.news = news
        self.moves = moves
        self.rates = rates or Rates()
        self.changes = changes
        self.clock = clock
        self.worked = worked
        self.due = self.panels_due = 0.0
        """When the next frame may be drawn, and the panels are refreshed at the latest, s."""
        self.rested = -math.inf
        """When its work so far is within its share, s."""
        self.shown: object = None
        """What `changes` was when the panels were refreshed."""
        self.drawn: tuple[Frame, DrawingStyle] | None = None
        self.come = threading.Event()
        """Set when a browser has come."""
        self.closing = threading.Event()
        self.thread = threading.Thread(target=self.live, name="drawing", daemon=True)

    def start(self) -> None:
        """Begin to draw."""
        self.thread.start()

    def show_to_newcomer(self) -> None:
        """A browser has come: it is shown what there is now."""
        self.come.set()
        if self.news is not None:
            self.news.set()

    def close(self) -> None:
        """Stop drawing."""
        self.closing.set()
        self.show_to_newcomer()
        self.thread.join(2.0)

    def live(self) -> None:
        """Draw and refresh, until closed."""
        while not self.closing.is_set():
            self.draw_once()

    def draw_once(self) -> None:
        """Draw and refresh once, then wait; what goes wrong is printed, to be tried again."""
        began, worked = self.clock(), self.worked()
        if self.news is not None:
            self.news.clear()
        if self.come.is_set():
            self.come.clear()
            self.panels_due = self.due = 0.0
        try:
            changes = self.changes()
            self.before()
            if self.draw():
                self.due = max(self.due, began - 0.5 * self.period()) + self.period()
            self.scene.follow_cameras()
            if self.drawn is not None and (began >= self.panels_due or changes != self.shown):
                self.panels_due, self.shown = began + self.rates.panels, changes
                self.panels()
        except Exception as error:
            traceback.print_exception(error)
            self.closing.wait(1.0)
        self.rested = max(self.rested, began) + (self.worked() - worked) / self.rates.share
        self.wait_until_due(max(self.due, self.rested - BURST / self.rates.share))

    def wait_until_due(self, due: float) -> None:
        """Wait until a frame may be drawn at `due` (s), and then for something to draw."""
        now = self.clock()
        if self.news is None:
            self.closing.wait(max(LOOK_AGAIN, due - now))
        elif self.drawn is not None and not self.browsers():
            self.come.wait(self.rates.unseen)
        elif not self.closing.wait(max(0.0, due - now)):
            now = self.clock()
            self.news.wait(min(max(LOOK_AGAIN, min(self.panels_due, self.moves()) - now), REST))

    def period(self) -> float:
        """Time between two frames now, s."""
        agents, fastest = 0.0, self.rates.fastest
        if self.drawn is not None:
            frame, look = self.drawn
            frames = [frame for frame in (frame, frame.beside) if frame is not None]
            agents = sum(load(frame, look) for frame in frames)
            if any(map(shows_density, frames)):
                fastest = max(fastest, DENSITY_PERIOD)
        return period(agents, self.browsers(), self.rates.bandwidth, fastest)

    def draw(self) -> bool:
        """Draw the latest frame if it, or the look, is new; whether there was one."""
        frame, look = self.latest()
        if frame is None or (self.drawn and self.drawn[0] is frame and self.drawn[1] == look):
            return False
        self.scene.show(frame, look)
        self.drawn = (frame, look)
        return True
