"""A page's flock from another start: another seed, another number of agents."""

from __future__ import annotations

import numpy as np
import pytest

from agents.flock import Flock
from tests.viewer.waiting import until


def told(page) -> str:
    """What the page says."""
    return page.locator("#say").inner_text()


def fill(page, **fields: str) -> None:
    """Write into fields, and leave them."""
    for name, value in fields.items():
        page.fill(f"#{name}", value)
        page.press(f"#{name}", "Enter")
        page.evaluate("() => document.activeElement.blur()")


def places(page) -> np.ndarray:
    """Where the agents are, (N, 2)."""
    return np.array(page.evaluate("[...page.state.position]")).reshape(-1, 2)


def count_of(page) -> int:
    """How many agents the page shows."""
    return page.evaluate("page.state.ids.length")


def test_fields_begin_the_flock_that_a_seed_and_a_number_give_here(opened):
    flock = Flock("vem", agents=30, rng=3)
    with opened(flock) as page:
        assert page.input_value("#agents") == "30"
        assert page.input_value("#seed") == "3"
        page.click("#step")
        until(lambda: page.locator("#tick").inner_text() == "1", 60, "a tick")
        fill(page, agents="50")
        until(lambda: count_of(page) == 50, 60, "fifty agents")
        fill(page, seed="7")
        expected = Flock("vem", agents=50, rng=7, size=flock.world.size)
        until(lambda: np.allclose(places(page), expected.position, atol=1e-12), 60, "seed 7")
        assert page.locator("#tick").inner_text() == "0"
        assert page.get_attribute("#picture", "aria-label").startswith("50 agents")
        page.evaluate("page.ask({ticks: 20})")
        expected.run(20)
        until(lambda: page.evaluate("page.state.tick") == 20, 60, "20 ticks")
        assert places(page) == pytest.approx(expected.position, abs=1e-9)
        page.click("#reset")
        until(lambda: page.evaluate("page.state.tick") == 0, 60, "the start")
        assert count_of(page) == 50, "Reset begins as it began last"
        page.click("#another")
        until(lambda: page.input_value("#seed") != "7", 60, "another seed")
        assert f"seed={page.input_value('#seed')}" in page.evaluate("location.hash")


def test_a_number_that_cannot_be_is_refused_in_a_line_and_the_flock_stays(opened):
    with opened(Flock("vem", agents=30, rng=3)) as page:
        before = places(page)
        for name, value, why in (
            ("agents", "0", "Agents: 1 to 20"),
            ("agents", "20001", "Agents: 1 to 20"),
            ("agents", "1e9", "Agents: 1 to 20"),
            ("agents", "", "Agents: 1 to 20"),
            ("seed", "-1", "Seed: a whole number"),
            ("seed", "1.5", "Seed: a whole number"),
            ("seed", "9" * 19, "Seed: a whole number"),
        ):
            kept = page.input_value(f"#{name}")
            fill(page, **{name: value})
            until(lambda why=why: why in told(page), 60, why)
            assert page.input_value(f"#{name}") == kept
            fill(page, seed="4")
            until(lambda: told(page) == "", 60, "a start that can be")
            fill(page, seed="3")
            until(lambda: np.allclose(places(page), before), 60, "the first start")


def test_agents_that_do_not_fit_are_refused_and_those_before_come_back(opened):
    flock = Flock("reynolds", agents=5, rng=3, spacing=3.0, world="wrap", size=12.0)
    with opened(flock) as page:
        fill(page, agents="500")
        until(lambda: "500 agents do not fit" in told(page), 60, "a refusal")
        assert page.input_value("#agents") == "5"
        assert places(page) == pytest.approx(flock.position, abs=1e-12)
        assert page.evaluate("page.going") is False


def test_the_address_says_how_it_begins_and_what_is_nonsense_is_refused(opened):
    flock = Flock("vem", agents=30, rng=3)
    with opened(flock) as page:
        page.goto(page.url.partition("#")[0] + "#seed=7&agents=40")
        page.reload()
        until(lambda: page.evaluate("'page' in globalThis"), 60, "the flock to be there")
        expected = Flock("vem", agents=40, rng=7, size=flock.world.size)
        assert places(page) == pytest.approx(expected.position, abs=1e-12)
        page.goto(page.url.partition("#")[0] + "#agents=<b>1</b>&seed=NaN")
        page.reload()
        until(lambda: page.evaluate("'page' in globalThis"), 60, "the flock to be there")
        assert told(page) == "Agents: 1 to 20\u2009000."
        assert places(page) == pytest.approx(flock.position, abs=1e-12)


def test_reset_counts_what_sliders_say_of_the_start(opened):
    words = {"agents": 12, "world": "open", "size": 40.0}
    with opened(Flock("dorsogna", rng=3, **words)) as page:
        page.evaluate(
            "() => page.set(page.manifest.parameters.find((one) => one.name === 'v_start'), 0.5)"
        )
        page.click("#reset")
        expected = Flock("dorsogna", rng=3, v_start=0.5, **words).speed
        until(
            lambda: np.allclose(page.evaluate("[...page.state.speed]"), expected),
            60,
            "the speeds of the start",
        )


def test_a_flock_from_given_arrays_has_no_other_start(opened):
    start = {"position": np.array([[1.0, 1.0], [2.0, 2.0]]), "heading": np.eye(2)}
    with opened(Flock("vem", start=start, size=5.0, rng=1)) as page:
        assert not page.locator("#anew").is_visible()
        page.click("#reset")
        until(lambda: page.evaluate("page.state.tick") == 0, 60, "the start")
        assert places(page) == pytest.approx(start["position"])


def test_where_obstacles_are_drawn_by_the_seed_the_page_says_that_they_stay(opened):
    with opened(Flock("guarded", agents=8, rng=3)) as page:
        assert page.locator("#stays").inner_text() == "The obstacles stay those of seed 3."
        assert page.locator("#stays").is_visible()


def test_agents_keep_the_distance_that_is_asked_for_also_where_they_do_not_see_so_far(
    opened, tmp_path
):
    layout = tmp_path / "hall.toml"
    layout.write_text('edges = "solid"\nsize = [400.0, 400.0]\n', encoding="utf-8")
    words = {"agents": 4, "world": str(layout), "spacing": 90.0}
    with opened(Flock("boundary-points", rng=3, **words)) as page:
        fill(page, seed="8")
        expected = Flock("boundary-points", rng=8, **words).position
        until(lambda: np.allclose(places(page), expected, atol=1e-9), 60, "seed 8")


def test_an_address_asks_in_vain_for_another_start_where_there_is_none(opened):
    start = {"position": np.array([[1.0, 1.0], [2.0, 2.0]]), "heading": np.eye(2)}
    with opened(Flock("vem", start=start, size=5.0, rng=1)) as page:
        page.goto(page.url + "#seed=7")
        page.reload()
        until(lambda: page.evaluate("'page' in globalThis"), 60, "the flock to be there")
        assert told(page) == "This flock has no other start."
        assert places(page) == pytest.approx(start["position"])


def test_a_reset_that_finds_no_room_says_so_and_leaves_the_flock_as_it_was_made(opened):
    flock = Flock("reynolds", agents=5, rng=3, spacing=3.0, world="wrap", size=12.0)
    with opened(flock) as page:
        answer = page.evaluate(
            "page.ask({ reset: true, set: Object.entries(page.values), start: ['4', 500] })"
        )
        assert "500 agents do not fit" in answer["error"]
        assert places(page) == pytest.approx(flock.position, abs=1e-12)
