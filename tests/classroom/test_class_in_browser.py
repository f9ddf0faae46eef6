"""A class whose flocks run in students' browsers, and students who send what no page would."""

from __future__ import annotations

import asyncio
import csv
import io
import json
import re
from dataclasses import replace

import pytest
from cli.calling import refusal
from websockets.exceptions import InvalidStatus

from agents import Flock
from agents.individuals import normal
from agents.kinds import Kind
from app.classroom.browser_flocks import MOST_WATCHING, BrowserFlocks
from app.classroom.classroom import Classroom
from app.classroom.flocks import Flocks
from app.classroom.student import Role
from app.classroom.workers.page_worker import first_question, named_sliders
from app.cli.classroom import FlockPlace, runs_in_browser
from app.studies.run_axes import number_parameters
from app.viewer.gallery.lessons.lessons import lesson_names
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.gallery.scene_collection import find_lesson
from app.viewer.run.run_preset import preset_spec
from tests.classroom.running import (
    BUSY,
    SCENE,
    Person,
    has_compiled,
    number_of,
    roster,
    running,
)
from tests.viewer.waiting import until
from worlds.input_error import InputError

QUESTION = {
    "title": "Order against noise",
    "parameter": "eta",
    "measure": {"observe": "polarisation", "over": 10},
    "ticks": 50,
    "values": [0.0, 6.0],
}
OPEN = {"X-Flockscope": "scene", "Sec-Fetch-Site": "same-origin"}


@pytest.fixture(scope="module")
def ours(tmp_path_factory):
    """A class that runs, for all tests of this file."""
    folder = tmp_path_factory.mktemp("class")
    with running(folder, "--flocks", "in-browser", "--out", "kept.zip") as found:
        yield found


@pytest.fixture(scope="module")
def teacher(ours):
    """Its teacher, once students' page is compiled."""
    found = ours.teacher()
    has_compiled(found)
    return found


@pytest.fixture(scope="module")
def asked(teacher):
    """The class is asked a question."""
    assert teacher.do("ask", question=QUESTION).status == 200
    return teacher


def manifest(person: Person) -> dict:
    """What a student's page is told of its flock."""
    page = person.ask("/")
    assert page.status == 200
    return json.loads(re.search(r'id="manifest">(.*?)</script>', page.text)[1])


def told(person: Person) -> dict:
    """What a student's page is told of the class before anything."""
    return json.loads(re.search(r'id="class">(.*?)</script>', person.ask("/").text)[1])


def hand_in(person: Person, **values):
    """Hand in a run with these sliders."""
    return person.send("/class/hand-in", {"values": values})


def points(teacher: Person) -> list:
    """The results so far."""
    return roster(teacher)["question"]["points"]


@pytest.mark.usefixtures("teacher")
def test_a_student_has_a_page_with_the_flock_in_it_and_one_slider(ours):
    ada = ours.student("Ada")
    assert ada.told("/class/mine")["page"] == "flock"
    page = ada.ask("/")
    policy = page.headers["Content-Security-Policy"]
    assert "unsafe-inline" not in policy
    assert "connect-src 'self';" in policy
    assert "frame-ancestors 'none'" in policy
    assert told(ada)["sliders"] == ["eta"]
    assert told(ada)["flock"] == ada.told("/class/mine")["flock"]
    module = re.search(r'data-file="(flock/[0-9a-f]{32}\.wasm)"', page.text)[1]
    code = ada.ask(f"/{module}")
    assert (code.status, code.headers["Content-Type"]) == (200, "application/wasm")
    assert code.text.startswith("\0asm")
    assert "immutable" in code.headers["Cache-Control"]


@pytest.mark.usefixtures("teacher")
def test_students_have_seeds_of_their_own_and_one_module(ours):
    both = ours.student("Bo"), ours.student("Bea")
    seeds = [manifest(one)["seed"] for one in both]
    assert seeds[0] != seeds[1]
    modules = {re.search(r"flock/[0-9a-f]+\.wasm", one.ask("/").text)[0] for one in both}
    assert len(modules) == 1


def test_no_laboratory_is_opened_for_a_student(ours, teacher):
    cy = ours.student("Cy")
    assert cy.ask("/").status == 200
    assert cy.ask("/scene.json", headers={"Sec-Fetch-Site": "same-origin"}).status == 404
    with pytest.raises(InvalidStatus) as refused:
        cy.connect()
    assert refused.value.response.status_code == 404
    visit = teacher.ask(f"/at/{number_of(teacher, 'Cy')}/")
    assert (visit.status, visit.text.strip()) == (
        400,
        "this flock runs in its student's browser: press a result to open what was handed in",
    )
    assert next(one for one in roster(teacher)["students"] if one["name"] == "Cy")["seen"] is None


def test_who_listens_is_here_and_who_goes_is_not(ours, teacher):
    di = ours.student("Di")

    def is_here() -> bool:
        return next(one["here"] for one in roster(teacher)["students"] if one["name"] == "Di")

    assert not is_here()
    assert di.ask("/class/mine", "HEAD").status == 200
    assert not is_here()
    with di.listening("/class/mine"):
        assert until(is_here, BUSY)
    assert until(lambda: not is_here(), BUSY)


def test_a_run_that_is_handed_in_is_made_anew_with_its_sliders(ours, asked):
    ed = ours.student("Ed")
    mine = ed.told("/class/mine")["question"]
    assert mine["value"] in ("0 rad", "6 rad")
    seed = int(manifest(ed)["seed"])
    assert hand_in(ed, eta=1.25).text.startswith(f"Ed, eta = 1.25 rad, seed {seed}: polarisation")
    rows = csv.DictReader(io.StringIO(asked.ask("/class/results.csv").text))
    row = next(one for one in rows if one["student"] == "Ed")
    again, order = Flock("vem", agents=30, size=5.0, seed=seed, eta=1.25), []
    for _ in range(50):
        again.run(1)
        order.append(again.observe("polarisation"))
    found = next(value for name, value in row.items() if name.startswith("polarisation"))
    assert float(found) == pytest.approx(sum(order[-10:]) / 10, rel=1e-12)
    assert row["differs"] == ""


@pytest.mark.usefixtures("asked")
def test_the_class_plot_names_nobody(ours):
    fay = ours.student("Fay")
    assert hand_in(fay, eta=0.5).status == 200
    plot = json.loads(fay.ask("/class/plot.json").text)
    (mine,) = fay.told("/class/mine")["plot"]["mine"]
    assert plot["points"][mine][1:3] == ["", 0.5]
    assert "Fay" not in json.dumps(plot)
    assert {one[1] for one in plot["points"]} == {""}
    assert ours.stranger().ask("/class/plot.json").status == 403


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"eta": 99.0}, "eta = 99 is not in [0, 6.28"),
        ({"eta": -1e-9}, "eta = -1e-09 is not in"),
        ({"v0": 1.0}, "unknown slider 'v0'"),
        ({"seed": 5}, "unknown slider 'seed'"),
        ({"agents": 2000}, "unknown slider 'agents'"),
        ({"eta": "1"}, "'eta' = '1' is not a finite number"),
        ({"eta": True}, "'eta' = True is not a finite number"),
        ({"eta": None}, "'eta' = None is not a finite number"),
        ({"eta": [1.0]}, "'eta' = [1.0] is not a finite number"),
        ({"eta": float("nan")}, "'eta' = nan is not a finite number"),
        ({"eta": float("-inf")}, "'eta' = -inf is not a finite number"),
        ({"eta": 10**400}, "'eta' = "),
        ([1.0], "values is to be a table of at most 8 numbers"),
        ("eta", "values is to be a table of at most 8 numbers"),
        ({f"p{k}": 1.0 for k in range(9)}, "values is to be a table of at most 8 numbers"),
    ],
)
def test_a_forged_hand_in_is_refused_in_a_line_and_is_no_result(ours, asked, values, said):
    mal = ours.student("Mal")
    before = len(points(asked))
    answer = mal.send("/class/hand-in", {"values": values})
    assert answer.status == 400
    assert answer.text.startswith(said)
    assert answer.text.count("\n") == 1
    assert len(points(asked)) == before


@pytest.mark.usefixtures("asked")
def test_who_hands_in_too_often_waits_and_the_others_do_not(ours):
    flo, gil = ours.student("Flo"), ours.student("Gil")
    answers = [hand_in(flo, eta=99.0).status for _ in range(12)]
    assert 429 in answers
    assert hand_in(gil, eta=1.0).status == 200


@pytest.mark.usefixtures("asked")
def test_a_key_that_is_nobodys_gets_nothing(ours):
    hal = ours.student("Hal")
    (name,) = hal.cookies
    forged = Person(ours.port, {name: "x" * 32})
    for path in ("/", "/class/mine", "/class/plot.json", "/flock/0.wasm"):
        assert forged.ask(path).status in (403, 429)
    assert hand_in(forged, eta=1.0).status in (403, 429)
    for path in ("/class", "/class/roster", "/class/results.csv"):
        assert hal.ask(path).status == 403


def test_a_flock_that_is_held_hands_nothing_in(ours, asked):
    ivy = ours.student("Ivy")
    number = number_of(asked, "Ivy")
    asked.do("freeze", held=True, students=[number])
    assert ivy.told("/class/mine")["frozen"]
    answer = hand_in(ivy, eta=1.0)
    assert (answer.status, answer.text) == (
        400,
        "your flock is held by the teacher: hand in once it goes on\n",
    )
    asked.do("freeze", held=False, students=[number])
    assert hand_in(ivy, eta=1.0).status == 200


def test_who_is_to_look_at_the_teachers_flock_gets_the_page_of_that(ours, asked):
    jo = ours.student("Jo")
    number = number_of(asked, "Jo")
    asked.do("role", role="watching", students=[number])
    assert jo.told("/class/mine")["page"] == "watching"
    with jo.connect() as line:
        assert line.recv(timeout=BUSY)
    assert hand_in(jo, eta=1.0).text == "only who has a flock of their own hands in a result\n"
    asked.do("role", role="own", students=[number])
    assert jo.told("/class/mine")["page"] == "flock"
    assert told(jo)["sliders"] == ["eta"]


def teacher_opens(teacher: Person, scene: SavedScene) -> None:
    """The teacher's own flock runs a scene."""
    from app.viewer.gallery.saved_scene import pack_scene

    path = f"/open?scene={pack_scene(scene)}&sure=1"
    opened = teacher.ask(path, headers=OPEN)
    assert opened.status == 200, opened.text

    def runs() -> bool:
        mine = roster(teacher)["mine"]
        return mine is not None and mine["agents"] == scene.spec.agents

    until(runs, BUSY)


def test_all_begin_with_what_the_teacher_runs(ours, teacher):
    kim, lee = ours.student("Kim"), ours.student("Lee")
    before = kim.told("/class/mine")["flock"], lee.told("/class/mine")["flock"]
    assert manifest(kim)["agents"] == 30
    teacher_opens(teacher, SavedScene("Fifty", preset_spec("vem", agents=50)))
    answer = teacher.do("start", students=[number_of(teacher, "Kim")])
    assert answer.text == "begun with “Fifty”"
    assert kim.told("/class/mine")["flock"] != before[0]
    assert lee.told("/class/mine")["flock"] == before[1]
    assert (manifest(kim)["agents"], manifest(lee)["agents"]) == (50, 30)


def test_what_no_browser_can_run_is_refused_and_all_go_on(ours, teacher):
    moe = ours.student("Moe")
    before = moe.told("/class/mine")["flock"]
    spec = preset_spec("vem", agents=40)
    beside = spec.but(model="couzin", parameters={})
    teacher_opens(teacher, SavedScene("Two", spec, beside=beside))
    answer = teacher.do("start", students=[number_of(teacher, "Moe")])
    assert answer.status == 400
    assert answer.text.startswith("two flocks beside each other cannot run")
    assert moe.told("/class/mine")["flock"] == before
    assert moe.ask("/").status == 200


def test_a_class_that_is_stopped_goes_on_with_the_flocks_of_its_students(tmp_path):
    options = "--flocks", "in-browser"
    with running(tmp_path, *options, "--out", "kept.zip") as first:
        teacher = first.teacher()
        has_compiled(teacher)
        teacher.do("ask", question=QUESTION)
        ned = first.student("Ned")
        before, seed = told(ned)["flock"], manifest(ned)["seed"]
        assert hand_in(ned, eta=2.5).status == 200
        port = first.port
        first.stop()
    with running(tmp_path, *options, scene="kept.zip") as second:
        ned.cookies = {
            name.replace(str(port), str(second.port)): value for name, value in ned.cookies.items()
        }
        ned.port = second.port
        teacher = second.teacher()
        has_compiled(teacher)
        assert ned.told("/class/mine")["flock"] != before
        page = manifest(ned)
        assert page["seed"] == seed
        eta = next(one for one in page["parameters"] if one["name"] == "eta")
        assert eta["value"] == 2.5
        assert json.loads(ned.ask("/class/plot.json").text)["points"][0][2] == 2.5


def test_where_flocks_run_follows_from_the_scene(capsys):
    plain = SavedScene("Plain", preset_spec("vem", agents=30))
    two = replace(plain, beside=preset_spec("hwvem", agents=30))
    assert runs_in_browser(plain, 500, None)
    assert not runs_in_browser(plain, 200, FlockPlace.ON_SERVER)
    assert capsys.readouterr().err == ""
    assert not runs_in_browser(two, 40, None)
    said = capsys.readouterr().err
    assert said.startswith("students' flocks run on the server: two flocks beside each other")
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--flocks", "in-browser"], "two flocks beside each other cannot run"),
        (["--students", "300"], "300 students are too many for flocks on the server: at most 200"),
    ],
)
def test_what_no_browser_can_run_is_one_line_at_the_start(tmp_path, monkeypatch, options, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "two.toml").write_text(f'{SCENE}[beside]\nmodel = "hwvem"\n')
    assert said in refusal("class", "two.toml", *options, "--port", 0, "--no-open")


@pytest.mark.parametrize(
    ("lesson", "sliders"),
    [
        ("order-against-noise", ("eta",)),
        ("who-leads", ("p2",)),
        ("field-of-view", ("alpha",)),
        ("beat-the-paper", ("p2", "p1")),
    ],
)
def test_a_lesson_names_one_or_two_sliders(lesson, sliders):
    scene = find_lesson(lesson)
    known = [one.name for one in number_parameters(scene.spec.model)]
    assert named_sliders(first_question(scene), known) == sliders


OF_OWN_NUMBERS = {"leaders-who-disagree", "fast-and-slow", "predators-and-prey", "shepherd"}
"""Lessons with the slider of a number that each agent has its own of."""


@pytest.mark.parametrize("name", lesson_names())
def test_a_lesson_runs_in_browsers_unless_its_slider_is_of_own_numbers(name, capsys):
    assert runs_in_browser(find_lesson(name), 40, None) == (name not in OF_OWN_NUMBERS)
    said = capsys.readouterr().err
    assert said.count("\n") == (name in OF_OWN_NUMBERS)
    assert ("which each agent has its own of" in said) == (name in OF_OWN_NUMBERS)


@pytest.fixture
def empty_class(monkeypatch, tmp_path):
    """A class whose processes are never begun, and what is compiled for it."""
    compiled: list[str] = []

    async def compile_scene(_pages, scene):
        compiled.append(scene.title)
        if scene.title == "Impossible":
            raise InputError("a browser has no function that gives the same")

    monkeypatch.setattr(BrowserFlocks, "compile", compile_scene)
    monkeypatch.setattr(
        Flocks, "begin_workers", lambda flocks, count: setattr(flocks, "count", count)
    )

    def make(title):
        scene = SavedScene(title, preset_spec("vem", agents=30))
        return Classroom(scene, 500, 3, tmp_path, in_browser=True), compiled

    return make


def test_flocks_run_on_the_server_where_the_page_cannot_be_compiled(empty_class):
    async def try_it():
        room, _ = empty_class("Impossible")
        ada, _ = room.admit(room.code, "Ada")
        assert room.is_in_browser(ada)
        await room.compile(room.pages)
        assert room.flocks_note == (
            "students' flocks run on the server: a browser has no function that gives the same"
        )
        assert (room.is_in_browser(ada), room.flocks.count) == (False, 3)
        await room.close()

    asyncio.run(try_it())


def test_at_most_two_hundred_look_at_the_teachers_flock(empty_class):
    async def try_it():
        room, _ = empty_class("Plain")
        for number in range(MOST_WATCHING + 1):
            room.admit(room.code, f"Student {number}")
        with pytest.raises(InputError, match=r"at most 200 students .*: these would be 201"):
            room.give_role(Role.WATCHING)
        assert all(one.role is Role.OWN for one in room.students.values())
        room.give_role(Role.WATCHING, range(1, MOST_WATCHING + 1))
        with pytest.raises(InputError, match="these would be 201"):
            room.give_role(Role.WATCHING, [MOST_WATCHING + 1])
        await room.close()

    asyncio.run(try_it())


def test_agents_that_differ_run_in_browsers_too():
    for words in ({"parameters": {"eta": normal(0.5, 0.1)}}, {"kinds": [Kind("shark", 1)]}):
        assert runs_in_browser(SavedScene("s", preset_spec("vem", agents=9, **words)), 300, None)
