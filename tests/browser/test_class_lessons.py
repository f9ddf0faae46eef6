"""Students in a class that is led through a lesson: on their pages, and on the teacher's."""

from __future__ import annotations

import pytest

from tests.browser.conftest import POLICY
from tests.classroom.running import SCENE, has_compiled, running
from tests.classroom.test_class_lessons import QUESTION, STEPS

PHONE, DESK = (390, 844), (1440, 900)


@pytest.fixture
def ours(tmp_path):
    """A class with a lesson of three steps, whose flocks run in browsers."""
    (tmp_path / "lesson.toml").write_text(SCENE + STEPS)
    with running(tmp_path, "--flocks", "in-browser", scene="lesson.toml") as found:
        yield found


@pytest.fixture
def opens(chromium):
    """Opens a page of somebody's own; errors of all pages, and what their policies forbid."""
    contexts, errors = [], []

    def open_page(link, size=PHONE):
        contexts.append(chromium.new_context(viewport={"width": size[0], "height": size[1]}))
        page = contexts[-1].new_page()
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("console", lambda line: POLICY in line.text and errors.append(line.text))
        page.goto(link)
        return page

    yield open_page, errors
    for context in contexts:
        context.close()


def enter(open_page, link, name, size=PHONE):
    """A student who enters, and has a flock."""
    page = open_page(link, size)
    page.locator("input[name=name]").fill(name)
    page.get_by_role("button", name="Join the class").click()
    has_flock(page)
    return page


def has_flock(page) -> None:
    """Wait for the flock of a page; its runs then go as fast as a page can."""
    page.locator("#go:enabled").wait_for()
    page.wait_for_function("() => globalThis.page")
    page.evaluate("Page.prototype.speed = () => 1000")


def predict(page, choice: str) -> None:
    """Predict in the step that is shown, and run it to its end."""
    page.get_by_label(choice).check()
    page.locator("#step-run").click()
    page.locator("#step-verdict", has_text="This run shows").wait_for()


def test_what_a_step_sets_is_handed_in_and_can_be_left(ours, opens):
    open_page, errors = opens
    teacher = ours.teacher()
    has_compiled(teacher)
    teacher.do("ask", question=QUESTION)
    ada = enter(open_page, f"{ours.link}#agents=5&seed=9", "Ada")
    assert ada.evaluate("page.state.ids.length") == 30  # whatever an address says
    assert not ada.locator("#anew").is_visible()
    ada.locator("#step-next").click()
    predict(ada, "Little")
    assert not ada.get_by_text("Your flock began with step").is_visible()
    ada.locator("#step-next").click()
    predict(ada, "Less")
    assert ada.evaluate("page.state.ids.length") == 8
    ada.get_by_text("Your flock began with step 3: agents = 8, r = 2.").wait_for()
    ada.get_by_role("button", name="Hand in my run").click()
    ada.locator(".answer", has_text="other r: 2, not 1, other agents: 8, not 30").wait_for()
    ada.get_by_role("button", name="Back to the class’s flock").click()
    ada.wait_for_function("() => page.state.ids.length === 30 && page.state.tick === 0")
    assert not ada.get_by_text("Your flock began with step").is_visible()
    ada.get_by_role("button", name="Hand in again").click()
    ada.locator(".answer", has_text="eta = 0 rad").wait_for()
    assert "in no mean" not in ada.locator(".answer").inner_text()
    assert errors == []


def test_all_students_see_the_step_that_the_teacher_shows(ours, opens):
    open_page, errors = opens
    has_compiled(ours.teacher())
    desk = open_page(ours.teachers_link, DESK)
    ada, bo = (enter(open_page, ours.link, name) for name in ("Ada", "Bo"))
    assert ada.get_by_role("button", name="Next").is_visible()
    desk.get_by_role("button", name="All students see step 1 of 3").click()
    for page in (ada, bo):
        page.get_by_text("Your teacher leads: all see this step.").wait_for()
        page.get_by_text("Step 1 of 3").wait_for()
        assert not page.locator("#step-buttons").is_visible()
    desk.get_by_role("button", name="Next").click()
    ada.get_by_text("How much order?").wait_for()
    predict(ada, "Little")
    predict(bo, "Much")
    desk.get_by_text("2 of 2 predicted, 2 ran it").wait_for()
    rows = desk.locator(".fs-step tr").all_inner_texts()
    assert [row.split("\t") for row in rows[1:]] == [["Little", "1", "2"], ["Much", "1", "0"]]
    desk.get_by_role("button", name="Next").click()
    desk.get_by_role("button", name="Next").and_(desk.locator(":disabled")).wait_for()
    late = enter(open_page, ours.link, "Late")
    bo.reload()
    has_flock(bo)
    for page in (ada, bo, late):
        page.get_by_text("Less order, or more?").wait_for()
    # Who has not run the step that this one is compared with, or not on this page, runs it first.
    for page in (bo, late):
        page.get_by_label("More").check()
        page.get_by_role("button", name="Run step 2 first").click()
        page.get_by_role("button", name="Run it").wait_for()
        predict(page, "More")
    desk.get_by_text("2 of 3 predicted, 2 ran it").wait_for()
    desk.get_by_role("button", name="Students go through the steps themselves").click()
    bo.locator("#step-back").click()
    assert (
        bo.locator("#step-answers label", has_text="your prediction")
        .inner_text()
        .startswith("Much")
    )
    assert bo.locator("#step-answers input:enabled").count() == 0
    ours.teacher().do("freeze", held=True)
    bo.locator("#step-run:disabled").wait_for()
    ours.teacher().do("freeze", held=False)
    bo.locator("#step-run:enabled").wait_for()
    late.locator("#step-back").click()
    assert late.get_by_text("your prediction").count() == 0
    assert errors == []
