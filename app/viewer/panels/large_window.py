"""A window over one browser's page, to look at something large while the run goes on."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from typing import Any

import viser

from app.viewer.panels.style import CSS, block

MARK = block('<div class="fs-page fs-short fs-large"></div>')
"""By it the page knows what Escape and a click beside it close, and how wide it is."""

SETTLED = 0.1
"""Seconds until a browser has done what it was told last: what it is to change must be there."""


class Sheets:
    """Windows of one kind, at most one in each browser."""

    def __init__(self, server: viser.ViserServer, fill: Callable[[viser.GuiApi], Any]):
        """`fill` puts into a window what is in it, and returns what changes there."""
        self.fill = fill
        self.open: dict[int, Any] = {}
        """By browser, what is in its window."""
        self.lock = threading.Lock()
        """Held while what is in windows is changed: nothing is to be closed meanwhile."""
        server.on_client_disconnect(self.gone)

    def show(self, client: viser.ClientHandle, title: str) -> None:
        """Open one in a browser, unless one is open there."""
        if client.client_id in self.open:
            return
        gui = client.gui
        modal = gui.add_modal(title)
        with modal:
            gui.add_html(CSS + MARK)
            filled = self.fill(gui)
            done = gui.add_button("Close", icon=viser.Icon.X, color="gray")

        async def close(_event: viser.GuiEvent) -> None:
            with self.lock:
                known = self.open.pop(client.client_id, None) is not None
            if known:
                await asyncio.sleep(SETTLED)
                modal.close()

        done.on_click(close)
        self.open[client.client_id] = filled

    async def gone(self, client: viser.ClientHandle) -> None:
        """A browser is there no more."""
        with self.lock:
            self.open.pop(client.client_id, None)

    def each(self, change: Callable[[Any], None]) -> None:
        """Change what is in every window."""
        with self.lock:
            for filled in self.open.values():
                change(filled)
