"""A control that shows the value that a flock has, and takes nothing from whoever turns it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import Any

import viser

from app.front.viser_internals import control_loop

DRAG = 1.0
"""Changes of a control that are less than this apart are one, s."""


class FollowedValue:
    """Sends what browsers give to a control, and has the control show what has come of it.

    The control changes on viser's thread alone: there a browser's value is stored and sent in one
    piece. What another thread stored in between would be sent in its place, and the user's lost.
    `send` gives the answer with the value that was taken, `now` tells what the flock has.
    """

    def __init__(
        self,
        control: Any,
        send: Callable[[Any, viser.GuiEvent], Future],
        now: Callable[[], Any],
    ):
        self.control = control
        self.send = send
        self.now = now
        self.loop = control_loop(control)
        self.answer: Future | None = None
        """To the value that was sent last."""
        self.sent = -math.inf
        """When that was."""
        control.on_update(self.changed)

    async def changed(self, event: viser.GuiEvent) -> None:
        """A browser has given a value."""
        if event.client is not None:
            self.expect(self.send(self.control.value, event))

    def give(self, value: Any, answer: Future) -> None:
        """Show a value that was sent otherwise."""
        self.control.value = value
        self.expect(answer)

    def expect(self, answer: Future) -> None:
        """Keep the control as it is until there is an answer, and while it may be dragged."""
        self.answer, self.sent = answer, time.monotonic()
        settle = partial(self.settle, self.control.value)
        answer.add_done_callback(partial(self.loop.call_soon_threadsafe, settle))

    def settle(self, value: Any, answer: Future) -> None:
        """On viser's thread: go back if a value was not taken, and none has come since."""
        refused = answer.cancelled() or answer.exception() is not None
        if self.control.value == value and (refused or answer.result() != value):
            self.control.value = self.now()

    @property
    def is_held(self) -> bool:
        """Whether somebody has just changed it: that may not have come to the flock yet."""
        is_open = self.answer is not None and not self.answer.done()
        return is_open or time.monotonic() - self.sent < DRAG

    def follow(self, value: Any) -> None:
        """From any thread: show what the flock has, unless somebody has just changed it."""
        if self.control.value != value and not self.is_held:
            self.loop.call_soon_threadsafe(self.take, value)

    def take(self, value: Any) -> None:
        """On viser's thread: the same."""
        if not self.is_held:
            self.control.value = value
