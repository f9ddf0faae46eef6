"""Steps of a lesson in its page: one at a time, and what a reader predicts is judged by the run."""

from __future__ import annotations

import pytest

from agents.flock import Flock
from app.viewer.gallery.lessons.lessons import lesson_names
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.gallery.scene_collection import find_lesson
from app.viewer.lab.flock_page import PageWords, page_files
from tests.browser.accessibility import find_violations_in_both_themes
from tests.browser.exported_page import page_text
from tests.classroom.test_lesson_steps import RUN, mean_measured, scene_text
from tests.viewer.waiting import until


def words_of(scene: SavedScene) -> PageWords:
    """What the page of a scene says."""
    return PageWords.of_scene(scene, "flockscope export mine.toml")


@pytest.fixture
def lesson(opened):
    """Opens the page of a scene; its runs go as fast as a page can."""

    def opens(scene: SavedScene, **options):
        script = (
            "addEventListener('DOMContentLoaded', () => { Page.prototype.speed = () => 1000; });"
        )
        return opened(Flock(scene.spec), script=script, words=words_of(scene), **options)

    return opens


def small_scene(**changes: str) -> SavedScene:
    """A scene of two steps; the second has a prediction."""
    return SavedScene.from_toml(scene_text(**changes), "mine.toml")


def test_a_step_shows_its_picture(lesson):
    text = scene_text().replace('say = "Begin."', 'say = "Begin."\npicture = "lesson-who-leads"')
    with lesson(SavedScene.from_toml(text, "mine.toml")) as page:
        picture = page.locator("#step-picture")
        until(lambda: picture.evaluate("shown => shown.naturalWidth") == 360, 30, "the picture")
        assert picture.is_visible()
        page.click("#step-next")
        assert picture.count() == 0
        page.click("#step-back")
        assert picture.is_visible()


def judged(page) -> list[str]:
    """What the page says of a run, once it says so."""
    lines = page.locator("#step-verdict p")
    until(lines.count, 60, "what the run shows")
    return lines.all_inner_texts()


def predicted(page, choice: str) -> list[str]:
    """Predict a choice, run the step, and what the page then says."""
    page.get_by_label(choice, exact=True).check()
    page.click("#step-run")
    return judged(page)


def control(page, place: str) -> list[str]:
    """The names of the sliders in a part of the page."""
    return page.locator(f"{place} .slider .words").all_inner_texts()


def test_a_reader_goes_from_the_first_step_to_the_last(lesson):
    scene = find_lesson("who-leads")
    with lesson(scene) as page:
        assert find_violations_in_both_themes(page) == []
        # What its first step says of colours is so.
        assert page.locator("#colour").input_value() == scene.look["colour"] == "layer"
        names = sorted(control(page, "#sliders"))
        for number, step in enumerate(scene.steps, 1):
            assert page.locator("#step-place").inner_text() == f"Step {number} of 4"
            assert page.locator("#step-words").inner_text() == step.say
            shown = control(page, "#step-control")
            assert shown == (["Weight from layer to layer"] if step.controls else [])
            assert sorted(shown + control(page, "#sliders")) == names
            assert control(page, "#sliders")[-1] == "Heading of the information agent"
            assert page.locator("#step-prediction").is_visible() == bool(step.ask)
            if step.ask:
                seed = 7 + number
                page.evaluate("(seed) => page.beginAnew('300', seed)", str(seed))
                assert page.locator("#step-run").is_disabled()
                assert page.locator("#go").is_enabled()
                told, verdict, *why = predicted(page, "Yes")
                mean = mean_measured(scene.spec.but(seed=seed), step)
                found = step.choice_of(mean)
                assert told == (
                    f"Polarisation: {mean:.3f}, the mean of ticks 16 to 30. "
                    f"This run shows “{found}”."
                )
                holds = "holds" if found == "Yes" else "does not hold"
                assert verdict == f"Your prediction “Yes” {holds}."
                assert why == ([step.why] if found == step.shows else [])
                assert page.evaluate("[page.state.tick, page.going]") == [30, False]
                assert page.evaluate("page.values.p2") == step.set["p2"]
                assert page.locator("#step-answers input:enabled").count() == 0
            if number < 4:
                page.click("#step-next")
        assert page.locator("#step-next").is_disabled()
        page.click("#step-back")
        assert len(judged(page)) in (2, 3)  # what a run has shown is still there


CHANGES = {
    "a slider": ("page.set(page.manifest.parameters[0], 2.0)", "You moved a slider"),
    "Reset": ("document.getElementById('reset').click()", "The flock was put back to its start"),
    "another seed": (
        "document.getElementById('another').click()",
        "The flock was put back to its start",
    ),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_run_that_is_another_one_by_now_is_not_judged(lesson, change):
    code, why = CHANGES[change]
    with lesson(small_scene(ticks="20000")) as page:
        page.click("#step-next")
        page.get_by_label("much").check()
        page.click("#step-run")
        until(lambda: page.evaluate("page.state.tick > 3"), 60, "some ticks")
        assert page.locator("#step-progress").is_visible()
        page.evaluate(code)
        assert judged(page) == [f"{why}, so this is not the run of this step. It is not judged."]
        assert page.evaluate("page.trial === undefined")
        assert page.locator("#step-progress").is_hidden()
        assert page.locator("#step-run").inner_text() == "Run it again"


def test_a_pause_and_single_ticks_leave_the_run_what_it_is(lesson):
    scene = small_scene(ticks="12")
    with lesson(scene) as page:
        page.click("#step-next")
        page.get_by_label("much").check()
        page.evaluate("Page.prototype.go = () => {}")
        page.click("#step-run")
        for tick in range(1, 13):
            page.click("#step")
            until(lambda tick=tick: page.evaluate("page.state.tick") == tick, 60, "a tick")
        mean = mean_measured(scene.spec, scene.steps[1])
        assert f"Polarisation: {mean:.3f}, the mean of ticks 7 to 12." in judged(page)[0]
        page.click("#step")
        until(lambda: page.evaluate("page.state.tick") == 13, 60, "a tick more")


@pytest.mark.parametrize("measure", ["groups", "nearest-neighbour"])
def test_what_takes_long_is_measured_after_each_tick_too(lesson, measure):
    scene = small_scene(measure=f'"{measure}"', ticks="40")
    with lesson(scene) as page:
        page.click("#step-next")
        told, _ = predicted(page, "much")
        name, number = told.partition(", the mean of ticks 21 to 40")[0].split(": ")
        assert name == measure.replace("-", " ").capitalize()
        assert number.split()[0] == f"{mean_measured(scene.spec, scene.steps[1]):.4g}"


def test_it_may_be_run_again_with_another_seed_and_is_judged_anew(lesson):
    scene = small_scene()
    step = scene.steps[1]
    with lesson(scene) as page:
        page.click("#step-next")
        for seed in (scene.spec.seed, 5):
            page.evaluate("(seed) => page.beginAnew('20', seed)", str(seed))
            if seed == scene.spec.seed:
                page.get_by_label("much").check()
            page.click("#step-run")
            mean = mean_measured(scene.spec.but(seed=seed), step)
            until(
                lambda mean=mean: f"Polarisation: {mean:.3f}," in " ".join(judged(page)),
                60,
                "the number of this run",
            )


def test_it_is_worked_by_keys_alone_and_said_aloud(lesson):
    with lesson(small_scene()) as page:
        page.focus("#step-next")
        page.keyboard.press("Enter")
        assert page.evaluate("document.activeElement.id") == "step-back"
        assert page.locator("#step-sentence").get_attribute("aria-live") == "polite"
        assert page.locator("#step-verdict").get_attribute("role") == "status"
        assert page.get_by_role("group", name="How much order?").is_visible()
        page.get_by_label("little").focus()
        page.keyboard.press("ArrowDown")
        assert page.get_by_label("much").is_checked()
        page.keyboard.press("Tab")
        assert page.evaluate("document.activeElement.id") == "step-run"
        page.keyboard.press("Enter")
        assert len(judged(page)) == 2
        assert page.evaluate("document.activeElement.id") == "step-run"


def test_words_of_a_step_are_text(lesson):
    evil = "'<img src=x onerror=\"globalThis.owned = 1\">'"
    choices = f'[{evil}, "much"]'
    with lesson(small_scene(say=evil, ask=evil, choices=choices)) as page:
        page.click("#step-next")
        for place in ("#step-words", "#step-question", "#step-answers"):
            assert "<img src=x" in page.locator(place).inner_text()
        page.get_by_label("much").check()
        page.click("#step-run")
        assert judged(page)
        assert page.evaluate("globalThis.owned === undefined")
        assert page.locator("#steps img").count() == 0


@pytest.mark.parametrize("wide", [320, 390, 1100])
def test_a_step_stands_below_the_buttons_and_above_the_sliders(lesson, wide):
    long = '"' + "x" * 60 + '"'
    scene = small_scene(choices=f'[{long}, "much"]')
    with lesson(scene, viewport={"width": wide, "height": 800}) as page:
        page.click("#step-next")
        assert predicted(page, "x" * 60)
        tops = [page.locator(place).bounding_box()["y"] for place in (".bar", "#steps", "#sliders")]
        assert tops == sorted(tops)
        assert page.evaluate("document.documentElement.scrollWidth") <= wide
        for place in ("#steps", "aside"):
            inside = "(({ scrollWidth, clientWidth }) => scrollWidth <= clientWidth)"
            assert page.evaluate(f"{inside}(document.querySelector('{place}'))")


def test_on_a_phone_the_run_is_in_sight_and_then_what_it_shows(lesson):
    watch = """() => {
      const seen = ({ top, bottom }) => bottom > 0 && top < innerHeight;
      window.runsInSight = [];
      new MutationObserver(() => window.runsInSight.push(
        seen(document.querySelector("#picture").getBoundingClientRect())
      )).observe(document.querySelector("#step-run"), { childList: true });
    }"""
    with lesson(small_scene(), viewport={"width": 390, "height": 600}) as page:
        page.click("#step-next")
        page.evaluate(watch)
        assert predicted(page, "much")
        bottom = "document.querySelector('#step-verdict').getBoundingClientRect().bottom"
        assert page.evaluate(f"{bottom} < innerHeight + 1 && {bottom} > 0")
        assert page.evaluate("window.runsInSight.includes(true)")


def test_a_page_without_steps_has_nothing_of_them():
    scene = SavedScene.from_toml(RUN, "mine.toml")
    plain = page_text(Flock(scene.spec), words_of(scene))
    assert "StepCard" not in plain
    assert "step-verdict" not in plain
    with_steps = page_text(Flock(scene.spec), words_of(small_scene()))
    assert len(with_steps) - len(plain) < 12_000


def test_pages_of_a_folder_share_what_shows_steps():
    scene = small_scene()
    files = page_files(Flock(scene.spec), "mine", words_of(scene))
    assert b'"steps":[{"say":"Begin."}' in files["mine.html"]
    assert b"class StepCard" in files["viewer.js"]
    assert b"#step-verdict" in files["viewer.css"]


def test_a_step_begins_with_its_agents_and_is_compared_with_an_earlier_one(lesson):
    scene = find_lesson("seven-neighbours")
    second, third = scene.steps[1:3]
    with lesson(scene) as page:
        for _ in range(2):
            page.click("#step-next")
        page.get_by_label("Much less").check()
        assert page.locator("#step-run").is_disabled()
        assert page.locator("#step-first").inner_text() == "Run step 2 first."
        page.click("#step-back")
        predicted(page, "Most")
        page.click("#step-next")
        page.click("#step-run")
        told, verdict, why = judged(page)
        assert page.evaluate("page.state.ids.length") == third.set["agents"] == 60
        means = [mean_measured(scene.spec, step) for step in (second, third)]
        assert f"Polarisation: {means[1]:.3f}, the mean of ticks 201 to 400, " in told
        assert f"{means[0] - means[1]:.3f} less than in step 2." in told
        assert (verdict, why) == ("Your prediction “Much less” holds.", third.why)
        assert page.locator("#charts select").first.input_value() == "polarisation"


IN_PICTURE = """() => {
  const { view } = page, { width, height } = view.canvas;
  const isIn = (at, most) => at >= 0 && at <= most;
  const rows = [...view.ids.keys()].filter((row) => !(page.state.kind?.[row] < 0));
  const places = rows.map((row) => view.project(...view.placeOf(row)));
  return places.filter(([x, y]) => isIn(x, width) && isIn(y, height)).length / places.length;
}"""
"""The share of agents, without those that were caught and left behind, that the picture shows."""


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", lesson_names())
def test_every_lesson_shows_in_its_page_what_it_says(lesson, name):
    scene = find_lesson(name)
    with lesson(scene) as page:
        if "colour" in scene.look:
            assert page.locator("#colour").input_value() == scene.look["colour"]
        for number, step in enumerate(scene.steps, 1):
            shown = control(page, "#step-control")
            assert len(shown) == len(step.controls)
            if step.ask:
                told, verdict, *why = predicted(page, step.shows)
                assert f"This run shows “{step.shows}”." in told, number
                assert verdict == f"Your prediction “{step.shows}” holds."
                assert why == ([step.why] if step.why else [])
                assert page.evaluate(IN_PICTURE) > 0.5, "most are shown, however far they fly"
            if number < len(scene.steps):
                page.click("#step-next")


def test_a_step_begins_with_as_many_of_a_kind_as_its_page(lesson):
    scene = find_lesson("shepherd")
    dogs = scene.spec.kinds[0].agents
    with lesson(scene) as page:
        field = page.get_by_label("dog", exact=True)
        assert field.input_value() == str(dogs)
        field.fill(str(dogs + 2))
        field.press("Enter")
        all_agents = scene.spec.agents + dogs
        now = "page.state.ids.length"
        until(lambda: page.evaluate(now) == all_agents + 2, 60, "more dogs")
        while not page.locator("#step-prediction").is_visible():
            page.click("#step-next")
        page.locator("#step-answers input").first.check()
        page.click("#step-run")
        until(lambda: page.evaluate(now) == all_agents, 60, "the flock of the step")
        assert field.input_value() == str(dogs)


def test_a_step_says_whose_number_it_sets_and_sliders_of_a_kind_stay_below_its_name(lesson):
    with lesson(find_lesson("shepherd")) as page:
        below = "[...$('sliders').children].map((one) => one.matches('h2') ? one.textContent : '')"
        order = page.evaluate(below)
        assert order.index("dog") > 0
        for _ in range(3):
            page.click("#step-next")
        assert page.locator("#step-plan").inner_text() == (
            "1\u2009000 ticks from the start, with s = 1, dog: s = 0."
        )
        assert control(page, "#step-control") == ["Speed"]
        assert page.locator("#charts select").first.input_value() == "polarisation of flock"
        for _ in range(3):
            page.click("#step-back")
        assert page.evaluate(below) == order
