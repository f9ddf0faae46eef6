"""A stranger on the network of the cameras, and a tracking that dies: the real library, armed cars.

What a stranger sends can keep the cars from driving, but never drive them, nor end the tracking.
"""

from __future__ import annotations

import os
import signal
import struct
import threading
from contextlib import contextmanager
from pathlib import Path

import pytest

from app.live.control.arm import OperatorRequest
from app.live.laboratory.lab_file import EXAMPLE_FILE, lab_from_toml
from app.viewer.live.panels.state_panel import banner_of
from live.full_room import FullRoom
from live.natnet_emulator import FRAME, message
from live.opened_page import opened
from live.served_room import descendants
from tests.live.waiting import until

pytest.importorskip("motioncapture")
pytest.importorskip("serial")

WITHIN = 60.0
"""Seconds within which what is waited for happens, on a machine that is very busy."""
EVERY = 0.05
"""Seconds between two datagrams of the stranger."""
FURTHEST = {1.0: 0.75, 0.16: 0.13}
"""Metres that cars of such a speed (m/s) come; blind they would go on for the whole of WITHIN."""


@pytest.fixture(scope="module", params=[0.16, 1.0], ids=["slow", "fast"])
def room(request):
    with FullRoom("red", "blue", speed=request.param) as one:
        yield one


def empty(_server):
    """No byte at all."""
    return lambda _k: b""


def newest(server):
    """The last frame, as it was sent."""
    return lambda _k: server.sent[-1]


def older(server):
    """A frame of a moment before the last."""
    return lambda _k: server.sent[-10]


def over_and_over(server):
    """The last frames, again and again in their order."""
    kept = list(server.sent)[-20:]
    return lambda k: kept[k % len(kept)]


@contextmanager
def stranger(server, makes):
    """A stranger who sends every 50 ms."""
    over = threading.Event()

    def sends():
        k = 0
        while not over.wait(EVERY):
            server.intrude(makes(k))
            k += 1

    thread = threading.Thread(target=sends)
    thread.start()
    yield
    over.set()
    thread.join()


@pytest.mark.parametrize("datagrams", [empty, newest, older, over_and_over])
def test_old_poses_that_a_stranger_has_handed_out_drive_no_car(room, datagrams):
    begun = len(room.operator.events)
    room.run()
    room.until(lambda: "run" in room.kinds(begun))  # it may come after the cars have begun
    since = len(room.operator.events)
    room.server.stop()
    try:
        with stranger(room.server, datagrams(room.server)):
            _, metres = room.stops()
            assert metres < FURTHEST[room.speed]
            room.until(lambda: "hold" in room.kinds(since), WITHIN)
            assert room.kinds(since).count("run") == 0
            assert room.plant.top_speed() < 0.05 * room.speed
    finally:
        room.server.go()


FORGED = {
    "marker sets": struct.pack("<ii", 1, 2**30),
    "markers": struct.pack("<ii", 1, 1) + b"a\0" + struct.pack("<i", 2**30),
}
"""Counts that end the library, by what they count: by a signal or an error, as memory has it."""


@pytest.mark.parametrize("forged", FORGED)
def test_a_forged_datagram_stops_the_cars_and_the_tracking_comes_back_unarmed(forged):
    with FullRoom("red") as room:
        room.run()
        room.kinds()
        since = len(room.operator.events)
        room.server.intrude(message(FRAME, FORGED[forged]))
        _, metres = room.stops()
        assert metres < 0.75

        def told(*words):
            return any(
                event.kind == "source" and all(word in event.words for word in words)
                for event in room.operator.events[since:]
            )

        room.until(lambda: room.status() and told("it is opened again in"), WITHIN)
        room.until(lambda: room.status() and told("the source works again"), WITHIN)
        room.until(lambda: not room.status().reasons, WITHIN)
        assert room.status().arm == "safe"
        assert "hold" in room.kinds(since)
        assert "arm" not in room.kinds(since)
        room.run()  # a person arms, and they drive


def tracking_of(loop):
    """The process of the tracking of a control loop."""
    (found,) = [
        one
        for one in descendants(loop)
        if b"spawn_main" in Path(f"/proc/{one}/cmdline").read_bytes()
    ]
    return found


@pytest.mark.parametrize("number", [signal.SIGSEGV, signal.SIGKILL])
def test_the_page_says_that_the_tracking_died_and_is_opened_again(number):
    with opened(lab_from_toml(EXAMPLE_FILE.read_text(encoding="utf-8"), "example")) as page:
        session = page.session
        session.ask("arm", "test")
        until(lambda: session.status.arm == "armed", WITHIN)
        events = len(session.events)
        os.kill(tracking_of(session.opening.operator.process.pid), number)

        def shown():
            banner = banner_of(session.state, session.status)
            return banner.kind == "safe" and any(
                number.name in one and "it is opened again in 1 s" in one for one in banner.reasons
            )

        until(shown, WITHIN)
        until(lambda: not session.status.reasons and not session.status.troubles, WITHIN)
        assert session.status.arm == "safe"
        kinds = [event.kind for event in session.events[events:]]
        assert {"source", "hold", "stop"} <= set(kinds)
        assert "arm" not in kinds
        assert session.state.phase == "open"
        session.opening.operator.ask(OperatorRequest("arm", "test"))
        until(lambda: session.status.arm == "armed", WITHIN)
