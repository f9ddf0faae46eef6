"""Draws the simulation's latest frame, and brings the panels up to date, in a thread of its own."""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Callable

from app.viewer.scene.scene import Scene
from app.viewer.scene.shown.frame import Frame
from app.viewer.scene.shown.look import Look, as_birds

PANELS = 0.25
"""Time between two refreshments of the panels, s."""
FASTEST, SLOWEST = 1 / 40, 1 / 4
"""Shortest and longest time between two frames drawn, s."""
LOOK_AGAIN = 0.005
"""Shortest time between two looks for a new frame, s."""
BANDWIDTH = 16e6
"""What all browsers together may be sent, bytes/s."""
AGENT_BYTES = 28
"""What one agent takes in one frame, bytes."""
BIRD_BYTES = 74
"""What a bird takes: a body and wings of its own."""


def period(agents: float, browsers: int, bandwidth: float = BANDWIDTH) -> float:
    """Time between two frames, s: longer for a large flock and for many browsers.

    `bandwidth`: what all of these together may be sent, bytes/s.

    >>> round(1 / period(1000, 1)), round(1 / period(1000, 40))
    (40, 14)
    """
    if browsers == 0:
        return SLOWEST
    return min(max(FASTEST, agents * AGENT_BYTES * browsers / bandwidth), SLOWEST)


def load(frame: Frame, look: Look) -> float:
    """What a frame takes to send, as a number of agents."""
    count = len(frame.ids)
    return count * (BIRD_BYTES / AGENT_BYTES if as_birds(frame, look) else 1.0)


class Drawing:
    """Takes the newest frame when it is time for one; frames in between are never drawn."""

    def __init__(
        self,
        scene: Scene,
        latest: Callable[[], tuple[Frame | None, Look]],
        browsers: Callable[[], int],
        before: Callable[[], None],
        panels: Callable[[], None],
        bandwidth: float = BANDWIDTH,
    ):
        """`before` is called before every frame, `panels` four times a second."""
        self.scene = scene
        self.latest = latest
        self.browsers = browsers
        self.before = before
        self.panels = panels
        self.bandwidth = bandwidth
        self.drawn: tuple[Frame, Look] | None = None
        self.closing = threading.Event()
        self.thread = threading.Thread(target=self.live, name="drawing", daemon=True)

    def start(self) -> None:
        """Begin to draw."""
        self.thread.start()

    def close(self) -> None:
        """Stop drawing."""
        self.closing.set()
        self.thread.join(2.0)

    def live(self) -> None:
        """Draw and refresh, until closed; what goes wrong is printed and tried again."""
        panels_due = due = 0.0
        while not self.closing.is_set():
            began = time.monotonic()
            try:
                self.before()
                if self.draw():
                    due = max(due, began - 0.5 * self.period()) + self.period()
                self.scene.look_through()
                if began >= panels_due and self.drawn is not None:
                    panels_due = began + PANELS
                    self.panels()
            except Exception as error:
                traceback.print_exception(error)
                self.closing.wait(1.0)
            self.closing.wait(max(LOOK_AGAIN, due - time.monotonic()))

    def period(self) -> float:
        """Time between two frames now, s."""
        if self.drawn is None:
            return period(0, self.browsers(), self.bandwidth)
        frame, look = self.drawn
        flocks = [one for one in (frame, frame.beside) if one is not None]
        agents = sum(load(one, look) for one in flocks)
        return period(agents, self.browsers(), self.bandwidth)

    def draw(self) -> bool:
        """Draw the latest frame if it, or the look, is new; whether there was one."""
        frame, look = self.latest()
        if frame is None or (self.drawn and self.drawn[0] is frame and self.drawn[1] == look):
            return False
        self.scene.show(frame, look)
        self.drawn = (frame, look)
        return True
