"""Tells every browser what the simulation has to say."""

from __future__ import annotations

import queue
import time

import viser

AGAIN = 5.0
"""Time in which a notice is not shown again, s: somebody may be dragging at what is refused."""
AT_ONCE = 3
"""Notices shown at a time."""


class Notices:
    """Takes notices from a queue and shows them in every browser."""

    def __init__(self, server: viser.ViserServer, waiting: queue.SimpleQueue[str]):
        self.server = server
        self.waiting = waiting
        self.shown: dict[str, float] = {}
        """When each was shown, s."""

    def tell(self) -> None:
        """Show what is waiting, a few at a time and none twice in a row."""
        now = time.monotonic()
        self.shown = {words: then for words, then in self.shown.items() if then > now - AGAIN}
        fresh = self.fresh()
        self.shown |= dict.fromkeys(fresh, now)
        for client in self.server.get_clients().values() if fresh else ():
            for notice in fresh:
                client.add_notification("flockscope", notice, color="red", auto_close_seconds=10.0)

    def unshown(self) -> list[str]:
        """What no browser can be shown any more, each line once."""
        lines: list[str] = []
        while not self.waiting.empty():
            lines.append(self.waiting.get())
        return list(dict.fromkeys(lines))

    def fresh(self) -> set[str]:
        """What is waiting and has not been shown just now."""
        found: set[str] = set()
        while len(found) < AT_ONCE:
            try:
                notice = self.waiting.get_nowait()
            except queue.Empty:
                break
            if notice not in self.shown:
                found.add(notice)
        return found
