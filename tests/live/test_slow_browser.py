"""A browser that takes nothing, one that is stopped, and a page that is killed.

The control loop keeps its time, another browser's emergency stop comes through, and without the
page the cars stop.
"""

from __future__ import annotations

import itertools
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time

import pytest
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from app.live.laboratory.lab_file import example
from tests.browser.conftest import ARGUMENTS, CHROMIUM
from tests.live.opened_page import arm, opened
from tests.live.served_room import ServedRoom, descendants, is_there
from tests.live.stand_in import LITTLE, StandIn
from tests.live.waiting import until

SOON = 60.0
WATCHED = 3.0
"""Seconds for which the loop is watched."""
SLOWER = 0.6
"""Share of its usual ticks that the loop may come down to, on a machine that others use too."""
AT_ONCE = 8.0
"""Seconds within which an emergency stop is in the loop, on a machine that is very busy."""
LATEST, FURTHEST = 2.5, 0.75
"""Seconds until the cars stand, and metres that they come meanwhile."""


@pytest.fixture(scope="module")
def page():
    with opened(example()) as one:
        yield one


@pytest.fixture
def operator(page):
    """A browser that works; the cars are driving, armed by it."""
    with StandIn(page.server.get_port()) as browser:
        arm(page, browser, lambda: page.session.frame.speed.min() > 0.3)
        browser.usual, _ = pace(page)
        yield browser
        browser.stop()
        until(lambda: page.session.status.arm == "emergency", SOON)
        browser.press("Reset the emergency stop")
        until(lambda: page.session.status.arm == "safe", SOON)


def pace(page):
    """Ticks per second of the loop's own clock, and of this machine's."""
    before, began = page.session.status, time.monotonic()
    time.sleep(WATCHED)
    status, took = page.session.status, time.monotonic() - began
    ticks = status.tick - before.tick
    return ticks / (status.time - before.time), ticks / took


def keeps_its_time(page, usual):
    """The loop ticks as before, which a machine that is busy lets it, and the cars go on."""
    places = page.session.frame.position
    ticks, seen = pace(page)
    status = page.session.status
    assert status.period.median == pytest.approx(0.01, abs=0.002)
    assert ticks > SLOWER * usual
    assert seen > SLOWER * usual
    if status.arm == "armed":  # a machine that is very busy may have held them
        assert abs(page.session.frame.position - places).sum(axis=1).min() > 0.1


def stopped_within(page, browser):
    """Seconds from pressing the emergency stop until the loop has it."""
    began = time.monotonic()
    browser.stop()
    until(lambda: page.session.status.arm == "emergency", SOON)
    return time.monotonic() - began


def clog(page, before):
    """Make the way to the newest browser narrow, and wait until it is full."""
    until(lambda: len(page.server._websock_server._live_connections) > before, SOON)
    line = list(page.server._websock_server._live_connections.values())[-1]
    line.transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, LITTLE)
    until(lambda: line.paused, SOON)  # more than its buffer took, which it has partly passed on
    return line


def test_a_browser_that_takes_nothing_holds_nobody_up(page, operator):
    count = len(page.server._websock_server._live_connections)
    with StandIn(page.server.get_port(), reads=False):
        line = clog(page, count)
        drawn = page.drawing.drawn[0]
        keeps_its_time(page, operator.usual)
        assert page.drawing.drawn[0] is not drawn
        until(lambda: line.paused, SOON)  # what its buffers took a while ago comes to an end
        assert stopped_within(page, operator) < AT_ONCE


@pytest.fixture
def flood(page, operator):
    """A browser that moves a slider to and fro as fast as it can, and comes back when it is cut
    off; how often it was."""
    slider = operator.found("β")
    over = threading.Event()
    ends: list[str] = []

    def pour():
        with StandIn(page.server.get_port(), reads=False) as browser:
            for value in itertools.cycle((2.0, 2.1)):
                browser.say(type="GuiUpdateMessage", uuid=slider, updates={"value": value})
                if over.is_set():
                    return

    def pour_again():
        while not over.is_set():
            try:
                pour()
            except (ConnectionClosed, InvalidHandshake, OSError) as end:
                ends.append(type(end).__name__)

    thread = threading.Thread(target=pour_again, daemon=True)
    thread.start()
    yield ends
    over.set()
    thread.join(SOON)


def test_a_browser_that_never_stops_asking_holds_nobody_up(page, operator, flood):
    keeps_its_time(page, operator.usual)
    until(lambda: flood, SOON)
    assert stopped_within(page, operator) < AT_ONCE


@pytest.fixture
def chromium(page):
    """A real browser on the page, in a session of its own, which can be stopped as a whole."""
    if CHROMIUM is None or shutil.which(CHROMIUM) is None:
        pytest.skip("no chromium: install it to run this test")
    until(lambda: page.browsers() == 1, SOON)  # the operator's: those of the tests before are gone
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        asked = [CHROMIUM, *ARGUMENTS, "--headless=new", f"--user-data-dir={folder}", page.address]
        silent = subprocess.DEVNULL
        process = subprocess.Popen(asked, start_new_session=True, stdout=silent, stderr=silent)
        try:
            until(lambda: page.browsers() == 2, SOON)
            yield process
        finally:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def test_a_browser_that_is_stopped_holds_nobody_up(page, operator, chromium):
    os.killpg(chromium.pid, signal.SIGSTOP)
    keeps_its_time(page, operator.usual)
    assert stopped_within(page, operator) < AT_ONCE


@pytest.fixture(scope="module")
def served():
    """A page in a process of its own, with cars that are not its own."""
    pytest.importorskip("motioncapture")
    pytest.importorskip("serial")
    with ServedRoom("red", "blue") as room:
        yield room


def test_a_page_that_is_stopped_has_the_cars_held_until_they_are_armed_again(served):
    served.run()
    os.kill(served.process.pid, signal.SIGSTOP)
    try:
        until(lambda: served.plant.top_speed() < 0.05, SOON)
        until(lambda: served.states() == {"stopped"}, SOON)  # the loop told them
    finally:
        os.kill(served.process.pid, signal.SIGCONT)
    until(lambda: served.browser.can("Arm …"), SOON)
    assert served.states() == {"stopped"}
    assert served.plant.top_speed() < 0.05


def test_a_page_that_is_killed_stops_the_cars(served):
    served.run()
    others = descendants(served.process.pid)
    assert others
    served.process.kill()
    seconds, metres = served.stops()
    assert seconds < LATEST
    assert metres < FURTHEST
    until(lambda: not any(map(is_there, others)), SOON)
    assert served.states() <= {"stopped", "lost"}
