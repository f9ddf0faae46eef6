"""Tells whoever draws that a browser has sent something, so that nobody has to look for it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

SOON = 0.002
"""Time from a message to its being told of, s: by then it has been carried out. Of many within it
one word is enough."""


class MessageNotifier:
    """Used by viser's thread; `tell` is called there."""

    def __init__(self, tell: Callable[[], None] = lambda: None):
        self.tell = tell
        self.waiting = False

    def note(self, loop: asyncio.AbstractEventLoop) -> None:
        """A message goes to viser now."""
        if not self.waiting:
            self.waiting = True
            loop.call_later(SOON, self.pass_on)

    def pass_on(self) -> None:
        """Tell of what has been carried out by now."""
        self.waiting = False
        self.tell()
