"""A control that follows the flock takes no value from a browser before that is sent."""

from __future__ import annotations

import asyncio
from concurrent.futures import Future
from types import SimpleNamespace

import viser

from app.viewer.panels.followed_value import FollowedValue
from tests.viewer.waiting import until


def test_what_a_browser_gives_is_sent_though_another_thread_shows_the_flocks_value():
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        slider = server.gui.add_slider("eta", 0.0, 2.0, 0.1, 0.0)
        sent, answer = [], Future()

        def send(value, _event):
            sent.append(value)
            return answer

        followed = FollowedValue(slider, send, lambda: 0.0)

        async def turn():
            slider._impl.value = 1.0  # as viser does some time before it calls who waits for it
            followed.follow(0.0)
            await followed.changed(SimpleNamespace(client=object()))

        async def later():
            return slider.value

        asyncio.run_coroutine_threadsafe(turn(), followed.loop).result(60)
        assert sent == [1.0]
        followed.follow(0.0)
        shown = asyncio.run_coroutine_threadsafe(later(), followed.loop).result(60)
        assert shown == 1.0, "its answer is still to come"
        answer.set_exception(ValueError("refused"))
        until(lambda: slider.value == 0.0)
    finally:
        server.stop()
