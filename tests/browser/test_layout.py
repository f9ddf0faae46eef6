"""How the page is laid out by the size of its window: picture first, one drawer, Go in reach."""

from __future__ import annotations

import pytest

from app.viewer.run.run_preset import preset_spec
from tests.browser.accessibility import find_violations
from tests.browser.conftest import START, obeyed
from tests.viewer.waiting import COMPILED, until

SIZES = {
    (320, 256): ("flat", 0.55),
    (320, 568): ("tall", 0.7),
    (390, 844): ("tall", 0.8),
    (720, 450): ("flat", 0.8),
    (844, 390): ("flat", 0.8),
    (1024, 640): ("wide", 0.49),
    (1440, 860): ("wide", 0.5),
    (1920, 900): ("wide", 0.6),
}
"""Of windows, how they are laid out, and the least share that is picture with no drawer open."""
GO = "button:has(svg[class*=tabler-player-p])"
LAID_OUT = """() => {
  const root = document.documentElement, boxOf = (one) => one.getBoundingClientRect();
  const all = (selector) => [...document.querySelectorAll(selector)];
  const picture = boxOf(document.querySelector("canvas[data-engine]"));
  const go = document.querySelector("button[data-block]:has(svg[class*=tabler-player-p])");
  const { x, y, width, height } = boxOf(go);
  const sheet = all('.mantine-Paper-root[style*="20em"] .mantine-ScrollArea-viewport');
  return {
    layout: root.dataset.layout,
    share: picture.width * picture.height / (innerWidth * innerHeight),
    go: go.contains(document.elementFromPoint(x + width / 2, y + height / 2)) && height >= 44,
    sideways: [root, ...sheet].some((one) => one.scrollWidth > one.clientWidth + 1),
    drawers: all(".fs-strip [aria-expanded=true]").map((one) => one.textContent),
    cut: all(".fs-tools button, .fs-open button, .fs-strip button").some(
      (one) => boxOf(one).left < 0 || boxOf(one).right > innerWidth),
    views: picture.bottom - Math.min(...all(".fs-views button").map((one) => boxOf(one).top)),
    over: all(".fs-tools button").some((one, k, buttons) => buttons.slice(k + 1).some((other) =>
      boxOf(one).left < boxOf(other).right && boxOf(other).left < boxOf(one).right &&
      boxOf(one).top < boxOf(other).bottom && boxOf(other).top < boxOf(one).bottom)),
  };
}"""


@pytest.fixture(scope="module")
def one_page(chromium, served):
    """One page for all that follows, which is resized."""
    page = chromium.new_page(viewport={"width": 390, "height": 844})
    with obeyed(page):
        page.goto(served.address)
        page.locator(".fs-strip button").first.wait_for()
        yield page
    page.close()


@pytest.fixture
def page(one_page, laboratory):
    """A window as large as a phone's, whose drawers are closed."""
    assert not laboratory.simulation.state.running
    one_page.set_viewport_size({"width": 390, "height": 844})
    one_page.locator("html[data-layout=tall]").wait_for()
    for button in one_page.locator(".fs-strip [aria-expanded=true]").all():
        button.click()
    return one_page


def open_drawer(page, name: str) -> None:
    """Open a drawer, or close it."""
    page.locator(".fs-strip").get_by_role("button", name=name, exact=True).click()


def test_every_window_shows_the_picture_first_with_go_in_reach(page):
    for text in "MLS":
        until(lambda text=text: page.locator(f"html[data-text={text}]").count() == 1)
        for size, (layout, least) in SIZES.items():
            page.set_viewport_size({"width": size[0], "height": size[1]})
            is_large = text == "L"  # large text needs wide panels
            least = min(least, 0.3) if is_large and layout == "wide" else least

            def is_laid_out(layout=layout, least=least, is_large=is_large) -> bool:
                now = page.evaluate(LAID_OUT)
                return (
                    now["layout"] == layout
                    and now["share"] >= least
                    and now["go"]
                    and not now["sideways"]
                    and not now["cut"]
                    and not now["over"]
                    and (layout != "wide" or is_large or now["views"] < 45)  # below the world
                    and not now["drawers"]
                )

            until(is_laid_out, 30, f"{size} with text {text}: {page.evaluate(LAID_OUT)}")
        page.keyboard.press("x")


@pytest.mark.parametrize("size", [(320, 568), (720, 450)])
def test_one_drawer_is_open_at_a_time(page, laboratory, size):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    slider, card = page.get_by_text("Noise η, rad"), page.locator(".fs-card").first
    for name, shown, hidden in (("Rule", slider, card), ("Monitors", card, slider)):
        open_drawer(page, name)
        shown.wait_for()
        until(lambda hidden=hidden: not hidden.is_visible())
        now = page.evaluate(LAID_OUT)
        assert now["drawers"] == [name]
        assert now["go"]
        assert not now["sideways"]
        assert now["share"] > 0.25
        page.locator(GO).first.click()
        until(lambda: laboratory.simulation.state.running)
        page.locator(GO).first.click()
        until(lambda: not laboratory.simulation.state.running)
    assert page.locator(".fs-caption").is_visible()
    page.keyboard.press("Escape")
    until(lambda: page.evaluate(LAID_OUT)["drawers"] == [])
    assert not card.is_visible()


def test_the_card_of_an_agent_is_a_drawer_among_the_others(page, laboratory):
    open_drawer(page, "Rule")
    page.get_by_text("Noise η, rad").wait_for()
    laboratory.select(5)
    page.get_by_text("Listens to").wait_for()
    until(lambda: page.evaluate(LAID_OUT)["drawers"] == [])
    assert not page.get_by_text("Noise η, rad").is_visible()
    open_drawer(page, "Monitors")
    page.locator(".fs-card").first.wait_for()
    until(lambda: laboratory.selected is None)
    until(lambda: page.evaluate(LAID_OUT)["drawers"] == ["Monitors"])


def test_a_window_that_is_turned_keeps_its_drawer(page):
    open_drawer(page, "View")
    colour = page.get_by_label("Colour by", exact=True).first
    for wide, tall in ((844, 390), (390, 844)):
        page.set_viewport_size({"width": wide, "height": tall})
        until(lambda: page.evaluate(LAID_OUT)["drawers"] == ["View"])
        colour.wait_for()


PANELS = """() => ["left", "right"].map(
  (side) => document.querySelector(`[data-dock-region=${side}]`)?.getBoundingClientRect().width)"""


def test_panels_are_as_wide_as_before_once_a_window_has_been_small(page):
    for _ in range(2):
        for (wide, tall), most in (((1440, 860), 648), ((1024, 640), 512)):
            page.set_viewport_size({"width": wide, "height": tall})
            until(
                lambda most=most: (widths := page.evaluate(PANELS))[0] and sum(widths) <= most,
                30,
                f"panels of {most} pixels in a window of {wide}",
            )
        page.set_viewport_size({"width": 390, "height": 844})
        until(lambda: page.locator("[data-dock-region]").count() == 0)


def test_what_is_in_drawers_can_be_used_in_both_themes(page):
    for _ in range(2):
        for name in ("Monitors", "View", "Sweep", "Run"):
            open_drawer(page, name)
            until(lambda: find_violations(page) == [], 60, "no rule broken in a drawer")
        open_drawer(page, "Run")
        page.keyboard.press("m")


@pytest.mark.parametrize("size", [(390, 844), (1024, 640)])
def test_the_plots_can_be_shown_over_the_picture_alone(page, laboratory, size):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    laboratory.simulation.step()
    until(lambda: page.locator(".uplot-container").count() > 0)
    page.keyboard.press("p")
    plot = page.locator(".uplot-container").first
    plot.wait_for()
    until(lambda: page.evaluate(LAID_OUT)["share"] > 0.8)
    assert not page.locator(".fs-card").first.is_visible()

    def is_seen() -> bool:
        box = plot.bounding_box()  # panels slide for a moment
        return box["x"] >= 0 and box["x"] + box["width"] <= size[0]

    until(is_seen, 30, "the plot in the window")
    page.keyboard.press("p")
    until(lambda: not plot.is_visible())
    until(lambda: page.evaluate(LAID_OUT)["share"] == 1.0)
    page.keyboard.press("p")


def test_of_two_flocks_a_plot_is_seen_without_scrolling(page, laboratory):
    page.set_viewport_size({"width": 1440, "height": 860})
    laboratory.simulation.setup(START, preset_spec("vem", agents=60, seed=3))
    page.locator(".fs-pair").first.wait_for()
    plot = page.locator(".uplot-container").first
    until(lambda: (box := plot.bounding_box()) and box["y"] + box["height"] < 860, COMPILED)
    assert page.locator(".fs-bars").first.bounding_box()["y"] > 860
