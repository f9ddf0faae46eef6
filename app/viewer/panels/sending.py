"""Files that are made for a browser when it asks for them."""

from __future__ import annotations

import asyncio
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext

import viser

from app.front.client_addresses import RateLimit
from app.viewer.run.allowance import Allowance
from worlds.input_error import InputError

# Which files may be made for browsers, and when: many pages may ask one machine for them.

AT_ONCE = 2.0
"""Files of one page at once; then they come at the rate that is allowed."""
in_turn = threading.Lock()
"""Held while a file is made, by all pages of this process that have an allowance."""


class ExportPermit:
    """What one page may have made; everything, without an allowance."""

    def __init__(self, allowance: Allowance | None = None):
        self.allowance = allowance
        self.limit = None if allowance is None else RateLimit(allowance.files, AT_ONCE)

    def demand_file(self) -> None:
        """Raise InputError if too many pictures and files have been asked for of late."""
        if self.allowance is not None and self.limit is not None and not self.limit.take():
            raise InputError(
                f"a class makes a picture or a file of a plot every {1 / self.allowance.files:g} s "
                "for each student: try again soon"
            )

    def demand_film(self) -> None:
        """Raise InputError where there are no films."""
        if self.allowance is not None and not self.allowance.films:
            raise InputError("a class makes no films: `flockscope lab` on your own machine does")

    def demand_page(self) -> None:
        """Raise InputError where there are no pages that run: to compile one takes long."""
        if self.allowance is not None:
            raise InputError(
                "a class makes no pages that run: `flockscope lab` on your own machine does"
            )

    @contextmanager
    def take_turn(self) -> Iterator[None]:
        """Within it a file is made: with an allowance one after the other, of all pages."""
        with nullcontext() if self.allowance is None else in_turn:
            yield


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
            with self.allowed.take_turn():
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
