"""Browsers that never stop: they are cut off with a word, and others are heard all the same."""

from __future__ import annotations

import contextlib
from dataclasses import replace

import msgspec
import pytest
from websockets.exceptions import InvalidMessage

from app.front.client_addresses import BEHIND_A_FRONT, TIMEOUT, USUAL, ClientAddresses
from app.front.message_filter import ALL, DROPPED, KINDS, LARGEST, TOO_MUCH
from app.front.server import entrances
from tests.attacks.raw import PROTOCOL, Raw, alone, quietly, said
from tests.live.stand_in import CAMERA
from tests.viewer.waiting import until

POUR = 20_000
"""Messages of one flood."""
LATE = 60.0
"""Seconds for what a busy machine takes its time to do."""


@pytest.fixture
def key(server):
    """A hotkey, and who has pressed it."""
    pressed: list[int] = []
    made = server.gui.add_command("Step one tick", hotkey="t")

    async def note(event) -> None:
        pressed.append(event.client_id)

    made.on_trigger(note)
    return made._impl.uuid, pressed


@pytest.fixture
def slider(server):
    """A slider, and the values that it has taken."""
    taken: list[float] = []
    made = server.gui.add_slider("eta", 0.0, 6.28, 0.01, 1.0)

    async def note(event) -> None:
        taken.append(event.target.value)

    made.on_update(note)
    return made, taken


@pytest.fixture
def pause(server):
    """A button, and how often it was pressed."""
    pressed: list[int] = []
    made = server.gui.add_button("Pause")

    async def note(event) -> None:
        pressed.append(event.client_id)

    made.on_click(note)
    return said(type="GuiUpdateMessage", uuid=made._impl.uuid, updates={"value": True}), pressed


def cut(browser: Raw) -> bool:
    return bool(until(lambda: browser.closed, LATE))


def test_a_step_key_that_never_stops_is_cut_off_and_a_pause_from_another_acts(
    server, key, pause, count, capfd
):
    uuid, pressed = key
    message, paused = pause
    with Raw(server.get_port()) as other, Raw(server.get_port()) as flooder:
        until(lambda: len(server.get_clients()) == 2)
        flooder.pour(said(type="CommandTriggerMessage", uuid=uuid), LATE, most=POUR)
        other.say(message)
        assert cut(flooder)
        assert (flooder.code, flooder.reason) == (1008, TOO_MUCH)
        until(lambda: paused, LATE)
        assert not other.closed
        until(lambda: len(server.get_clients()) == 1, LATE)
        count(messages=flooder.sent, acted_upon=len(pressed), connections=2)
        assert len(pressed) <= KINDS["CommandTriggerMessage"].most + 100
    errors = capfd.readouterr().err
    assert errors.count("\n") == 1
    assert "a browser at 127.0.0.1 is cut off" in errors


def test_a_slider_that_never_stops_is_cut_off(server, slider, count):
    control, taken = slider
    said_of_it = [
        said(type="GuiUpdateMessage", uuid=control._impl.uuid, updates={"value": value})
        for value in (1.0, 2.0)
    ]
    with Raw(server.get_port()) as flooder:
        until(server.get_clients)
        flooder.pour(b"".join(said_of_it), LATE, most=POUR // 2)
        assert cut(flooder)
        assert flooder.code == 1008
        until(lambda: not server.get_clients(), LATE)
        count(messages=2 * flooder.sent, acted_upon=len(taken), connections=1)
        assert len(taken) <= KINDS["GuiUpdateMessage"].most + 100


def test_a_person_at_work_is_never_cut_off(server, slider, key):
    control, taken = slider
    with Raw(server.get_port()) as browser:
        until(server.get_clients)
        for k in range(40):  # as much as a drag sends in two seconds, and a key held for one
            value = {"value": 0.01 * (k + 1)}
            browser.say(said(type="GuiUpdateMessage", uuid=control._impl.uuid, updates=value))
            browser.say(said(type="CommandTriggerMessage", uuid=key[0]))
            browser.say(said(**CAMERA))
        until(lambda: len(taken) == 40 and len(key[1]) == 40, LATE)
        assert not browser.closed


def test_a_camera_of_36_megabytes_is_not_taken(server, count, capfd):
    places = [float(k) for k in range(4_000_000)]
    huge = said(**(CAMERA | {"position": places}))
    assert len(huge) > 36_000_000
    with Raw(server.get_port()) as browser:
        until(server.get_clients)
        browser.say(huge)
        assert cut(browser)
        assert browser.code == 1009
    count(messages=1, bytes=len(huge), connections=1)
    assert capfd.readouterr().err == ""


def test_what_is_too_long_for_its_kind_costs_one_line(server, capfd):
    long = CAMERA | {"position": [1.0] * 400_000}
    assert len(msgspec.msgpack.encode(long)) < LARGEST
    with Raw(server.get_port()) as browser:
        until(server.get_clients)
        browser.say(said(**long))
        until(lambda: any("too many" in line for line in lines(capfd)), LATE)
        assert not browser.closed


def lines(capfd) -> list[str]:
    """What was printed on standard error since the last look."""
    return capfd.readouterr().err.splitlines()


def test_flooders_that_come_back_have_to_wait(server, key, count):
    message = said(type="CommandTriggerMessage", uuid=key[0])
    sent = 0
    for _ in range(6):
        with Raw(server.get_port()) as flooder:
            flooder.pour(message, LATE, most=2_000)
            assert cut(flooder)
            sent += flooder.sent
    until(lambda: not server.get_clients(), LATE)
    count(messages=sent, connections=6, acted_upon=len(key[1]))
    assert len(key[1]) <= 6 * (KINDS["CommandTriggerMessage"].most + 10)


def test_an_address_that_is_cut_off_again_and_again_has_a_page_every_two_seconds(count):
    now = [0.0]
    known = ClientAddresses(clock=lambda: now[0])
    connections = 0
    while now[0] < 60.0:
        wait = known.page("10.0.0.7")
        assert wait is not None
        now[0] += wait
        connections += 1
        known.cut("10.0.0.7")
    count(connections=connections, seconds=60)
    rate, burst = USUAL.pages
    assert connections <= (burst + 65.0 * rate) / (1.0 + USUAL.price) + 1.0
    assert known.page("10.0.0.8") == 0.0


def test_pages_that_come_all_at_once_are_let_in_one_after_the_other_or_refused(count):
    known = ClientAddresses(clock=lambda: 0.0)
    waits = [known.page("10.0.0.7") for _ in range(200)]
    rate, burst = USUAL.pages
    taken = [wait for wait in waits if wait is not None]
    assert len(taken) == burst + rate * TIMEOUT
    assert waits[: len(taken)] == taken
    assert taken == sorted(taken)
    count(connections=len(waits), refused=len(waits) - len(taken))


def test_a_class_behind_one_front_is_not_held_back(count):
    known = ClientAddresses(clock=lambda: 0.0, limits=BEHIND_A_FRONT)
    waits = [(known.enter("127.0.0.1"), known.page("127.0.0.1")) for _ in range(120)]
    known.cut("127.0.0.1")
    assert {*waits, (known.enter("127.0.0.1"), known.page("127.0.0.1"))} == {(0.0, 0.0)}
    count(connections=len(waits) + 1)


def test_pages_that_leave_while_they_wait_leave_no_line(server, monkeypatch, capfd):
    limits = replace(USUAL, pages=(5.0, 1.0))
    monkeypatch.setattr(entrances[server].visitors, "limits", limits)
    asks = (
        f"GET / HTTP/1.1\r\nHost: localhost:{server.get_port()}\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: {PROTOCOL}\r\n\r\n"
    ).encode()
    waiting = [alone(server.get_port()) for _ in range(5)]
    for line in waiting:
        line.sendall(asks)
        line.close()
    with Raw(server.get_port()):  # its turn comes after theirs
        until(server.get_clients, LATE)
    assert capfd.readouterr().err == ""


def test_lines_that_ask_nothing_whole_are_ended_from_the_oldest_and_others_get_in(server, count):
    held = [alone(server.get_port()) for _ in range(USUAL.silent + 20)]
    for line in held:
        with contextlib.suppress(OSError):  # ended already
            line.sendall(b"GET / HTTP/1.1\r\n")
    try:
        until(lambda: all(map(over, held[:20])), LATE)
        assert gets_in(server)
        count(connections=len(held), ended=sum(map(over, held)))
    finally:
        quietly(*held)


def gets_in(server) -> bool:
    """Whether another browser is let in."""
    try:
        with Raw(server.get_port()):
            return bool(until(server.get_clients, LATE))
    except (InvalidMessage, OSError):
        return False


def over(line) -> bool:
    """Whether the other side has ended a connection."""
    line.setblocking(False)
    try:
        return line.recv(1) == b""
    except BlockingIOError:
        return False
    except OSError:
        return True


def test_all_that_a_connection_may_drop_is_bounded():
    assert DROPPED[1] < ALL[1]
    assert max(kind.most for kind in KINDS.values()) < ALL[1]
