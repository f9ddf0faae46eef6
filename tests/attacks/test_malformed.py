"""Messages that are none: a line of the log each, ten a minute, and no word of what they held."""

from __future__ import annotations

import random

import msgspec
import pytest

from app.front.client_addresses import RateLimit
from app.front.log import MOST, PERIOD, Log
from app.front.message_filter import (
    KINDS,
    MessageFilter,
    UnusableMessage,
    demand_shape,
    kind_of,
    shape,
)
from tests.attacks.raw import CONTINUED, TEXT, Raw, frame, said
from tests.live.stand_in import CAMERA
from tests.viewer.waiting import until

SECRET = "do-not-print-me"
LATE = 60.0
encode = msgspec.msgpack.encode


def deep(kind: str, depth: int) -> bytes:
    """A message with lists in lists."""
    head = encode({"type": kind, "uuid": SECRET})
    return bytes([head[0] + 1]) + head[1:] + encode("updates") + b"\x91" * depth + b"\xc0"


def malformed() -> list[bytes]:
    """Messages of every wrong kind."""
    chance = random.Random(3)
    wrong: list[object] = [
        SECRET, None, True, -1, 2**63, 1.5, [], {}, [1.0, float("nan"), 2.0], [1.0, 2.0],
        [[1.0]], {"value": SECRET}, b"x" * 200, [SECRET] * 3, float("inf"),
    ]  # fmt: skip
    made = [chance.randbytes(size) for size in range(40)]
    made += [encode(one) for one in (*wrong, {"kind": SECRET}, {"type": SECRET}, {"type": [1]})]
    made += [encode({"type": kind}) for kind in KINDS]
    made += [encode({"type": kind, SECRET: 1}) for kind in KINDS]
    made += [encode(CAMERA | {name: value}) for name in CAMERA if name != "type" for value in wrong]
    made += [deep(kind, 100_000) for kind in ("GuiUpdateMessage", SECRET)]
    made += [encode(CAMERA)[:-cut] for cut in (1, 5, 50)]
    return made


def unusable(message: bytes) -> str:
    """Why nobody can use a message; empty if somebody may."""
    try:
        kind = kind_of(message)
        if kind in KINDS:
            demand_shape(kind, message)
    except UnusableMessage as why:
        return str(why)
    return ""


def test_each_is_refused_without_a_word_of_it_and_viser_takes_all_others():
    refused = 0
    for message in malformed():
        why = unusable(message)
        refused += bool(why)
        assert SECRET not in why
        assert "\n" not in why
    assert refused > 150
    demand_shape("ViewerCameraMessage", encode(CAMERA))


def test_every_kind_that_is_heard_has_a_shape():
    for kind in KINDS:
        assert shape(kind)


def test_they_cost_ten_lines_and_no_traceback_and_the_page_goes_on(server, count, capfd):
    mark = server.gui.add_checkbox("mark", False)
    tick = said(type="GuiUpdateMessage", uuid=mark._impl.uuid, updates={"value": True})
    sent = connections = 0
    for heap in (malformed()[at::4] for at in range(4)):
        with Raw(server.get_port()) as browser:
            connections += 1
            for message in heap:
                sent += browser.say(frame(message))
            browser.say(frame(b"text", TEXT) + frame(b"\xff\xfe", TEXT))
            browser.say(frame(b"never begun", CONTINUED))
    with Raw(server.get_port()) as browser:
        until(server.get_clients, LATE)
        browser.say(tick)
        until(lambda: mark.value, LATE)
    printed = capfd.readouterr().err
    count(messages=sent, connections=connections, lines=printed.count("\n"))
    assert 1 <= printed.count("\n") <= MOST
    assert "Traceback" not in printed
    assert SECRET not in printed


def test_the_log_counts_what_it_does_not_print():
    now, written = [0.0], []
    log = Log(written.append, clock=lambda: now[0])
    for k in range(1000):
        log.line(f"line {k}")
    assert len(written) == MOST
    now[0] = PERIOD
    log.line("the next minute")
    assert written[MOST:] == ["990 more lines about browsers were not printed", "the next minute"]
    log.close()
    assert len(written) == MOST + 2


@pytest.fixture
def judge():
    """One connection's messages, a clock that is turned by hand, and what was complained of."""
    now, complaints = [0.0], []

    def clock():
        return now[0]

    made = MessageFilter(RateLimit(1e9, 1e9, clock), complaints.append, clock)
    return made, now, complaints


KEY = encode({"type": "CommandTriggerMessage", "uuid": "key"})


def test_nothing_is_heard_of_a_browser_that_has_not_sent_its_camera(judge):
    messages, _, _ = judge
    assert not messages.accepts(KEY)
    assert not messages.accepts(encode({"type": "ViewerCameraMessage"}))
    assert not messages.accepts(KEY)
    assert messages.accepts(encode(CAMERA))
    assert messages.accepts(KEY)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_has_its_rate_limit_and_who_goes_on_is_to_be_ended(judge, kind):
    messages, now, _ = judge
    messages.introduced = True
    empty = encode({"type": kind})
    limit = messages.kinds[kind]
    limit.left = 2.0
    before = messages.dropped.left
    for _ in range(3):
        messages.accepts(empty)  # each is dropped; the first two as they have no shape
    assert limit.left < 1.0
    assert before - messages.dropped.left == 11.0
    now[0] += 1.0
    assert limit.fill() == pytest.approx(min(limit.most, limit.rate), rel=0.1)
    for _ in range(400):
        messages.accepts(empty)
    assert messages.verdict


def test_frames_and_bytes_are_counted_before_anything_is_decoded(judge):
    messages, _, complaints = judge
    for _ in range(1000):
        messages.count_message()
        messages.count_bytes(100)
    assert not messages.verdict
    messages.count_message()
    assert messages.verdict
    assert not messages.accepts(encode(CAMERA))
    assert not complaints
