"""Whoever comes to a page at its first moment finds it whole, and its flock begins."""

from __future__ import annotations

import contextlib
import inspect
import socket
import threading
from contextlib import closing
from functools import partial
from http.client import HTTPConnection

import pytest
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from agents.flock import Flock
from agents.spec import Spec
from app.front.message_filter import MessageFilter
from app.front.page_front import Front
from app.front.relay import HELD, Admission
from app.front.server import (
    admit_browsers,
    close_server,
    entrances,
    front_of,
    on_emergency_stop,
    open_server,
)
from app.live.laboratory.lab_file import example
from app.live.operating.lab_choices import Choices
from app.viewer.lab.laboratory import Laboratory
from app.viewer.lab.scene_requests import SCRIPTS
from app.viewer.live.page import LivePage
from app.viewer.live.session import Session
from app.viewer.notebook_view import NotebookAccess, NotebookView
from app.viewer.run.run_preset import preset_spec
from app.viewer.watching.watch_page import WatchPage
from tests.attacks.raw import Raw, said
from tests.live.stand_in import CAMERA
from tests.viewer.http_client import ask
from tests.viewer.stub_operator import Operators, driver
from tests.viewer.waiting import until

BESIDE = Spec("vem")
LATE = 60.0


def free_port() -> int:
    """A port that nobody has."""
    with socket.create_server(("127.0.0.1", 0)) as found:
        return found.getsockname()[1]


class Eager:
    """A client that tries to connect before the page is up, again and again until it may."""

    def __init__(self, port: int):
        self.port = port
        self.line: Raw | None = None
        self.over = threading.Event()
        self.thread = threading.Thread(target=self.try_to_come, daemon=True)

    def __enter__(self) -> Eager:
        self.thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.over.set()
        self.thread.join(LATE)
        if self.line is not None:
            self.line.line.close()

    def try_to_come(self) -> None:
        """Connect at the first answer."""
        while not self.over.is_set():
            with contextlib.suppress(OSError, EOFError, InvalidHandshake, ConnectionClosed):
                self.line = Raw(self.port)
                return


def laboratory(port: int, **more) -> Laboratory:
    """One that waits for somebody to watch."""
    return Laboratory(preset_spec("vem-a", agents=30, seed=2), port=port, waits=True, **more)


def runs(made: Laboratory) -> bool:
    """Whether its flock has begun."""
    run = made.simulation.run
    return run is not None and run.flock.tick > 3


@pytest.fixture
def live_page():
    """Makes pages of cars with stub operators."""
    operators, made = Operators(), []

    def make(port: int = 0) -> LivePage:
        def make_session(choices, recording) -> Session:
            return Session(choices, recording, operator=operators, driver=driver)

        made.append(LivePage(Choices.of(example()), port=port, make_session=make_session))
        return made[-1]

    yield make
    operators.gate.set()
    for page in made:
        page.close()


@pytest.mark.parametrize("beside", [None, BESIDE], ids=["alone", "beside"])
def test_a_flock_begins_for_who_connects_at_the_first_byte(beside):
    port = free_port()
    with Eager(port), closing(laboratory(port, beside=beside)) as made:
        until(lambda: runs(made), LATE)


def test_a_flock_that_is_shown_answers_who_connects_at_the_first_byte(monkeypatch):
    port = free_port()
    monkeypatch.setattr(
        "app.viewer.notebook_view.open_server",
        lambda **_: open_server(port=port, front=Front(SCRIPTS)),
    )
    flock = Flock(preset_spec("vem-a", agents=30, seed=2))
    with Eager(port):
        shown = NotebookView(flock, NotebookAccess(), 640, running=True)
        try:
            until(lambda: runs(shown.laboratory) and shown.laboratory.browsers() == 1, LATE)
            assert shown.flock.tick > 0
        finally:
            shown.end()


def test_cars_are_shown_to_who_connects_at_the_first_byte(live_page):
    port = free_port()
    with Eager(port):
        page = live_page(port)
        until(lambda: page.browsers() == 1 and page.drawing.drawn, LATE)


def test_many_who_connect_and_go_while_a_page_begins_keep_it_from_nothing():
    port = free_port()
    with contextlib.ExitStack() as held:
        storm = [held.enter_context(Eager(port)) for _ in range(12)]
        leaves = threading.Thread(target=come_and_go, args=(port, storm[0].over), daemon=True)
        leaves.start()
        with closing(laboratory(port)) as made:
            until(lambda: runs(made), LATE)
            until(lambda: made.browsers() >= len(storm), LATE)
        storm[0].over.set()
        leaves.join(LATE)


def come_and_go(port: int, over: threading.Event) -> None:
    """Load the page, connect and go at once, as somebody who keeps pressing reload."""
    while not over.is_set():
        with contextlib.suppress(
            OSError, EOFError, InvalidHandshake, ConnectionClosed
        ):  # it is down, or closes
            ask(port)
            line = Raw(port)
            line.line.socket.close()


# The same, without any chance in it.


def whole(made: object) -> set[str]:
    """What an object has."""
    return set(vars(made))


@pytest.fixture
def admitted(monkeypatch):
    """What each page had, and which threads it had begun, at the moment it let browsers in."""
    found: dict[str, set[str]] = {}
    decide = Admission.decide

    def noted(self, admits):
        frame = inspect.currentframe().f_back
        while admits and "self" not in frame.f_locals:
            frame = frame.f_back
        if admits:
            found[type(frame.f_locals["self"]).__name__] = whole(frame.f_locals["self"])
        decide(self, admits)

    monkeypatch.setattr(Admission, "decide", noted)
    return found


def test_every_page_is_whole_before_it_lets_browsers_in(admitted, live_page):
    with closing(laboratory(0)) as made, closing(WatchPage(made)) as watching:
        page = live_page()
        for one in (made, watching, page):
            assert admitted.pop(type(one).__name__) == whole(one)
        for one in (made, page):
            assert one.drawing.thread.is_alive()
    assert not admitted


@pytest.fixture
def early():
    """A server whose page is not whole yet, and those who have been called for a browser."""
    server = open_server(port=0)
    called: list[object] = []

    async def welcome(client):
        called.append(client)

    server.on_client_connect(welcome)
    yield server, called
    close_server(server)


def test_nobody_is_heard_before_the_page_is_whole_but_the_page_is_there(early):
    server, called = early
    port = server.get_port()
    with Raw(port) as browser:
        assert browser.line.recv(timeout=LATE)  # viser sends what there is
        assert ask(port).status == ask(port, "/alive").status == 200  # after it was asked
        assert not called
        assert not server.get_clients()
        admit_browsers(server)
        until(lambda: called, LATE)
        with Raw(port):
            until(lambda: len(called) == 2, LATE)


def test_who_goes_before_the_page_is_whole_is_never_called(early):
    server, called = early
    gone = Raw(server.get_port())
    assert gone.line.recv(timeout=LATE)
    gone.line.close()
    until(lambda: not server._websock_server._client_state_from_id, LATE)
    admit_browsers(server)
    with Raw(server.get_port()):
        until(lambda: called, LATE)
    assert len(called) == 1


@pytest.fixture
def judged(monkeypatch):
    """A clock that the test turns on, s, and a count of the messages that were judged by it."""
    now, count = [0.0], []
    judge = MessageFilter.accepts

    def counted(self, data):
        found = judge(self, data)
        count.append(data)
        return found

    monkeypatch.setattr(MessageFilter, "accepts", counted)
    by_it = partial(MessageFilter, clock=lambda: now[0])
    monkeypatch.setattr("app.front.server.MessageFilter", by_it)
    return now, count


def test_who_moves_its_camera_all_the_while_a_page_begins_is_not_cut_off(judged, early):
    """A browser tells of its camera 50 times a second: in 40 s more than a line takes at once."""
    (now, count), (server, called) = judged, early
    moved = said(**CAMERA)
    with Raw(server.get_port(), camera=False) as browser:
        for second in range(1, 41):
            assert browser.say(50 * moved, 50)
            until(lambda second=second: len(count) == 50 * second, LATE)
            now[0] += 1.0
        browser.say(said(**CAMERA | {"image_height": 1234}))
        until(lambda: len(count) == 2001, LATE)
        assert not called
        admit_browsers(server)
        (client,) = until(server.get_clients, LATE).values()
        assert client.camera.image_height == 1234
        assert not browser.closed


def test_what_a_browser_says_meanwhile_is_heard_later_within_bounds(judged, early):
    (_, count), (server, _) = judged, early
    box = server.gui.add_number("Number", 0)
    heard: list[float] = []

    async def told(event):
        heard.append(event.target.value)

    box.on_update(told)
    with Raw(server.get_port()) as browser:
        for value in range(1, HELD + 3):
            change = {"uuid": box._impl.uuid, "updates": {"value": value}}
            browser.say(said(type="GuiUpdateMessage", **change))
        until(lambda: len(count) == HELD + 3, LATE)
        admit_browsers(server)
        until(lambda: len(heard) == HELD, LATE)
        browser.say(said(type="GuiUpdateMessage", uuid=box._impl.uuid, updates={"value": -1}))
        until(lambda: heard[-1] == -1, LATE)
    assert heard == [*range(1, HELD + 1), -1]


def test_who_waits_is_sent_away_when_a_server_closes_whose_page_never_was_whole(early):
    server, called = early
    port = server.get_port()
    with Raw(port) as browser, socket.create_connection(("127.0.0.1", port), LATE) as line:
        line.sendall(f"GET /scene.json HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n".encode())
        assert browser.line.recv(timeout=LATE)
        assert ask(port).status == 200  # so the one before it is there, and waits
        closes = threading.Thread(target=close_server, args=(server,))
        closes.start()
        assert line.makefile("rb").readline() == b"HTTP/1.1 503 Service Unavailable\r\n"
    closes.join(LATE)
    assert not called


def test_what_is_asked_for_waits_until_the_page_is_whole(early):
    server, _ = early
    port = server.get_port()
    with socket.create_connection(("127.0.0.1", port), timeout=LATE) as line:
        line.sendall(f"GET /later HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n".encode())
        assert ask(port).status == 200
        front_of(server).route("/later", lambda _: front_of(server).routes["/alive"](None))
        admit_browsers(server)
        assert line.makefile("rb").readline() == b"HTTP/1.1 200 OK\r\n"


def test_what_waits_too_long_is_told_so(early, monkeypatch):
    server, _ = early
    monkeypatch.setattr("app.front.server.BEGINS", 0.01)
    answer = ask(server.get_port(), "/scene.json")
    assert answer.status == 503
    assert "just beginning" in answer.text


def test_an_emergency_stop_waits_until_it_is_known_what_it_stops(early):
    server, _ = early
    stopped: list[str] = []
    with closing(HTTPConnection("localhost", server.get_port(), timeout=LATE)) as line:
        line.request("POST", "/emergency", headers={"X-Flockscope": "stop"})
        assert ask(server.get_port()).status == 200
        on_emergency_stop(server, stopped.append)
        assert line.getresponse().status == 204
    assert stopped == ["browser at 127.0.0.1"]


def test_a_welcome_that_fails_keeps_no_flock_from_beginning_and_is_said(capfd, monkeypatch):
    def fail(drawing):
        if not drawing.closing.is_set():  # which calls it too
            raise RuntimeError("no such picture")

    monkeypatch.setattr("app.viewer.scene.drawing.Drawing.show_to_newcomer", fail)
    with closing(laboratory(0)) as made, Raw(made.port):
        until(lambda: runs(made), LATE)
    captured = capfd.readouterr()
    assert "no such picture" in captured.out + captured.err


@pytest.mark.parametrize(
    "said_first",
    ["", "GET /alive HTTP/1.1\r\n", "GET /alive HTTP/1.1\r\nHost: localhost:{}\r\n\r\n"],
    ids=["silent", "half", "whole"],
)
def test_no_line_that_is_kept_open_holds_up_who_closes_a_page(early, said_first):
    """viser gives up on its loop after 6 s, and leaves it running."""
    server, _ = early
    admit_browsers(server)
    port = server.get_port()
    with socket.create_connection(("127.0.0.1", port), timeout=LATE) as line:
        line.sendall(said_first.format(port).encode())
        if said_first.endswith("\r\n\r\n"):
            assert line.makefile("rb").readline() == b"HTTP/1.1 200 OK\r\n"
        assert ask(port).status == 200  # so the one before it is there
        close_server(server)
        assert server._event_loop.is_closed()


def test_visitors_that_waited_are_counted_out(early):
    server, _ = early
    seen = entrances[server].visitors
    with Raw(server.get_port()) as browser:
        assert browser.line.recv(timeout=LATE)
        assert seen.open == 1
    until(lambda: seen.open == 0, LATE)
