"""A class from the code on the wall to the table that is saved: one browser, five programs."""

from __future__ import annotations

from pathlib import Path

import pytest

from agents.flock import Flock
from tests.browser.accessibility import find_violations_in_both_themes
from tests.classroom.running import running
from tests.viewer.waiting import until

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
STUDENTS = 6
LARGE = "#students .fs-wall img"
"""The code, on a teacher's page while nobody is in."""


@pytest.fixture
def scenario(chromium, tmp_path, monkeypatch):
    """A class on the first lesson, and who is in it."""
    monkeypatch.syspath_prepend(str(DOCS))
    from class_scenario import Scenario

    with running(tmp_path, "--out", "kept.zip", scene="order-against-noise") as ours:
        made = Scenario(ours, chromium, lambda _page, _name: None)
        yield made
        for page in (made.teacher, *made.students):
            page.context.close()


def test_a_class_answers_a_question_from_the_code_on_the_wall_to_the_table(scenario, tmp_path):
    from class_scenario import PHONE, means

    scenario.open()
    link = scenario.read_wall()
    assert link == scenario.ours.link
    scenario.all_enter(link, [(PHONE, "light")], STUDENTS)
    scenario.teacher.locator(LARGE).wait_for(state="detached")
    page = scenario.students[0]
    with scenario.looking():
        scenario.ask()
        page.get_by_text("Yours: noise 0 rad").wait_for()
        assert find_violations_in_both_themes(scenario.teacher) == []
        scenario.hand_in()
    assert "polarisation over the last 100 ticks" in page.locator(".fs-answer").inner_text()
    assert scenario.teacher.locator(".fs-point").count() == STUDENTS
    rows = scenario.export(tmp_path)
    assert (tmp_path / "results.png").read_bytes().startswith(b"\x89PNG")
    assert [row["student"] for row in rows if row["eta [rad]"] == "0.0"] == ["Ada"]
    assert find_violations_in_both_themes(scenario.teacher) == []
    found = means(rows)
    assert len(rows) == STUDENTS
    assert found[min(found)] > 0.9
    assert found[max(found)] < 0.3
    last = rows[-1]
    (result,) = (value for name, value in last.items() if name.startswith("polarisation"))
    assert float(result) == pytest.approx(order(float(last["eta [rad]"]), int(last["seed"])))
    scenario.end(tmp_path)
    for kind in ("online", "visibilitychange"):
        page.evaluate("kind => dispatchEvent(new Event(kind))", kind)
        page.evaluate("fetch('alive').catch(() => 0)")
    assert "Connection lost" not in page.inner_text("body")
    assert "Your flock is kept with the class" in page.inner_text(".fs-lost")
    for one in (page, scenario.teacher):
        assert find_violations_in_both_themes(one) == []
    assert (tmp_path / "class.zip").read_bytes().startswith(b"PK")


def order(eta: float, seed: int) -> float:
    """The mean order of the lesson's flock over the last 100 of 500 ticks."""
    flock = Flock("vem", agents=300, world="wrap", size=9.0, seed=seed, eta=eta)
    flock.run(400)
    total = 0.0
    for _ in range(100):
        flock.run(1)
        total += flock.observe("polarisation")
    return total / 100


def test_a_picture_that_is_no_code_of_the_class_is_not_read_as_one(scenario):
    from class_scenario import read_code

    scenario.open()
    page = scenario.teacher
    until(lambda: page.locator(LARGE).bounding_box()["height"] > 0.5 * page.viewport_size["height"])
    page.keyboard.press("q")
    wall = page.locator("dialog .fs-wall img")
    wall.wait_for()
    page.wait_for_timeout(500)
    link = scenario.ours.link
    other = link[:-1] + "-"  # no link of a class ends so
    assert read_code(wall.screenshot(), [other, link]) == link
    assert read_code(wall.screenshot(), [other]) == ""
