"""The emergency stop's own way: nobody's queue holds it up, and no foreign page takes it.

What is held up here stands still for good until the stop has come through.
"""

from __future__ import annotations

import contextlib
import math
import socket
import threading
from http.client import HTTPConnection

import pytest

from app.front.client_addresses import USUAL
from app.front.server import on_emergency_stop
from app.live.control.arm import OperatorRequest
from app.live.operating.loop_process import NumberedRequest, RequestForwarder
from app.live.operating.operator import Operator
from tests.attacks.raw import Raw, alone, quietly, said
from tests.viewer.waiting import until

MARK = {"X-Flockscope": "stop"}
LATE = 60.0


@pytest.fixture
def stopped(server):
    """Who has pressed the emergency stop."""
    found: list[str] = []
    on_emergency_stop(server, found.append)
    return found


def post(server, headers=MARK, path="/emergency", method="POST"):
    """The answer to a request: status, and in words."""
    line = HTTPConnection("localhost", server.get_port(), timeout=LATE)
    try:
        line.request(method, path, headers=headers)
        answer = line.getresponse()
        return answer.status, answer.read().decode()
    finally:
        line.close()


@pytest.fixture
def standing(server):
    """viser's thread stands still until the event is set."""
    go_on, stands = threading.Event(), threading.Event()

    def stand():
        stands.set()
        go_on.wait(60.0)

    server._event_loop.call_soon_threadsafe(stand)
    assert stands.wait(LATE)
    yield go_on
    go_on.set()


@pytest.mark.usefixtures("standing")
def test_it_comes_through_while_visers_thread_stands_still(server, stopped):
    assert post(server) == (204, "")
    assert stopped == ["browser at 127.0.0.1"]


def test_it_comes_through_while_every_place_is_taken(server, stopped, count):
    silent = [alone(server.get_port()) for _ in range(USUAL.silent + USUAL.open_of_one)]
    begun = [alone(server.get_port()) for _ in range(USUAL.open_of_one)]
    for line in begun:
        line.sendall(b"GET / HTTP/1.1\r\n")
    try:
        assert post(server) == (204, "")
        assert len(stopped) == 1
        count(connections=len(silent) + len(begun) + 1)
    finally:
        quietly(*silent, *begun)


@pytest.mark.usefixtures("standing")
def test_it_comes_before_all_that_floods_have_sent(server, stopped, count):
    key = server.gui.add_command("Step", hotkey="t")
    pressed: list[int] = []

    async def note(event) -> None:
        pressed.append(event.client_id)

    key.on_trigger(note)
    floods = [socket.create_connection(("127.0.0.1", server.get_port())) for _ in range(3)]
    for line in floods:
        line.sendall(said(type="CommandTriggerMessage", uuid=key._impl.uuid) * 500)
    assert post(server)[0] == 204
    assert (len(stopped), pressed) == (1, [])
    count(messages=1500, connections=4)
    quietly(*floods)


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 403),
        ({"X-Flockscope": "go"}, 403),
        (MARK | {"Origin": "https://example.org"}, 403),
        (MARK | {"Origin": "null"}, 403),
        (MARK | {"Host": "example.org"}, 403),
        (MARK | {"Sec-Fetch-Site": "cross-site"}, 403),
        (MARK | {"Sec-Fetch-Site": "same-site"}, 403),
    ],
)
def test_no_foreign_page_can_stop_the_cars(server, stopped, headers, status):
    assert post(server, headers)[0] == status
    assert not stopped


def test_our_own_page_and_a_program_can(server, stopped):
    own = {"Origin": f"http://localhost:{server.get_port()}", "Sec-Fetch-Site": "same-origin"}
    assert post(server, MARK | own)[0] == 204
    assert post(server, MARK)[0] == 204
    assert len(stopped) == 2


def test_it_is_no_address_that_can_be_followed(server, stopped):
    assert post(server, method="GET")[0] == 404
    assert post(server, method="PUT")[0] == 405
    assert post(server, path="/else")[0] == 404
    assert not stopped


def test_where_there_is_nothing_to_stop_it_says_so(server):
    assert post(server) == (404, "there is nothing to stop here\n")


@pytest.mark.parametrize(
    "junk",
    [
        b"P",
        b"POST",
        b"POST \r\n\r\n",
        b"PRI * HTTP/2.0\r\n\r\n",
        b"P" * 100_000,
        b"P\x00\xff\r\n\r\n",
    ],
)
def test_junk_is_answered_or_dropped_and_the_door_stays_open(server, stopped, junk):
    with alone(server.get_port()) as line:
        line.settimeout(LATE)
        with contextlib.suppress(ConnectionError):
            line.sendall(junk)
            with contextlib.suppress(OSError):  # dropped already
                line.shutdown(socket.SHUT_WR)
            while line.recv(4096):
                pass
    assert post(server)[0] == 204
    assert len(stopped) == 1


class Line:
    """A loop or a pipe that notes what it is told."""

    def __init__(self):
        self.asked: list[OperatorRequest] = []
        self.late: list[OperatorRequest] = []

    def ask(self, request):
        self.asked.append(request)

    def note_overtaken(self, request):
        self.late.append(request)

    def send(self, asked):
        self.asked.append(asked)


STOP, RESET, ARM = (
    OperatorRequest("emergency", "a"),
    OperatorRequest("reset", "b"),
    OperatorRequest("arm", "b"),
)


def test_what_was_asked_before_a_stop_does_not_undo_it_though_it_comes_after_it():
    loop = Line()
    order = RequestForwarder(loop)
    order.ask(NumberedRequest(3, STOP))
    for asked in (NumberedRequest(1, RESET), NumberedRequest(2, ARM), NumberedRequest(4, RESET)):
        order.ask(asked)
    assert loop.asked == [STOP, RESET]
    assert loop.late == [RESET, ARM]


@pytest.fixture
def operator(monkeypatch):
    """An operator without a process: what it sends by its two ways."""
    monkeypatch.setattr(
        "app.live.operating.operator.multiprocessing.get_context", lambda _: FakeSpawn()
    )
    monkeypatch.setattr(Operator, "begin", lambda _: None)
    made = Operator(Empty(), None)
    yield made
    made.line.asked.clear()
    made.close()


class Empty:
    def to_toml(self):
        return ""


class End(Line):
    """An end of a pipe."""

    def close(self):
        pass


class FakeSpawn:
    """Makes pipes and processes that do nothing."""

    def Pipe(self, **_):  # noqa: N802
        return End(), End()

    class Process:
        def __init__(self, **_):
            pass

        def start(self):
            pass

        def is_alive(self):
            return False

        def terminate(self):
            raise AssertionError("nobody lives")

        kill = terminate


def test_a_stop_waits_for_nothing_at_the_operator(operator):
    with operator.lock:  # as while a status is taken in, or a request waits for space in the pipe
        thread = threading.Thread(target=operator.ask, args=(STOP,))
        thread.start()
        thread.join(LATE)
        assert not thread.is_alive()
        assert [one.request for one in operator.stops.asked] == [STOP]


def test_of_many_stops_one_is_sent_and_each_after_a_reset_anew(operator, monkeypatch):
    monkeypatch.setattr("app.live.operating.operator.AGAIN", math.inf)
    for _ in range(1000):
        operator.ask(STOP)
    assert len(operator.stops.asked) == 1
    operator.ask(RESET)
    for _ in range(1000):
        operator.ask(STOP)
    assert [one.number for one in (*operator.stops.asked, *operator.line.asked)] == [1, 3, 2]


def test_a_browser_on_the_page_has_the_other_way_too(server, stopped):
    with Raw(server.get_port()):
        until(server.get_clients, LATE)
        assert post(server)[0] == 204
    assert len(stopped) == 1
