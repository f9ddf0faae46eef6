"""How the page looks: two themes that can be read, sizes of text, and the picture alone."""

from __future__ import annotations

import pytest

from tests.browser.accessibility import find_violations, find_violations_on_tabs
from tests.browser.conftest import obeyed
from tests.browser.window import Window
from tests.viewer.waiting import until

THEMES = ("light", "dark")


def said(page, name: str) -> str:
    """What was chosen of theme, text or panels."""
    return page.locator("html").get_attribute(f"data-{name}")


@pytest.fixture
def own_window(chromium, laboratory):
    """A window whose browser asks for the dark, and remembers nothing yet."""
    page = chromium.new_page(viewport={"width": 1000, "height": 640}, color_scheme="dark")
    with obeyed(page):
        yield Window(page, laboratory)
    page.close()


def test_all_tabs_and_the_help_can_be_used_by_everybody_in_both_themes(own_window):
    page = own_window.page
    for theme in reversed(THEMES):
        assert said(page, "theme") == theme
        # a notice of a test before may still be fading
        until(lambda: find_violations_on_tabs(page) == [], 60, "no rule broken on a tab")
        page.keyboard.press("h")
        page.locator(".fs-page").first.wait_for()
        until(lambda: find_violations(page) == [], 30, "no rule broken by the help")
        page.keyboard.press("Escape")
        page.locator(".fs-page").first.wait_for(state="detached")
        page.keyboard.press("m")


def test_a_faint_word_is_noticed(window):
    page = window.page
    style = page.add_style_tag(content=".fs-card span { color: #9aa5b4 !important; }")
    assert find_violations(page)
    style.evaluate("one => one.remove()")
    page.mouse.move(0, 0)
    until(
        lambda: find_violations(page) == [],
        5,
        "all words to be read again, with nothing half faded",
    )


def test_the_theme_is_the_browsers_until_one_is_chosen_and_kept(own_window):
    page = own_window.page
    viser = page.locator("html[data-mantine-color-scheme=dark]")
    assert said(page, "theme") == "dark"
    viser.wait_for(state="attached")
    assert own_window.pixels().mean() < 90
    page.keyboard.press("m")
    viser.wait_for(state="detached")
    assert own_window.pixels().mean() > 180
    page.reload()
    page.locator(".fs-card").first.wait_for(timeout=90_000)
    assert said(page, "theme") == "light"


def test_the_picture_can_stand_alone(window):
    page = window.page
    canvas, panel = page.locator("canvas[data-engine]"), page.locator(".fs-status")
    before = canvas.bounding_box()["width"]
    for panels in ("plots", "hidden"):
        page.keyboard.press("p")
        assert said(page, "panels") == panels
        assert not panel.is_visible()
        until(lambda: canvas.bounding_box()["width"] == 1000, 60)
    until(lambda: "paused" in page.locator(".fs-caption").inner_text(), 60)
    page.keyboard.press("p")
    assert panel.is_visible()
    until(lambda: canvas.bounding_box()["width"] == before, 60)


def test_the_size_of_the_text_goes_round(window):
    page = window.page
    label = page.locator(".fs-card span").first

    def size() -> float:
        return label.evaluate("one => parseFloat(getComputedStyle(one).fontSize)")

    sizes = {}
    for _ in range(3):
        sizes[said(page, "text")] = size()
        page.keyboard.press("x")
    assert sizes["S"] < sizes["M"] < sizes["L"]
    assert said(page, "text") == "M"


SLOWEST = """() => Math.max(...[...document.querySelectorAll("*")].flatMap((one) => {
  const { transitionDuration, animationDuration } = getComputedStyle(one);
  return [transitionDuration, animationDuration].flatMap((text) => text.split(",").map(parseFloat));
}))"""
"""The longest time that anything on the page takes to slide or fade, s."""


def test_nothing_slides_or_fades_where_less_motion_is_asked_for(window):
    page = window.page
    assert page.evaluate(SLOWEST) >= 0.1, "else there is nothing to ask for less of"
    page.emulate_media(reduced_motion="reduce")
    try:
        assert page.evaluate(SLOWEST) < 0.001
        page.keyboard.press("g")
        page.locator(".fs-entry").first.wait_for()
        assert page.evaluate(SLOWEST) < 0.001
        page.keyboard.press("Escape")
        page.locator(".fs-sheet").wait_for(state="detached")
    finally:
        page.emulate_media(reduced_motion="no-preference")
