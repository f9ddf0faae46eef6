"""What other threads give to viser's loop is handed over: none of them sets an event of it."""

from __future__ import annotations

import asyncio
import threading

import pytest

from app.front.server import close_server, open_server
from app.front.viser_internals import LoopEvent
from tests.viewer.waiting import until


@pytest.fixture
def setters(monkeypatch):
    """The threads that have set an event."""
    found: list[int] = []
    set_it = asyncio.Event.set

    def noting(event) -> None:
        found.append(threading.get_ident())
        set_it(event)

    monkeypatch.setattr(asyncio.Event, "set", noting)
    return found


def test_no_event_of_visers_loop_is_set_by_another_thread(setters):
    server = open_server(port=0)
    try:
        loop_thread = server._websock_server._server_thread.ident
        del setters[:]
        with server.atomic():  # here viser tells its loop nothing but by setting the event
            server.gui.add_checkbox("mark", False)
            server.gui.add_html("")
        until(lambda: setters)
        assert set(setters) == {loop_thread}
    finally:
        close_server(server)


def test_of_many_settings_at_once_one_is_handed_over_and_all_wake_who_waits():
    loop = asyncio.new_event_loop()
    handed: list[object] = []
    call = loop.call_soon_threadsafe

    def noting(callback, *arguments):
        handed.append(callback)
        return call(callback, *arguments)

    loop.call_soon_threadsafe = noting
    event = LoopEvent(loop)
    for _ in range(100):
        event.set()
    assert len(handed) == 1
    assert not event.is_set()
    loop.run_until_complete(asyncio.wait_for(event.wait(), 10.0))
    event.clear()
    event.set()
    assert len(handed) == 2
    loop.run_until_complete(asyncio.wait_for(event.wait(), 10.0))
    loop.close()
    event.clear()
    event.set()  # nobody is there any more
