"""A class that is led through a lesson: what its steps set is handed in as it is."""

from __future__ import annotations

import csv
import io
import json
import re

import pytest

from agents.flock import Flock
from app.classroom.browser_flocks import moved_scene
from app.classroom.collect.hand_in import demand_answer
from app.classroom.collect.question import question_of
from app.classroom.student import Role, Student
from app.classroom.workers.page_worker import StudentPage
from app.viewer.gallery.saved_scene import SavedScene
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

STEPS = """
[[steps]]
say = "Look."
controls = ["eta"]
[[steps]]
say = "Much noise."
ask = "How much order?"
choices = ["Little", "Much"]
measure = "polarisation"
ticks = 20
bounds = [0.5]
set = { eta = 5.0 }
[[steps]]
say = "Only eight, who see far."
controls = ["eta"]
ask = "Less order, or more?"
choices = ["Less", "More"]
measure = "polarisation"
ticks = 20
bounds = [0.0]
than = 2
set = { eta = 5.0, agents = 8, r = 2.0 }
"""
QUESTION = {
    "title": "Order against noise",
    "parameter": "eta",
    "measure": {"observe": "polarisation", "over": 10},
    "ticks": 30,
    "values": [0.0, 5.0],
}


@pytest.fixture(scope="module")
def ours(tmp_path_factory):
    """A class with a lesson of three steps, for all tests of this file."""
    folder = tmp_path_factory.mktemp("class")
    (folder / "lesson.toml").write_text(SCENE + STEPS)
    with running(folder, "--flocks", "in-browser", scene="lesson.toml") as found:
        yield found


@pytest.fixture(scope="module")
def teacher(ours):
    """Its teacher, once students' page is compiled and a question is asked."""
    found = ours.teacher()
    has_compiled(found)
    assert found.do("ask", question=QUESTION).status == 200
    return found


def seed_of(person: Person) -> int:
    """The seed of a student's flock."""
    page = person.ask("/").text
    return int(json.loads(re.search(r'id="manifest">(.*?)</script>', page)[1])["seed"])


def hand_in(person: Person, step: object, **values: float):
    """Hand in a run that began with a step of the lesson."""
    return person.send("/class/hand-in", {"values": values, "step": step})


def row_of(teacher: Person, name: str) -> dict[str, str]:
    """A student's newest row in the table of results."""
    rows = list(csv.DictReader(io.StringIO(teacher.ask("/class/results.csv").text)))
    return [row for row in rows if row["student"] == name][-1]


def result_of(row: dict[str, str]) -> float:
    """What was measured of the run of a row."""
    return next(float(value) for name, value in row.items() if name.startswith("polarisation"))


def measured(agents: int, seed: int, **parameters: float) -> float:
    """What the question measures of a run."""
    flock, order = Flock("vem", agents=agents, size=5.0, seed=seed, **parameters), []
    for _ in range(30):
        flock.run(1)
        order.append(flock.observe("polarisation"))
    return sum(order[-10:]) / 10


def test_a_run_that_began_with_a_step_is_measured_with_what_the_step_sets(ours, teacher):
    ada = ours.student("Ada")
    seed = seed_of(ada)
    answer = hand_in(ada, 3, eta=2.0)
    assert answer.status == 200
    assert "other r: 2, not 1, other agents: 8, not 30): in no mean." in answer.text
    row = row_of(teacher, "Ada")
    assert row["differs"] == "other r: 2, not 1; other agents: 8, not 30"
    assert result_of(row) == pytest.approx(measured(8, seed, eta=2.0, r=2.0), rel=1e-12)
    # The next run began without a step: nothing of the step is left in it.
    assert hand_in(ada, 0, eta=2.0).status == 200
    row = row_of(teacher, "Ada")
    assert row["differs"] == ""
    assert result_of(row) == pytest.approx(measured(30, seed, eta=2.0), rel=1e-12)


@pytest.mark.parametrize(
    ("step", "said"),
    [
        (4, "step = 4 is not allowed: 1 to 3"),
        (13, "step = 13 is not allowed: a number from 0 to 12"),
        (-1, "step = -1 is not allowed"),
        (True, "step = True is not allowed"),
        (2.0, "step = 2.0 is not allowed"),
        ("2", "step = '2' is not allowed"),
        (None, "step = None is not allowed"),
    ],
)
def test_a_step_that_the_lesson_has_not_is_refused_in_a_line(ours, teacher, step, said):
    mal = ours.student("Mal")
    before = len(roster(teacher)["question"]["points"])
    answer = hand_in(mal, step, eta=1.0)
    assert (answer.status, answer.text.count("\n")) == (400, 1)
    assert answer.text.startswith(said)
    assert len(roster(teacher)["question"]["points"]) == before


def test_a_step_of_more_agents_than_a_class_measures_is_refused_in_a_line():
    text = (SCENE + STEPS).replace("agents = 8", "agents = 6000")
    scene = SavedScene.from_toml(text, "lesson.toml")
    student = Student(1, "Ada", "", Role.OWN, scene.to_toml())
    page = StudentPage(b"", "", "", ("eta",), scene.steps)
    ran = moved_scene(student, page, {"eta": 1.0}, page.step_at(3))
    run = SavedScene.from_toml(ran, "the run of Ada").spec
    with pytest.raises(InputError, match="6,000 agents are too many to hand in: at most 5,000"):
        demand_answer(question_of(QUESTION, scene.spec), run)


def predict(person: Person, step: object, choice: object, **more: object):
    """Predict in a step of the lesson."""
    return person.send("/class/predict", {"step": step, "choice": choice, **more})


def lesson(person: Person) -> dict:
    """What a student's page is told of the lesson."""
    return person.told("/class/mine")["lesson"]


def more(before: list[int], after: list[int]) -> list[int]:
    """How many more there are of each."""
    return [now - then for now, then in zip(after, before, strict=True)]


@pytest.fixture
def led(teacher):
    """The teacher, who leads for one test."""
    yield teacher
    assert teacher.do("step", step=0).status == 200


def test_all_see_the_step_that_the_teacher_shows_and_who_comes_late_too(ours, led):
    bo = ours.student("Bo")
    bo.ask("/")
    assert lesson(bo) == {"step": 0, "predictions": []}
    assert led.do("step", step=3).text == "all students see step 3"
    assert lesson(bo)["step"] == 3
    late = ours.student("Late")
    late.ask("/")
    assert lesson(late)["step"] == 3
    assert roster(led)["lesson"]["step"] == 3
    assert led.do("step", step=0).text == "students go through the steps"
    assert lesson(bo)["step"] == 0


@pytest.mark.parametrize("step", [4, 13, -1, True, 1.0, "1", None, [1]])
def test_a_step_that_is_none_is_not_shown(led, step):
    assert led.do("step", step=2).status == 200
    answer = led.do("step", step=step)
    assert (answer.status, answer.text.count("\n")) == (400, 1)
    assert answer.text.startswith(f"step = {step!r} is not allowed")
    assert roster(led)["lesson"]["step"] == 2


def test_only_the_teacher_shows_a_step(ours, led):
    eve = ours.student("Eve")
    answer = eve.send("/class/do", {"do": "step", "step": 2})
    assert (answer.status, answer.text) == (403, "only the teacher may do that\n")
    assert ours.stranger().send("/class/do", {"do": "step", "step": 2}).status == 403
    assert roster(led)["lesson"]["step"] == 0


def test_predictions_are_counted_kept_and_in_the_tables(ours, teacher):
    cy, di = ours.student("Cy"), ours.student("Di")
    before = roster(teacher)["lesson"]["steps"][1]
    assert (before["ask"], before["choices"]) == ("How much order?", ["Little", "Much"])
    assert predict(cy, 2, 1).status == 200
    assert predict(cy, 2, 1, shown=0).status == 200
    assert predict(cy, 2, 1).status == 200  # the run again: what it showed before stays
    assert predict(di, 2, 0).status == 200
    after = roster(teacher)["lesson"]["steps"][1]
    assert more(before["predicted"], after["predicted"]) == [1, 1]
    assert more(before["shown"], after["shown"]) == [1, 0]
    assert lesson(cy)["predictions"] == [[2, 1, 0]]
    assert hand_in(cy, 0, eta=1.0).status == 200
    row = row_of(teacher, "Cy")
    assert (row["step 2 predicted"], row["step 2 shown"], row["step 3 predicted"]) == (
        "Much",
        "Little",
        "",
    )
    table = teacher.ask("/class/predictions.csv").text.splitlines()
    assert table[0] == "student,step,predicted,shown"
    assert {"Cy,2,Much,Little", "Di,2,Little,"} <= set(table)
    assert cy.ask("/class/predictions.csv").status == 403


def test_a_prediction_that_is_made_stays(ours, teacher):
    flo = ours.student("Flo")
    assert predict(flo, 2, 0, shown=0).status == 200
    answer = predict(flo, 2, 1)
    assert (answer.status, answer.text) == (400, "your prediction of step 2 is made: it stays\n")
    assert lesson(flo)["predictions"] == [[2, 0, 0]]
    assert teacher.do("remove", students=[number_of(teacher, "Flo")]).status == 200
    assert "Flo" not in teacher.ask("/class/predictions.csv").text


@pytest.mark.usefixtures("teacher")
@pytest.mark.parametrize(
    ("step", "choice", "more", "said"),
    [
        (1, 0, {}, "step = 1 is not allowed: nothing is predicted in it"),
        (0, 0, {}, "step = 0 is not allowed: 1 to 3"),
        (4, 0, {}, "step = 4 is not allowed: 1 to 3"),
        (2, 2, {}, "choice = 2 is not allowed: 0 to 1 (step 2)"),
        (2, 0, {"shown": 3}, "shown = 3 is not allowed: 0 to 1 (step 2)"),
        (2, 4, {}, "choice = 4 is not allowed: a number from 0 to 3"),
        (2, -1, {}, "choice = -1 is not allowed"),
        (2, True, {}, "choice = True is not allowed"),
        (2, 0.0, {}, "choice = 0.0 is not allowed"),
        (2, "Much", {}, "choice = 'Much' is not allowed"),
        (2, None, {}, "choice is missing: what is predicted?"),
        (2, 0, {"shown": [0]}, "shown = [0] is not allowed"),
    ],
)
def test_a_forged_prediction_is_refused_in_a_line(ours, step, choice, more, said):
    mal = ours.student("Mal")
    mal.ask("/")
    answer = predict(mal, step, choice, **more)
    assert (answer.status, answer.text.count("\n")) == (400, 1)
    assert answer.text.startswith(said)
    assert lesson(mal)["predictions"] == []


def test_who_may_predict(ours, led):
    gil = ours.student("Gil")
    number = number_of(led, "Gil")
    led.do("freeze", held=True, students=[number])
    assert predict(gil, 2, 0).text.startswith("your flock is held by the teacher")
    led.do("freeze", held=False, students=[number])
    led.do("role", role="watching", students=[number])
    assert predict(gil, 2, 0).text == "only who has a flock of their own predicts\n"
    led.do("role", role="own", students=[number])
    led.do("step", step=2)
    assert predict(gil, 3, 0).text == "step = 3 is not allowed: the class is at step 2\n"
    assert predict(gil, 2, 0).status == 200
    assert predict(ours.stranger(), 2, 0).status in (403, 429)


def test_who_predicts_too_often_waits(ours, teacher):
    ned = ours.student("Ned")
    assert 429 in [predict(ned, 2, 0).status for _ in range(60)]
    assert roster(teacher)["lesson"]["steps"][1]["predicted"][0] >= 1


def test_a_class_that_is_opened_again_goes_on_at_its_step(tmp_path):
    (tmp_path / "lesson.toml").write_text(SCENE + STEPS)
    options = "--flocks", "in-browser", "--out", "kept.zip"
    with running(tmp_path, *options, scene="lesson.toml") as first:
        has_compiled(first.teacher())
        ida = first.student("Ida")
        assert predict(ida, 2, 1, shown=0).status == 200
        assert first.teacher().do("step", step=3).status == 200
        first.stop()
    with running(tmp_path, *options[:2], scene="kept.zip") as second:
        teacher = second.teacher()
        has_compiled(teacher)
        ida.cookies = {
            name.replace(str(first.port), str(second.port)): value
            for name, value in ida.cookies.items()
        }
        ida.port = second.port
        ida.ask("/")
        assert lesson(ida) == {"step": 3, "predictions": [[2, 1, 0]]}
        until(lambda: teacher.do("start").status == 200, BUSY)
        ida.ask("/")  # the teacher's flock has the same steps: the lesson goes on
        assert lesson(ida) == {"step": 3, "predictions": [[2, 1, 0]]}
