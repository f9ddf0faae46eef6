"""Browsers that have gone leave nothing behind, however and whenever they went."""

from __future__ import annotations

import gc
import threading
import weakref
from contextlib import closing

import pytest
import viser

from app.live.laboratory.lab_file import example
from app.live.operating.lab_choices import Choices
from app.viewer.lab.laboratory import Laboratory
from app.viewer.live.page import LivePage
from app.viewer.live.session import Session
from app.viewer.run.run_preset import preset_spec
from app.viewer.scene.shown.drawing_style import RIDE
from app.viewer.watching.watch_page import WatchPage
from tests.attacks.raw import Raw
from tests.live.stand_in import StandIn
from tests.viewer.stub_operator import Operators, driver
from tests.viewer.waiting import until

LATE = 60.0
TIMES = 12


@pytest.fixture
def handles(monkeypatch):
    """All that viser has of browsers, while anybody holds it."""
    alive: weakref.WeakSet[viser.ClientHandle] = weakref.WeakSet()
    begin = viser.ClientHandle.__init__

    def noted(self, *args, **options):
        begin(self, *args, **options)
        alive.add(self)

    monkeypatch.setattr(viser.ClientHandle, "__init__", noted)
    return alive


@pytest.fixture
def laboratory():
    with closing(Laboratory(preset_spec("vem-a", agents=30, seed=2), port=0)) as made:
        until(lambda: made.drawing.drawn, LATE)
        yield made


@pytest.fixture
def live_page():
    operators = Operators()
    page = LivePage(
        Choices.of(example()),
        port=0,
        make_session=lambda choices, recording: Session(
            choices, recording, operator=operators, driver=driver
        ),
    )
    yield page
    operators.gate.set()
    page.close()


def come_and_go(page) -> None:
    """One browser, as a person who presses reload."""
    with Raw(page.port) as browser:
        assert browser.line.recv(timeout=LATE)
        until(page.browsers, LATE)
    until(lambda: not page.browsers(), LATE)


def nothing_is_left(handles) -> None:
    """Waits until nobody holds anything of a browser."""

    def none() -> bool:
        gc.collect()
        return not handles

    until(none, LATE, "browsers that have gone are held")


def test_reconnects_leave_nothing_in_a_laboratory(handles, laboratory):
    for _ in range(TIMES):
        come_and_go(laboratory)
    nothing_is_left(handles)


def test_reconnects_leave_nothing_where_one_only_watches(handles, laboratory):
    with closing(WatchPage(laboratory)) as watching:
        for _ in range(TIMES):
            come_and_go(watching)
        nothing_is_left(handles)


def test_reconnects_leave_nothing_on_the_live_page(handles, live_page):
    for _ in range(TIMES):
        come_and_go(live_page)
    nothing_is_left(handles)


def test_who_goes_before_its_camera_is_placed_leaves_nothing(handles, laboratory):
    """viser's pool of threads is busy meanwhile, as it is in a full class."""
    free = threading.Event()
    pool = laboratory.server._thread_executor
    busy = [pool.submit(free.wait, LATE) for _ in range(pool._max_workers)]
    try:
        come_and_go(laboratory)
    finally:
        free.set()
    for one in busy:
        one.result(LATE)
    pool.submit(bool).result(LATE)  # after all that had queued
    nothing_is_left(handles)


@pytest.mark.parametrize("preset", ["top-down", "follow", RIDE])
def test_a_camera_that_is_placed_when_its_browser_has_gone_leaves_nothing(
    handles, laboratory, preset
):
    """The drawing thread looks who is there, and then places their cameras."""
    with Raw(laboratory.port):
        (client,) = until(laboratory.server.get_clients, LATE).values()
    until(lambda: not laboratory.browsers(), LATE)
    viewpoints = laboratory.scene._viewpoints
    viewpoints.place(client, preset)
    del client
    nothing_is_left(handles)
    assert not viewpoints._stands | viewpoints._followed | viewpoints._riders


def test_who_goes_while_it_is_asked_whether_to_arm_leaves_nothing(handles, live_page):
    with StandIn(live_page.port) as browser:
        browser.press("Arm …")
        until(lambda: live_page.state.confirming.open, LATE)
    nothing_is_left(handles)
    assert not live_page.state.confirming.open


def test_who_goes_with_the_guide_open_leaves_nothing(handles, laboratory):
    with StandIn(laboratory.port) as browser:
        browser.press("Guide")
        until(lambda: laboratory.guide.open, LATE)
    nothing_is_left(handles)
    assert not laboratory.guide.open
