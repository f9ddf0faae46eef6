"""A student on a phone whose flock runs in the page: from the code to the class's results."""

from __future__ import annotations

import pytest

from tests.browser.accessibility import find_violations, find_violations_in_both_themes
from tests.browser.conftest import POLICY
from tests.classroom.running import BUSY, roster, running
from tests.viewer.waiting import until

PHONE, ACROSS, DESK = (390, 844), (844, 390), (1440, 900)
QUESTION = {
    "title": "Order against noise",
    "parameter": "eta",
    "measure": {"observe": "polarisation", "over": 10},
    "ticks": 50,
    "values": [0.0, 3.0],
}
WIDER = "document.documentElement.scrollWidth > innerWidth"


@pytest.fixture(scope="module")
def ours(tmp_path_factory):
    """A class whose flocks run in browsers."""
    with running(tmp_path_factory.mktemp("class"), "--flocks", "in-browser") as found:
        yield found


@pytest.fixture(scope="module")
def teacher(ours):
    """Its teacher."""
    return ours.teacher()


@pytest.fixture
def enters(ours, chromium):
    """Has somebody enter by the code; errors of their page, and what its policy forbids."""
    pages, errors = [], []

    def enter(name, size=PHONE):
        page = chromium.new_page(viewport={"width": size[0], "height": size[1]}, has_touch=True)
        pages.append(page)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("console", lambda line: POLICY in line.text and errors.append(line.text))
        page.goto(ours.link)
        page.locator("input[name=name]").fill(name)
        page.get_by_role("button", name="Join the class").click()
        return page

    yield enter, errors
    for page in pages:
        page.close()


def ticks(page, more: int) -> None:
    """Wait until the flock of a page has run so many ticks more."""
    now = page.evaluate("globalThis.page ? page.state.tick : 0")
    page.wait_for_function(f"() => globalThis.page && page.state.tick >= {now + more}")


def test_a_student_waits_for_the_page_moves_a_slider_and_sees_the_class(ours, teacher, enters):
    enter, errors = enters
    ada = enter("Ada")
    ada.locator("#go").wait_for()  # the page that waits goes over to that of the flock by itself
    ticks(ada, 5)
    assert ada.locator("#sliders .slider").count() == 1
    assert ada.locator("#go").inner_text() == "Pause"
    assert not ada.evaluate(WIDER)
    assert teacher.do("ask", question=QUESTION).status == 200
    hand = ada.get_by_role("button", name="Hand in my run")
    hand.wait_for()
    ada.get_by_text("Yours: noise 0 rad. Watch polarisation over the last 10 ticks.").wait_for()
    ticks(ada, 12)
    assert float(ada.locator(".live output").inner_text()) <= 1.0
    slider = ada.locator("#sliders input")
    slider.focus()
    slider.press("End")
    ada.wait_for_function("() => page.values.eta > 6")
    hand.click()
    ada.locator(".answer", has_text="Ada, eta = 6.25 rad").wait_for()
    ada.locator(".plot .fs-own").wait_for()
    bo = ours.student("Bo")
    assert bo.send("/class/hand-in", {"values": {"eta": 1.5}}).status == 200
    ada.locator(".plot circle").nth(1).wait_for()
    ada.get_by_text("2 results of 2 students").wait_for()
    assert ada.locator(".plot .fs-own").count() == 1
    assert errors == []


def test_the_teacher_holds_a_flock_and_lets_it_go_on(teacher, enters):
    enter, errors = enters
    cy = enter("Cy")
    cy.locator("#go:enabled").wait_for()
    ticks(cy, 3)
    teacher.do("freeze", held=True)
    cy.get_by_text("held by the teacher").wait_for()
    assert cy.locator("#go").is_disabled()
    assert cy.locator("#sliders input").is_disabled()
    before = cy.evaluate("page.values.eta")
    for key in (" ", "s", "r"):
        cy.keyboard.press(key)
    assert cy.evaluate("[page.going, page.values.eta]") == [False, before]
    teacher.do("say", word="Look up")
    cy.get_by_text("Look up").wait_for()
    teacher.do("say", word="")
    teacher.do("freeze", held=False)
    cy.locator("#go:enabled").click()
    ticks(cy, 3)
    assert errors == []


def test_all_look_at_the_teachers_flock_and_go_back_to_their_own(teacher, enters):
    enter, _ = enters
    di = enter("Di")
    di.locator("#go").wait_for()
    teacher.do("role", role="watching")
    di.get_by_text("watching the teacher’s flock").wait_for()
    teacher.do("role", role="own")
    di.locator("#go:enabled").wait_for()
    ticks(di, 3)


def test_who_is_taken_out_of_a_class_is_told(teacher, enters):
    enter, _ = enters
    ed = enter("Ed")
    ed.locator("#go:enabled").wait_for()
    number = next(one["number"] for one in roster(teacher)["students"] if one["name"] == "Ed")
    assert teacher.do("remove", students=[number]).status == 200
    ed.get_by_text("you are no longer in this class").wait_for()
    assert ed.locator("#go").is_disabled()


def test_the_page_before_the_class_can_be_used_by_everybody(ours, chromium):
    page = chromium.new_page(viewport={"width": PHONE[0], "height": PHONE[1]})
    page.goto(ours.link)
    assert find_violations_in_both_themes(page) == []
    page.close()


@pytest.mark.parametrize("size", [PHONE, ACROSS, DESK])
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_page_fits_and_can_be_read(teacher, enters, size, theme):
    enter, _ = enters
    page = enter(f"{theme} {size[0]}", size)
    page.emulate_media(color_scheme=theme)
    page.locator("#go:enabled").wait_for()
    until(lambda: roster(teacher)["students"], BUSY)
    assert not page.evaluate(WIDER)
    assert find_violations(page) == []
