"""The gallery in a browser: found by a key, searched, opened; an address; what is shared."""

from __future__ import annotations

import pytest

from app.viewer.gallery.saved_scene import SavedScene, pack_scene
from app.viewer.gallery.scene_collection import MOVES, built_in_scene, cards
from app.viewer.run.run_preset import preset_spec
from tests.browser.accessibility import find_violations
from tests.browser.window import is_compiled
from tests.viewer.waiting import COMPILED, until


def runs(laboratory, model: str) -> bool:
    state = laboratory.simulation.state
    return state.spec.model == model and not state.busy


@pytest.fixture
def anew(laboratory):
    """The laboratory, whose flock stands and looks as usual again afterwards."""
    yield laboratory
    laboratory.open(SavedScene("start", preset_spec(agents=60, seed=3, parameters={"eta": 0.3})))
    until(lambda: runs(laboratory, "hwvem"))
    laboratory.simulation.pause().result(60)


def test_a_scene_is_found_in_the_gallery_and_opened(window, anew):
    page = window.page
    page.keyboard.press("g")
    page.locator(".fs-choice").first.wait_for()
    assert page.locator(".fs-choice").count() > 60
    until(lambda: page.evaluate("[...document.querySelectorAll('.fs-choice img')][0].naturalWidth"))
    before = anew.simulation.state.running
    page.locator(".fs-sheet input").fill("order noise")
    page.keyboard.press("Space")  # goes into the field, not to the flock
    assert anew.simulation.state.running == before
    page.locator(".fs-sheet input").fill("order out of noise")
    until(lambda: page.locator(".fs-choice:visible").count() == 1)
    page.locator(".fs-sheet input").fill("no such thing")
    page.get_by_text("Nothing is called").wait_for()
    page.locator(".fs-sheet input").fill("one knows")
    page.locator(".fs-choice:visible").first.click()
    until(lambda: anew.simulation.state.spec.agents == 1000, 60)
    page.get_by_text(built_in_scene("spread").watch).wait_for()
    until(lambda: page.locator(".fs-sheet").count() == 0)
    until(lambda: is_compiled(anew.simulation), COMPILED)
    until(lambda: window.card("agents") == "1\u202f001", 60)


def test_the_gallery_closes_by_escape_a_click_beside_it_and_its_button(window):
    page = window.page
    for close in (
        lambda: page.keyboard.press("Escape"),
        lambda: page.mouse.click(8, 320),
        lambda: page.get_by_role("button", name="Close", exact=True).last.click(),
    ):
        page.get_by_role("button", name="Gallery", exact=True).click()
        page.locator(".fs-choice").first.wait_for()
        close()
        until(lambda: page.locator(".fs-sheet").count() == 0)


def test_sheets_can_be_used_by_everybody_in_both_themes(window):
    page = window.page
    for _ in ("one theme", "the other"):
        for name in ("Gallery", "Share", "Take"):
            page.locator(".fs-open").get_by_role("button", name=name, exact=True).click()
            page.locator(".fs-sheet :is(.fs-choice, .fs-share textarea, .fs-take)").first.wait_for()
            assert page.evaluate("document.activeElement.closest('.fs-sheet') !== null")
            assert find_violations(page) == []
            page.keyboard.press("Escape")
            page.locator(".fs-sheet").wait_for(state="detached")
        page.keyboard.press("m")


def test_a_picture_moves_while_somebody_points_at_its_card_or_has_it_in_focus(window):
    page = window.page
    page.keyboard.press("g")
    card = page.locator(".fs-entry").first
    card.wait_for()
    picture, choice = card.locator("img"), card.locator(".fs-choice")

    def moves() -> bool:
        return (picture.get_attribute("src") or "").endswith(f"{MOVES}.webp")

    assert not moves()
    choice.hover()
    until(moves)
    until(lambda: picture.evaluate("one => one.naturalWidth") == 240)
    page.locator(".fs-sheet h2").first.hover()
    until(lambda: not moves())
    choice.focus()
    until(moves)
    page.locator(".fs-sheet input").focus()
    until(lambda: not moves())
    page.emulate_media(reduced_motion="reduce")
    choice.focus()
    card.locator("p button").first.wait_for()
    assert not moves(), "less motion is asked for"
    page.emulate_media(reduced_motion="no-preference")
    page.keyboard.press("Escape")


def test_what_a_card_is_related_to_is_reached_by_keys_and_opens(window, anew):
    page = window.page
    page.keyboard.press("g")
    page.locator(".fs-sheet input").fill("order out of noise")
    card = page.locator(".fs-entry:visible")
    until(lambda: card.count() == 1)
    assert not card.locator("p").is_visible()
    page.locator(".fs-entry:visible .fs-choice").focus()
    card.locator("p").wait_for()
    titles = {one.name: one.title for one in cards()}
    (own,) = [one for one in cards() if one.name == "order"]
    assert card.locator("p button").all_inner_texts() == [titles[name] for name in own.related]
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    until(lambda: runs(anew, "vem"), 60)
    until(lambda: page.locator(".fs-sheet").count() == 0)


def test_an_address_opens_its_scene_and_asks_where_others_watch(window, anew, chromium):
    assert window.page.url
    scene = pack_scene(SavedScene("mine", preset_spec("vem", agents=44, seed=9)))
    other = chromium.new_page(viewport={"width": 1100, "height": 600})
    other.goto(f"{anew.address}/?scene={scene}")
    other.get_by_text("It replaces the run that others watch too.").wait_for(timeout=60_000)
    assert anew.simulation.state.spec.model == "hwvem"
    assert "scene=" not in other.url
    other.get_by_role("button", name="Open it for all").click()
    until(lambda: anew.simulation.state.agents == 44, 60)
    assert anew.simulation.state.spec.seed == 9
    other.goto(f"{anew.address}/?scene=nothing")
    other.get_by_text("unknown scene").wait_for(timeout=60_000)
    other.close()
    until(lambda: anew.browsers() == 1)


def test_a_page_that_is_loaded_again_leaves_the_run_as_it_is(window, laboratory):
    page, run = window.page, laboratory.simulation.state.run
    page.evaluate("history.pushState(null, '', '?scene=order')")
    page.reload()
    until(lambda: window.card("tick") == "0", 60)
    assert page.evaluate("window.flockscopeScene") is None
    assert laboratory.simulation.state.run == run
    assert page.locator(".fs-sheet").count() == 0


def test_what_runs_is_shared_in_words_that_say_it(window):
    page = window.page
    window.press("Share")
    page.locator(".fs-share textarea").first.wait_for()
    fields = page.locator(".fs-share textarea").evaluate_all("all => all.map(one => one.value)")
    assert fields[0].startswith(page.url.partition("?")[0] + "?scene=z.")
    assert fields[1].startswith("flockscope lab hwvem --agents 60 --seed 3")
    assert 'Flock("hwvem", agents=60, seed=3, eta=0.3)' in fields[2]
    assert "Only this machine opens this address" in page.locator(".fs-share").inner_text()
    window.press("a page that runs by itself")
    page.get_by_role("button", name="Save page", exact=True).wait_for()
    page.keyboard.press("Escape")
