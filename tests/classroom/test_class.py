"""A class as a command: who comes in, what each of them sees, and what the teacher does."""

from __future__ import annotations

import csv
import io
import json
import os
import signal
import time

import msgspec
import psutil
import pytest
import zstandard
from cli.calling import refusal
from websockets.exceptions import ConnectionClosed

from agents import Flock
from app.classroom.class_file import load
from tests.classroom.running import BUSY, SCENE, number_of, roster, running, seen
from tests.viewer.waiting import until


@pytest.fixture(scope="module")
def ours(tmp_path_factory):
    """A class that runs, for all tests of this file."""
    with running(tmp_path_factory.mktemp("class")) as found:
        yield found


@pytest.fixture(scope="module")
def teacher(ours):
    """Its teacher."""
    return ours.teacher()


def closes(line) -> tuple[int, str]:
    """How a websocket ends."""
    try:
        while True:
            line.recv(timeout=BUSY)
    except ConnectionClosed as closed:
        return closed.rcvd.code, closed.rcvd.reason


def test_a_student_enters_by_the_code_and_is_in_the_roster(ours, teacher):
    ada = ours.student("  Ada ")
    assert ada.told("/class/mine")["name"] == "Ada"
    told = next(one for one in roster(teacher)["students"] if one["name"] == "Ada")
    assert (told["role"], told["here"]) == ("watching", False)
    with ada.connect():
        assert until(lambda: any(one["here"] for one in roster(teacher)["students"]), BUSY)


def test_the_code_may_be_typed_as_people_type(ours):
    typed = ours.stranger().ask(f"/{ours.code.upper().replace('-', '')}")
    assert typed.status == 200
    assert 'name="name"' in typed.text


def test_two_of_one_name_are_told_apart(ours):
    first, second = ours.student("Bo"), ours.student("bo")
    assert first.told("/class/mine")["name"] == "Bo"
    assert second.told("/class/mine")["name"] == "bo 2"


def test_a_name_is_shown_as_text(ours):
    wild = ours.student("<img src=x>")
    assert wild.told("/class/mine")["name"] == "<img src=x>"
    refused = ours.stranger().form("/join", code=ours.code, name="\u202eevil<script>")
    assert refused.status == 400
    assert "evil<script>" not in refused.text
    assert "evil&lt;script&gt;" in refused.text


def test_who_watches_sees_the_teachers_run_and_is_moved_to_a_flock_of_their_own(ours, teacher):
    cy = ours.student("Cy")
    with cy.connect() as line:
        assert line.recv(timeout=BUSY)
    before = cy.told("/class/mine")["moves"]
    number = number_of(teacher, "Cy")
    assert teacher.do("role", role="own", students=[number]).status == 200
    told = cy.told("/class/mine")
    assert (told["role"], told["moves"]) == ("own", before + 1)
    with cy.connect():
        found = seen(teacher, "Cy")
    assert (found["model"], found["agents"]) == ("Vicsek model", 30)
    scene = json.loads(cy.ask("/scene.json", headers={"Sec-Fetch-Site": "same-origin"}).text)
    assert f"--seed {1 + number}" in scene["command"]


def test_a_student_whose_flock_is_held_is_not_heard(ours, teacher):
    di = ours.student("Di")
    number = number_of(teacher, "Di")
    teacher.do("role", role="own", students=[number])
    with di.connect() as line:
        assert until(lambda: (seen(teacher, "Di") or {}).get("tick"), BUSY)
        assert teacher.do("freeze", held=True, students=[number]).text == "held"
        assert until(lambda: not seen(teacher, "Di")["running"], BUSY)
        for uuid in buttons(line):
            update = {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": True}}
            line.send(msgspec.msgpack.encode(update))
        tick = seen(teacher, "Di")["tick"]
        teacher.do("freeze", held=False, students=[number])
        assert until(lambda: seen(teacher, "Di")["tick"] > tick, BUSY)


def buttons(line) -> list[str]:
    """Of all buttons that a page has been told of, the names."""
    found = []
    for _ in range(400):
        try:
            data = line.recv(timeout=0.5)
        except TimeoutError:
            break
        size = int.from_bytes(data[8:16], "little")
        inner = zstandard.ZstdDecompressor().decompress(
            data[16 : 16 + size], max_output_size=int.from_bytes(data[:8], "little")
        )
        told = msgspec.msgpack.decode(inner)["messages"]
        found += [one["uuid"] for one in told if one["type"] == "GuiButtonMessage"]
    assert found
    return found


def test_a_word_to_all_reaches_all(ours, teacher):
    eve = ours.student("Eve")
    assert teacher.do("say", word="  look   up ").status == 200
    assert eve.told("/class/mine")["word"] == "look up"
    assert teacher.do("say", word="x" * 300).status == 400
    teacher.do("say", word="")


def test_all_begin_with_what_the_teacher_runs(ours, teacher):
    fay = ours.student("Fay")
    path = "/open?scene=model%3Acouzin&sure=1"
    opened = teacher.ask(path, headers={"X-Flockscope": "scene", "Sec-Fetch-Site": "same-origin"})
    assert opened.status == 200, opened.text
    number = number_of(teacher, "Fay")
    assert until(lambda: teacher.do("start", students=[number]).text.startswith("begun"), BUSY)
    with fay.connect():
        assert until(lambda: seen(teacher, "Fay")["model"].startswith("Couzin"), BUSY)


def test_results_are_points_and_the_same_numbers_as_a_run(ours, teacher):
    gus = ours.student("Gus")
    teacher.ask(
        "/open?scene=" + "model%3Avem&sure=1",
        headers={"X-Flockscope": "scene", "Sec-Fetch-Site": "same-origin"},
    )
    question = {
        "title": "Order against noise",
        "parameter": "eta",
        "measure": {"observe": "polarisation", "over": 10},
        "ticks": 50,
        "values": [0.0, 6.0],
    }
    asked = teacher.do("ask", question=question)
    assert asked.text == "asked: Order against noise", asked.text
    mine = gus.told("/class/mine")
    assert mine["role"] == "own"
    assert mine["question"]["value"] in ("0 rad", "6 rad")
    assert mine["question"]["answer"] == ""
    card = next(one for one in roster(teacher)["students"] if one["name"] == "Gus")
    assert (card["value"], card["handed"]) == (mine["question"]["value"], 0)
    with gus.connect():
        handed = gus.send("/class/hand-in", {})
    assert handed.status == 200, handed.text
    assert "polarisation over the last 10 ticks" in handed.text
    after = gus.told("/class/mine")
    assert after["question"]["answer"] == handed.text.strip()
    plot = json.loads(gus.ask("/class/plot.json").text)
    assert plot["points"][after["plot"]["mine"][0]][1] == ""
    shown = roster(teacher)["question"]
    assert len(shown["points"]) == 1
    card = next(one for one in roster(teacher)["students"] if one["name"] == "Gus")
    assert (card["value"], card["handed"]) == (mine["question"]["value"], 1)
    table = teacher.ask("/class/results.csv")
    assert table.headers["Content-Disposition"] == 'attachment; filename="order-against-noise.csv"'
    rows = list(csv.DictReader(io.StringIO(table.text)))
    assert rows[0]["student"] == "Gus"
    values = {"seed": int(rows[0]["seed"]), "eta": float(rows[0]["eta [rad]"])}
    again = Flock("vem", agents=30, size=5.0, **values)
    order = []
    for _ in range(50):
        again.run(1)
        order.append(again.observe("polarisation"))
    found = next(value for name, value in rows[0].items() if name.startswith("polarisation"))
    assert float(found) == pytest.approx(sum(order[-10:]) / 10, rel=1e-12)
    assert teacher.ask("/class/results.svg").text.startswith("<?xml")
    assert "opened in your flock: Gus" in teacher.do("open-point", points=[0]).text
    assert teacher.do("stop-asking").status == 200
    assert gus.send("/class/hand-in", {}).text.strip() == "no question is asked now"


def test_a_student_who_is_taken_out_is_out(ours, teacher):
    hal = ours.student("Hal")
    assert teacher.do("remove", students=[number_of(teacher, "Hal")]).status == 200
    assert hal.ask("/").status == 403
    assert ours.student("Hal").told("/class/mine")["name"] == "Hal"


def test_a_new_code_keeps_who_is_in(ours, teacher):
    ivy = ours.student("Ivy")
    teacher.do("renew")
    code = roster(teacher)["code"]
    assert code != ours.code
    assert ours.stranger().ask(f"/{ours.code}").status == 403
    assert ivy.ask("/alive").status == 200
    ours.link = f"{ours.link.rpartition('/')[0]}/{code}"
    assert ours.student("Jo").told("/class/mine")["name"] == "Jo"


def test_a_class_that_is_stopped_goes_on_from_its_file_with_who_was_in_it(tmp_path):
    with running(tmp_path, "--out", "kept.zip") as first:
        kim, teacher = first.student("Kim"), first.teacher()
        teacher.do("role", role="own")
        with kim.connect():
            assert seen(teacher, "Kim")["model"] == "Vicsek model"
            assert until(lambda: seen(teacher, "Kim")["tick"] > 0, BUSY)
        port = first.port
        with kim.listening("/class/mine") as line:
            first.stop()
            assert b'"over": true' not in line.read()
        assert first.process.returncode == 0
        assert "goes on, with those who are in it, from 'kept.zip'" in first.said[-1]
    assert list(load(tmp_path / "kept.zip").students) == ["Kim"]
    keys = tmp_path / "kept.zip.keys"
    assert keys.stat().st_mode & 0o777 == 0o600
    assert all(cookie not in keys.read_text() for cookie in kim.cookies.values())
    with running(tmp_path, scene="kept.zip") as second:
        assert second.code == first.code
        for one in (kim, teacher):  # cookies know the port of their class
            one.cookies = {
                name.replace(str(port), str(second.port)): value
                for name, value in one.cookies.items()
            }
            one.port = second.port
        told = kim.told("/class/mine")
        assert (told["name"], told["role"]) == ("Kim", "own")
        with kim.listening("/class/mine") as line:
            assert teacher.do("end").text == "the class is over"
            assert b'"over": true' in line.read()
        assert second.process.wait(BUSY) == 0
    assert not keys.exists()
    with running(tmp_path, scene="kept.zip") as third:
        assert third.code != first.code
        assert third.student("Kim").told("/class/mine")["role"] == "own"
        assert len(roster(third.teacher())["students"]) == 1


def test_a_class_that_cannot_be_kept_says_so_on_the_teachers_page(tmp_path):
    first = "from app.classroom import class_keeper; class_keeper.EVERY = 0.5"
    with running(tmp_path, "--out", "kept.zip", first=first) as ours:
        teacher = ours.teacher()
        (tmp_path / "kept.zip").mkdir()
        ours.student("Lea")
        why = until(lambda: roster(teacher)["unkept"], BUSY)
        assert "'kept.zip'" in why
        (tmp_path / "kept.zip").rmdir()
        assert until(lambda: not roster(teacher)["unkept"], BUSY)
    assert list(load(tmp_path / "kept.zip").students) == ["Lea"]


def test_a_process_that_dies_takes_its_flocks_alone_and_they_come_back(tmp_path):
    with running(tmp_path, "--workers", "2") as ours:
        teacher = ours.teacher()
        teacher.do("role", role="own")
        both = ours.student("One"), ours.student("Two")
        with both[0].connect() as first, both[1].connect() as second:
            assert seen(teacher, "One")
            assert until(lambda: seen(teacher, "Two")["tick"] > 5, BUSY)
            before = moves(both)
            os.kill(process_of_a_student(ours), signal.SIGKILL)
            assert until(lambda: moves(both) != before, BUSY)
            time.sleep(1.0)
            apart = [now - then for now, then in zip(moves(both), before, strict=True)]
            assert sorted(apart) == [0, 1]
            lost, kept = (both[0], second) if apart[0] else (both[1], first)
            assert kept.recv(timeout=BUSY)
            with lost.connect() as anew:
                assert anew.recv(timeout=BUSY)


def moves(students) -> list[int]:
    """How often each was told to connect anew; asked a few times a second."""
    time.sleep(0.3)
    return [who.told("/class/mine")["moves"] for who in students]


def process_of_a_student(ours) -> int:
    """A process with one laboratory: the teacher's serves two pages."""

    def pages(child) -> int:
        return sum(one.status == "LISTEN" for one in child.net_connections("tcp"))

    children = psutil.Process(ours.process.pid).children(recursive=True)
    return next(child.pid for child in children if pages(child) == 1)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["nowhere"], "unknown lesson or scene 'nowhere'"),
        (["scene.toml", "--key", "k.pem"], "--key is given alone"),
        (["scene.toml", "--certificate", "c.pem", "--key", "k.pem"], "--certificate 'c.pem'"),
        (["scene.toml", "--out", "class.txt"], "--out 'class.txt'"),
        (["absent.zip"], "class 'absent.zip' cannot be read"),
        (["broken.zip"], "broken.zip is not a class's file"),
    ],
)
def test_what_cannot_be_opened_is_one_line(tmp_path, options, said, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "broken.zip").write_bytes(b"PK\x03\x04 no")
    assert refusal("class", *options, "--port", 0, "--no-open").startswith(f"flockscope: {said}")


def test_results_stay_with_who_handed_them_in(tmp_path):
    with running(tmp_path) as ours:
        teacher = ours.teacher()
        question = {
            "title": "Order",
            "parameter": "eta",
            "measure": {"observe": "polarisation"},
            "ticks": 20,
            "values": [0.5, 1.0],
        }
        first = ours.student("Ada")
        assert teacher.do("ask", question=question).status == 200
        with first.connect() as line:
            assert line.recv(timeout=BUSY)
            handed = first.send("/class/hand-in", {})
        assert handed.status == 200, handed.text
        teacher.do("remove", students=[number_of(teacher, "Ada")])
        assert ours.student("Ada").told("/class/mine")["name"] == "Ada 2"
        assert [one[1] for one in roster(teacher)["question"]["points"]] == ["Ada"]


@pytest.mark.parametrize("path", ["/", "/index.html", "/alive", "/gallery.json", "/nothing"])
@pytest.mark.parametrize("who", ["teacher", "student", "stranger"])
def test_head_gets_the_headers_of_get_and_no_body(ours, teacher, who, path):
    student = ours.student("Hedy") if who == "student" else None
    person = {"teacher": teacher, "student": student, "stranger": ours.stranger()}[who]
    got, head = person.ask(path), person.ask(path, "HEAD")
    assert (head.status, head.text) == (got.status, "")
    for name in ("Content-Type", "Content-Length", "Content-Security-Policy", "Cache-Control"):
        assert head.headers[name] == got.headers[name], name
    assert int(head.headers["Content-Length"]) == len(got.text.encode())


def test_head_of_what_never_ends_does(ours, teacher):
    for person, path in ((teacher, "/class/roster"), (ours.student("Hedy"), "/class/mine")):
        head = person.ask(path, "HEAD")
        assert (head.status, head.headers["Content-Type"]) == (200, "text/event-stream")
        assert head.text == ""


def test_other_methods_are_told_which_are_answered(teacher):
    for method in ("PUT", "DELETE", "OPTIONS", "PATCH"):
        answer = teacher.ask("/", method)
        assert answer.status == 405
        assert set(answer.headers["Allow"].replace(",", " ").split()) == {"GET", "HEAD", "POST"}
    headers = {"Content-Type": "text/plain"}
    assert "HEAD" in teacher.ask("/", "POST", "x", headers).headers["Allow"]
