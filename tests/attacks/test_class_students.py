"""Students who send what their pages never would: to others, to the teacher, about themselves."""

from __future__ import annotations

import json
import time
import zlib

import msgspec
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from app.front.message_filter import LARGEST
from tests.attacks.knocking import knock, let_in, request, status, upgrade
from tests.attacks.raw import TEXT, frame
from tests.classroom.running import BUSY, Person, number_of, roster, running, seen
from tests.classroom.test_class import buttons
from tests.viewer.waiting import until

SEATS = 12
TEACHERS = (
    "/class",
    "/class/",
    "/class/roster",
    "/class/code.svg",
    "/class/choices.json",
    "/class/results.csv",
    "/class/results.svg",
    "/class/class.zip",
    "/%63lass",
    "/class%2froster",
    "//class",
    "/x/../class/roster",
    "/%2e%2e/class",
)
ACTIONS = (
    {"do": "role", "role": "own"},
    {"do": "start"},
    {"do": "freeze", "held": True},
    {"do": "say", "word": "no class today"},
    {"do": "renew"},
    {"do": "remove", "students": [1, 2, 3]},
    {"do": "ask", "question": {}},
    {"do": "stop-asking"},
    {"do": "end"},
)
OPEN = {"X-Flockscope": "scene", "Sec-Fetch-Site": "same-origin"}


@pytest.fixture(scope="module")
def ours(tmp_path_factory):
    """A class that runs, for all tests of this file."""
    with running(tmp_path_factory.mktemp("class"), "--students", str(SEATS)) as found:
        yield found


@pytest.fixture(scope="module")
def teacher(ours):
    """Its teacher."""
    return ours.teacher()


@pytest.fixture(scope="module")
def ada(ours):
    """One who means well, and watches."""
    return ours.student("Ada")


@pytest.fixture(scope="module")
def eve(ours, teacher):
    """One who does not, with a flock of her own."""
    found = ours.student("Eve")
    teacher.do("role", role="own", students=[number_of(teacher, "Eve")])
    with found.connect():
        assert seen(teacher, "Eve")
    return found


def ending(line, most: float = BUSY) -> int:
    """The code with which a websocket is closed within `most` s; 0 if it is not."""
    end = time.monotonic() + most
    try:
        while time.monotonic() < end:
            line.recv(timeout=most)
    except ConnectionClosed as closed:
        return closed.rcvd.code if closed.rcvd is not None else 1006
    except (TimeoutError, OSError) as error:
        return 0 if isinstance(error, TimeoutError) else 1006
    return 0


def serves(ada, teacher) -> None:
    """The others notice nothing."""
    assert ada.ask("/alive").status == 200
    assert roster(teacher)["word"] == ""
    with ada.connect() as line:
        assert line.recv(timeout=BUSY)


def test_the_teachers_addresses_and_actions_are_no_students(ours, teacher, ada, eve, count):
    before = roster(teacher)
    tried = 0
    for who in (ada, eve):
        for path in TEACHERS:
            answer = who.ask(path)
            assert answer.status in (403, 404, 503), path
            assert ours.code not in answer.text
            tried += 1
        for action in ACTIONS:
            answer = who.send("/class/do", action)
            assert answer.status in (403, 429)
            tried += 1
        for number in (0, 1, 2, "1%20", "%D9%A1", "1.0"):
            for path in ("", "scene.json", "open?scene=model%3Avem&sure=1"):
                answer = who.ask(f"/at/{number}/{path}", headers=OPEN)
                assert answer.status in (403, 404, 429), answer
                tried += 1
    after = roster(teacher)
    assert after["code"] == before["code"]
    assert not after["over"]
    assert [one["name"] for one in after["students"]] == ["Ada", "Eve"]
    serves(ada, teacher)
    count(requests=tried)


def test_a_students_cookie_under_the_teachers_name_is_nobodys(ours, eve):
    mine = eve.cookies[f"flockscope-student-{ours.port}"]
    forged = Person(ours.port, {f"flockscope-teacher-{ours.port}": mine})
    assert forged.ask("/class").status in (403, 429)
    both = Person(ours.port, {**eve.cookies, f"flockscope-teacher-{ours.port}": mine})
    assert both.ask("/class").status == 403


def test_who_watches_moves_nothing_of_the_teachers(teacher, ada, count):
    with teacher.connect() as line:
        found = buttons(line)
        assert until(lambda: (roster(teacher)["mine"] or {}).get("running"), BUSY)
        model = roster(teacher)["mine"]["model"]
        with ada.connect() as hers:
            for uuid in found[:100]:
                press = {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": True}}
                hers.send(msgspec.msgpack.encode(press))
            hers.ping().wait(BUSY)
        opened = ada.ask("/open?scene=model%3Acouzin&sure=1", headers=OPEN)
        assert opened.status in (400, 403, 404)
        mine = roster(teacher)["mine"]
        assert until(lambda: roster(teacher)["mine"]["tick"] > mine["tick"], BUSY)
        assert roster(teacher)["mine"]["model"] == model
    count(messages=min(100, len(found)), requests=1)


def test_who_is_moved_or_taken_out_keeps_no_line_to_what_they_had(ours, teacher, count):
    finn, gail = ours.student("Finn"), ours.student("Gail")
    number = number_of(teacher, "Finn")
    teacher.do("role", role="own", students=[number])
    with finn.connect() as own, gail.connect() as watching:
        assert own.recv(timeout=BUSY)
        teacher.do("role", role="watching", students=[number])
        assert ending(own) == 1001  # a page of ours has long connected anew
        teacher.do("remove", students=[number_of(teacher, "Gail")])
        assert ending(watching) == 1001
    assert gail.ask("/class/mine").status == 403
    with pytest.raises(InvalidStatus):
        gail.connect()
    teacher.do("remove", students=[number])
    count(lines=2)


def test_a_flock_that_is_held_opens_nothing(teacher, eve):
    number = number_of(teacher, "Eve")
    assert teacher.do("freeze", held=True, students=[number]).text == "held"
    try:
        before = json.loads(eve.ask("/scene.json").text)["command"]
        answer = eve.ask("/open?scene=model%3Acouzin&sure=1", headers=OPEN)
        assert (answer.status, answer.text) == (403, "your flock is held by the teacher\n")
        assert json.loads(eve.ask("/scene.json").text)["command"] == before
    finally:
        teacher.do("freeze", held=False, students=[number])


def test_odd_addresses_reach_no_other_server_and_split_no_answer(ours, teacher, ada, eve, count):
    odd = (
        "//evil.example/x",
        "/\\evil.example",
        "/@evil.example/",
        "/:80@evil.example",
        "/x%0d%0aSet-Cookie:%20a=b",
        "/x%23y",
        "/x%3Fwebsocket=ws://evil.example",
        "/..%2f..%2f..%2fetc/passwd",
        "/../../../../etc/passwd",
        "/.ssh/id_rsa",
        "http://evil.example/scene.json",
        "http://127.0.0.1:22/class",
    )
    cookie = f"Cookie: {eve.cookie}"
    for path in odd:
        answer = knock(ours.port, request(f"GET {path} HTTP/1.1", cookie))
        assert status(answer) in (400, 403, 404) or path.endswith("scene.json"), (path, answer)
        assert b"Set-Cookie" not in answer
        assert b"root:" not in answer
    huge = eve.ask("/open?scene=" + "A" * 7000, headers=OPEN)
    assert huge.status == 400
    assert eve.ask("/open?scene=" + "A" * 9000, headers=OPEN).status in (400, 414)
    serves(ada, teacher)
    count(requests=len(odd) + 2)


def test_websockets_of_another_kind_are_refused(ours, teacher, ada, eve, count):
    cookie = f"Cookie: {eve.cookie}"
    kinds = (
        upgrade("/", cookie, protocol=""),
        upgrade("/", cookie, version="99"),
        upgrade("/", cookie, version=""),
        upgrade("/", cookie).replace(b"Sec-WebSocket-Key: ", b"X-Key: "),
        upgrade("/", cookie).replace(b"Connection: Upgrade", b"Connection: close"),
        upgrade("/", cookie).replace(b"GET / ", b"HEAD / "),
        upgrade("/class/mine", cookie, protocol=""),
        upgrade("/alive", cookie, protocol=""),
        upgrade("/", cookie, "Origin: http://evil.example"),
    )
    older = knock(ours.port, upgrade("/", cookie, protocol="viser-v0.0.1"), timeout=5.0)
    assert b"Version mismatch. Server: " in older  # which viser's page shows
    for sent in kinds:
        answer = knock(ours.port, sent, timeout=5.0)
        assert status(answer) in (400, 403, 405, 429), (sent, answer[:300])
    serves(ada, teacher)
    count(websockets=len(kinds))


def packed_bomb(size: int) -> bytes:
    """A deflated frame that unpacks to so many bytes."""
    packing = zlib.compressobj(9, wbits=-15)
    data = packing.compress(bytes(size)) + packing.flush(zlib.Z_SYNC_FLUSH)
    return frame(data.removesuffix(b"\x00\x00\xff\xff"), kind=0x2 | 0x40)


def test_frames_that_no_page_sends_end_the_line_of_who_sends_them(teacher, ada, eve, count):
    frames = {
        "bomb": packed_bomb(40 * LARGEST),
        "long": frame(bytes(LARGEST + 1)),
        "parts": frame(b"", last=False) + frame(bytes(LARGEST // 2), 0, last=False) * 3,
        "texts": frame(b"x", TEXT) * 2000,
        "pings": frame(b"x", 0x9) * 2000,
        "pongs": frame(b"", 0xA) * 2000,
        "tiny": frame(b"\xc0") * 2000,
        "kind": frame(b"x", 0x7),
        "length": b"\x82\xff" + b"\xff" * 8 + bytes(4),
        "half": b"\x82\xfe",
    }
    ends = {}
    for name, sent in frames.items():
        with until(lambda: let_in(eve), BUSY) as line:
            try:
                line.socket.sendall(sent)
            except OSError:
                ends[name] = 1006
                continue
            if name == "half":
                continue
            ends[name] = ending(line)
    assert set(ends.values()) <= {1002, 1006, 1007, 1008, 1009}, ends
    assert {ends["bomb"], ends["long"]} <= {1009, 1006}
    serves(ada, teacher)
    count(lines=len(frames))


def test_values_that_no_page_sends_are_refused_in_a_line(teacher, ada, count):
    wrong = [
        "[" * 60_000,
        '{"a":' * 10_000,
        "null",
        "[]",
        '"x"',
        "",
        "\x00",
        '{"do": "role", "role": "own", "students": [true]}',
        '{"do": "role", "role": "own", "students": [1.0]}',
        '{"do": "role", "role": "own", "students": [NaN]}',
        '{"do": "role", "role": "own", "students": [1e400]}',
        '{"do": "role", "role": "own", "students": [%s]}' % ("9" * 4000),
        '{"do": "role", "role": "own", "students": [%s]}' % ("9" * 5000),
        '{"do": "role", "role": "own", "students": "all"}',
        '{"do": "role", "role": ["own"]}',
        '{"do": "role", "role": "teacher"}',
        '{"do": "freeze", "held": 1}',
        '{"do": "freeze"}',
        '{"do": "say", "word": "\\ud800"}',
        '{"do": "say", "word": "\\u202eevil"}',
        '{"do": "say", "word": "a\\u0000b"}',
        '{"do": "say", "word": {"a": 1}}',
        '{"do": "\\ud800"}',
        '{"do": "__init__"}',
        '{"do": "open-point", "points": [1, 2]}',
        '{"do": "open-point", "points": [-1]}',
        '{"do": "curve"}',
    ]
    question = {
        "title": "Order",
        "parameter": "eta",
        "measure": {"observe": "polarisation", "over": 10},
        "ticks": 50,
        "values": [0.0, 6.0],
    }
    others = [
        {"title": "\ud800"},
        {"title": "x" * 10_000},
        {"title": ["x"]},
        {"parameter": "__class__"},
        {"parameter": ["eta"]},
        {"ticks": 10**30},
        {"ticks": True},
        {"ticks": -5},
        {"ticks": float("nan")},
        {"values": [float("nan")]},
        {"values": [float("inf")]},
        {"values": [True]},
        {"values": [10**400]},
        {"values": list(range(9_000))},
        {"values": {"a": 1}},
        {"measure": {"observe": "polarisation", "over": 10**12}},
        {"measure": {"observe": "../x", "over": 10}},
        {"measure": []},
        {"more": 1},
    ]
    wrong += [json.dumps({"do": "ask", "question": {**question, **one}}) for one in others]
    wrong += [f'{{"do": "ask", "question": {one}}}' for one in ("[]", "1", "null", '"x"')]
    head = {"X-Flockscope": "class", "Origin": teacher.base}
    for body in wrong:
        answer = teacher.ask("/class/do", "POST", body, head)
        assert answer.status == 400, (body[:80], answer.status, answer.text)
        assert len(answer.text.splitlines()) == 1, body[:80]
    assert teacher.ask("/class/do", "POST", '{"do": "end"}').status == 403  # without the mark
    serves(ada, teacher)
    count(bodies=len(wrong) + 1)


def test_names_without_end_take_seats_and_no_more(ours, teacher, ada, count):
    wild = (
        "<script>alert(1)</script>",
        '" onload="x',
        "$code",
        "{{7*7}}",
        "'; drop",
        "\u202eevil",
        "a\u0000b",
        "a\r\nSet-Cookie: x",
        "=1+1",
        "",
        " ",
        "x" * 400,
        "\u0301" * 20,
        "A" + "\u0301" * 20,
    )
    refused = there = 0
    for name in (*wild, *(f"Name {k}" for k in range(60))):
        answer = ours.stranger().form("/join", code=ours.code, name=name)
        assert answer.status in (303, 400, 429)
        if answer.status == 400:
            refused += 1
            assert answer.headers["X-Frame-Options"] == "DENY"
            assert "alert(1)</script>" not in answer.text
        there += answer.status == 303
    found = roster(teacher)["students"]
    assert len(found) <= SEATS
    assert refused >= 50
    full = ours.stranger().form("/join", code=ours.code, name="Late").text
    assert f"all {SEATS} seats of this class are taken" in full
    taken = [one["number"] for one in found if one["name"] not in ("Ada", "Eve")]
    assert teacher.do("remove", students=taken).status == 200
    serves(ada, teacher)
    count(names=len(wild) + 60, refused=refused)
