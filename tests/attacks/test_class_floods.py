"""Students who send and ask without end: it costs them, and the others next to nothing."""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from collections.abc import Callable, Iterator

import psutil
import pytest
from websockets.exceptions import InvalidStatus

from app.classroom.front.class_request import MOST_PAGES, MOST_STREAMS, REQUESTS
from tests.attacks.knocking import let_in, request, upgrade
from tests.attacks.raw import frame
from tests.classroom.running import BUSY, Person, number_of, roster, running, seen
from tests.viewer.waiting import until

FLOOD = 5.0
"""Seconds that a flood takes."""
LATE, TIMES = 3.0, 5.0
"""Seconds in which others are answered meanwhile; or so many times what they wait without a flood,
where the machine is busy with something else."""
CALM = 1.0
"""Seconds for which that is looked at."""


@pytest.fixture(scope="module")
def ours(tmp_path_factory):
    """A class that runs, for all tests of this file."""
    with running(tmp_path_factory.mktemp("class")) as found:
        yield found


@pytest.fixture(scope="module")
def teacher(ours):
    """Its teacher."""
    return ours.teacher()


@pytest.fixture(scope="module")
def ada(ours, teacher):
    """One who means well, with a flock of her own that runs."""
    found = ours.student("Ada")
    teacher.do("role", role="own", students=[number_of(teacher, "Ada")])
    with found.connect():
        assert until(lambda: (seen(teacher, "Ada") or {}).get("tick"), BUSY)
    return found


@pytest.fixture
def eve(ours, teacher):
    """One who does not, with a flock of her own; another at every test."""
    found = ours.student("Eve")
    number = number_of(teacher, "Eve")
    teacher.do("role", role="own", students=[number])
    yield found
    with contextlib.suppress(StopIteration):
        teacher.do("remove", students=[number_of(teacher, "Eve")])


@contextlib.contextmanager
def meanwhile(ada: Person, teacher: Person) -> Iterator[dict[str, float]]:
    """How long the others wait at most: Ada for a picture and an answer, the teacher for theirs,
    and all of them before anything was done."""
    waits = {"picture_s": 0.0, "answer_s": 0.0, "teacher_s": 0.0}
    over = threading.Event()

    def noted(name: str, ask: Callable[[], object]) -> None:
        while not over.is_set():
            begun = time.monotonic()
            ask()
            waits[name] = max(waits[name], time.monotonic() - begun)
            time.sleep(0.05 if name != "picture_s" else 0.0)

    with until(lambda: let_in(ada), BUSY) as line:
        line.recv(timeout=BUSY)
        asked: dict[str, Callable[[], object]] = {
            "picture_s": lambda: line.recv(timeout=BUSY),
            "answer_s": lambda: ada.ask("/alive"),
            "teacher_s": lambda: roster(teacher),
        }
        threads = [threading.Thread(target=noted, args=one) for one in asked.items()]
        for one in threads:
            one.start()
        try:
            time.sleep(CALM)
            before = max(waits.values())
            waits.update(dict.fromkeys(waits, 0.0), before_s=before)
            yield waits
        finally:
            over.set()
            for one in threads:
                one.join()


def told(waits: dict[str, float]) -> dict[str, float]:
    """What is counted of them."""
    during = max(value for name, value in waits.items() if name != "before_s")
    assert during < max(LATE, TIMES * waits["before_s"]), waits
    return {name: round(value, 2) for name, value in waits.items()}


def opened(port: int, sent: bytes) -> socket.socket:
    """A line on which something has been asked."""
    line = socket.create_connection(("127.0.0.1", port), 10.0)
    line.sendall(sent)
    return line


def answered(line: socket.socket) -> int:
    """The status that comes back."""
    line.settimeout(BUSY)
    return int(line.recv(12).split(b" ")[1])


def test_a_student_has_so_many_pages_and_lines_and_no_more(ours, teacher, ada, eve, count):
    stream = request("GET /class/mine HTTP/1.1", f"Cookie: {eve.cookie}")
    with contextlib.ExitStack() as kept:
        lines = [kept.enter_context(opened(ours.port, stream)) for _ in range(40)]
        found = [answered(one) for one in lines]
        assert found.count(200) == MOST_STREAMS
        assert set(found) == {200, 429}
        pages = 0
        for _ in range(20):
            try:
                kept.enter_context(eve.connect())
                pages += 1
            except InvalidStatus:
                time.sleep(0.1)
        assert pages == MOST_PAGES
        assert ada.told("/class/mine")["name"] == "Ada"
        assert roster(teacher)["students"]
    count(streams=40, pages=20)


def test_requests_without_end_are_refused_and_others_answered(teacher, ada, eve, count):
    asked: list[int] = []
    with meanwhile(ada, teacher) as waits:
        began = time.monotonic()
        while time.monotonic() < began + FLOOD:
            asked += [eve.ask("/scene.json").status, eve.send("/class/hand-in", {}).status]
        seconds = time.monotonic() - began
    rate, most = REQUESTS
    assert len(asked) - asked.count(429) <= most + rate * seconds + 1
    count(requests=len(asked), refused=asked.count(429), **told(waits))


@pytest.mark.parametrize(
    ("kind", "sent"),
    [
        ("pieces", frame(b"", last=False) + frame(b"", 0, last=False) * 10_000),
        ("frames", frame(b"\x81\xa4type\xa1x") * 5_000),
        ("pings", frame(b"", 0x9) * 10_000),
        ("files", frame(bytes(1_000_000))),
    ],
    ids=lambda one: one if isinstance(one, str) else "",
)
def test_messages_without_end_cost_who_sends_them(ours, teacher, ada, eve, count, kind, sent):
    poured = lines = 0
    with meanwhile(ada, teacher) as waits:
        end = time.monotonic() + FLOOD
        while time.monotonic() < end:
            with (
                contextlib.suppress(OSError),
                opened(ours.port, upgrade("/", f"Cookie: {eve.cookie}")) as line,
            ):
                lines += 1
                line.settimeout(0.5)
                if b" 101 " not in line.recv(100):
                    time.sleep(0.2)
                    continue
                while time.monotonic() < end:
                    poured += line.send(sent)
    count(kind=kind, lines=lines, MB=round(poured / 1e6, 1), **told(waits))


def test_answers_that_nobody_reads_do_not_pile_up(ours, teacher, ada, eve, count):
    page = request("GET / HTTP/1.1", f"Cookie: {eve.cookie}")  # some megabytes, not packed
    front = psutil.Process(ours.process.pid)
    before = front.memory_info().rss
    with contextlib.ExitStack() as kept, meanwhile(ada, teacher) as waits:
        end, lines = time.monotonic() + FLOOD, 0
        while time.monotonic() < end:
            with contextlib.suppress(OSError):
                kept.enter_context(opened(ours.port, page))
                lines += 1
            time.sleep(0.02)
        grown = (front.memory_info().rss - before) / 1e6
    assert grown < 200.0
    count(lines=lines, front_MB=round(grown), **told(waits))


def test_coming_in_without_end_is_slowed_down_and_undone_by_the_teacher(ours, teacher, ada, count):
    rounds = came = 0
    with meanwhile(ada, teacher) as waits:
        end = time.monotonic() + FLOOD
        while time.monotonic() < end:
            mallory = ours.stranger()
            came += mallory.form("/join", code=ours.code, name="Mallory").status == 303
            rounds += 1
    teacher.do("renew")
    found = roster(teacher)
    assert len(found["students"]) <= found["seats"]
    others = [one["number"] for one in found["students"] if one["name"] != "Ada"]
    assert teacher.do("remove", students=others).status == 200
    late = ours.stranger()
    assert until(lambda: late.form("/join", code=found["code"], name="Late").status == 303, BUSY)
    assert [one["name"] for one in roster(teacher)["students"]] == ["Ada", "Late"]
    count(rounds=rounds, came=came, **told(waits))
