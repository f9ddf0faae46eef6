"""Files that are made for a browser when it asks for them."""

from __future__ import annotations

import asyncio
import traceback
from collections.abc import Callable

import viser

from app.viewer.panels.export_permit import ExportPermit
from worlds.input_error import InputError

FAILED = "This file could not be made"


class Sender:
    """Makes files aside, one after the other, and one at a time for each browser."""

    def __init__(self, allowed: ExportPermit | None = None) -> None:
        self.allowed = allowed or ExportPermit()
        self.asked: set[int] = set()
        """Browsers that wait for a file."""
        self.making = asyncio.Lock()

    async def send(self, client: viser.ClientHandle, name: str, make: Callable[[], bytes]) -> None:
        """Send a browser a file of some name; nothing if it waits for one."""
        if client.client_id in self.asked:
            return
        try:
            self.allowed.demand_file()
        except InputError as refusal:
            client.add_notification("flockscope", str(refusal), color="red")
            return
        self.asked.add(client.client_id)

        def made() -> bytes:
            with self.allowed.turn():
                return make()

        try:
            async with self.making:
                content = await asyncio.to_thread(made)
        except Exception as error:
            traceback.print_exception(error)
            client.add_notification("flockscope", f"{FAILED}: {name}", color="red")
            return
        finally:
            self.asked.discard(client.client_id)
        client.send_file_download(name, content, save_immediately=True)
