"""Events of viser's loop that other threads may set.

viser sets an `asyncio.Event` from whatever thread gives it a message. That wakes who waits from the
wrong thread: at times "deque mutated during iteration", at times nobody wakes.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from viser.infra import _infra
from viser.infra._async_message_buffer import AsyncMessageBuffer


class LoopEvent(asyncio.Event):
    """An event that is only ever set on its loop, whoever sets it."""

    def __init__(self, loop: asyncio.AbstractEventLoop, later: Callable[[], Any] = bool):
        """`later` says whether who sets it will set it again: so long nobody need be woken."""
        super().__init__()
        self.loop = loop
        self.later = later
        self.handing = threading.Lock()
        """Held from the hand-over to the setting: of many only one is on its way."""

    def set(self) -> None:
        """Set it now on its own loop, or soon from another thread."""
        try:
            if asyncio.get_running_loop() is self.loop:
                super().set()
                return
        except RuntimeError:  # a thread without a loop
            pass
        if not self.later() and self.handing.acquire(blocking=False):
            try:
                self.loop.call_soon_threadsafe(self.arrive)
            except RuntimeError:  # the loop is closed, and nobody waits
                self.handing.release()

    def arrive(self) -> None:
        """On its loop."""
        self.handing.release()
        super().set()


@dataclass
class Buffer(AsyncMessageBuffer):
    """viser's buffer of messages, with events that are handed over."""

    def __post_init__(self) -> None:
        self.message_event = LoopEvent(self.event_loop, lambda: self.atomic_counter)
        self.flush_event = LoopEvent(self.event_loop)


def hand_over() -> None:
    """Have viser use such buffers from now on."""
    _infra.AsyncMessageBuffer = Buffer  # type: ignore[misc]
