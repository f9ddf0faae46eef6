"""The names of real cars on the display: what they say, where they are, no flicker."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.viewer.scene.marks.labels import AFRESH as STAY
from app.viewer.scene.marks.labels import (
    BESIDE,
    MOST,
    LiveLabels,
    Sides,
    age_text,
    chosen_sides,
    clear_labels,
    label_text,
)
from app.viewer.scene.shown.debounce import HOLD, REFRESH, Debounce
from app.viewer.scene.shown.drawing_style import DrawingStyle
from app.viewer.scene.shown.frame import Live
from tests.viewer.fleet import frame, known, shown
from tests.viewer.live_fleet import live, live_frame
from tests.viewer.test_scene_worlds import Stand, draw

BOX = np.array([[0.9, 0.2]])


def written(scene: Stand) -> list[str]:
    return [one.text for one in scene.sent if "/names/" in one.name and one.visible]


def test_names_say_what_is_not_plain():
    scene = Stand()
    part = LiveLabels(scene)
    draw(part, shown(live_frame()))
    names = ["red", "blue · late 60 ms", "green · lost 1.3 s", "sim 1", "sim 2"]
    assert written(scene) == [*names, "injected car"]
    draw(part, shown(live_frame(), DrawingStyle(mission=False)))
    assert written(scene) == names
    draw(part, shown(frame()))
    assert written(scene) == []
    assert label_text("red", "stopped", 0.004) == "red · stopped"


@given(st.floats(0.0, 100.0), st.floats(0.0, 100.0))
def test_ages_are_told_in_steps_and_never_more_than_they_are(one, other):
    def number(text: str) -> float:
        value, unit = text.split()
        return float(value) * (0.001 if unit == "ms" else 1.0)

    low, high = sorted((one, other))
    assert number(age_text(low)) <= number(age_text(high))
    step = 0.01 if high < 0.2 else 0.1 if high < 10.0 else 1.0
    assert -1e-6 <= high - number(age_text(high)) < step + 1e-6


@pytest.mark.parametrize("name_at", [0.0, 0.5])
def test_a_name_is_clear_of_its_car(name_at):
    scene = Stand()
    one = live_frame(position=np.column_stack([np.linspace(-2.0, 2.0, 5), np.full(5, name_at)]))
    made = shown(one, DrawingStyle(mission=False))
    draw(LiveLabels(scene), made)
    for label, at in zip(scene.sent, made.at, strict=True):
        up = label.position[1] - at[1]
        assert abs(up) == pytest.approx(BESIDE * made.length)
        assert label.anchor == ("bottom-center" if up > 0.0 else "top-center")


def crowd(count: int) -> tuple[Live, dict]:
    late = tuple("late" if row % 10 == 0 else "tracked" for row in range(count))
    names = tuple(f"car {row}" for row in range(count))
    state = Live(names, names, late, np.full(count, 0.05), 0.4, "safe")
    changes = {
        "position": np.column_stack([np.linspace(-2.0, 2.0, count), np.zeros(count)]),
        "heading": np.tile((1.0, 0.0), (count, 1)),
        "speed": np.ones(count),
        "informed": np.zeros(count, bool),
        "ids": np.arange(count),
        "cars": known(count),
    }
    return state, changes


@pytest.mark.parametrize(("count", "names"), [(MOST, MOST), (MOST + 1, 5)])
def test_of_very_many_only_those_in_trouble_are_named(count, names):
    scene = Stand()
    state, changes = crowd(count)
    draw(LiveLabels(scene), shown(live_frame(state=state, **changes), DrawingStyle(mission=False)))
    assert len(written(scene)) == names


def test_a_name_stands_where_it_hides_no_other_car():
    pair = np.array([[0.0, 0.0], [0.1, 0.35]])
    boxes = np.repeat(BOX, 2, axis=0)
    assert chosen_sides([False, False], pair, boxes, 0.2, 0.1) == [True, False]
    far = np.array([[0.0, 0.0], [2.0, 0.35]])
    assert chosen_sides([False, True], far, boxes, 0.2, 0.1) == [False, True]
    level = np.array([[0.0, 0.0], [0.5, 0.0]])
    one, other = chosen_sides([False, False], level, boxes, 0.2, 0.1)
    assert one is not other


def test_a_name_changes_sides_at_most_every_half_second():
    sides = Sides()
    free, above = np.array([[0.0, 0.0], [2.0, 0.0]]), np.array([[0.0, 0.0], [0.1, 0.35]])
    boxes = np.repeat(BOX, 2, axis=0)

    def below(run: int, now: float, at: np.ndarray) -> bool:
        return sides.below(run, now, [0, 1], at, boxes, 0.2, 0.1)[0]

    assert not below(1, 0.0, free)
    assert not below(1, 0.9 * STAY, above)
    assert below(1, 1.1 * STAY, above)
    assert below(1, 1.2 * STAY, free)
    assert below(1, 9.0, free), "nothing is in the way on either side"
    assert not below(2, 9.1, free)


def test_a_new_car_has_a_name_at_once():
    sides = Sides()
    sides.below(1, 0.0, [0], np.zeros((1, 2)), BOX, 0.2, 0.1)
    two = sides.below(
        1, 0.01, [0, 7], np.array([[0.0, 0.0], [3.0, 0.0]]), np.repeat(BOX, 2, 0), 0.2, 0.1
    )
    assert two == [False, False]


def debounced(
    debounce: Debounce, seconds: float, state: str, age: float, run: int = 1
) -> tuple[str, float]:
    given_states = live(states=(state, "tracked", "tracked", "simulated", "simulated"))
    ages = np.array([age, 0.0, 0.0, 0.0, 0.0])
    one = live_frame(round(100 * seconds), replace(given_states, ages=ages), run=run)
    made = debounce.debounced(one).live
    return made.states[0], float(made.ages[0])


def test_what_is_bad_is_shown_at_once_and_what_is_good_when_it_lasts():
    debounce = Debounce()
    assert debounced(debounce, 0.00, "tracked", 0.005) == ("tracked", 0.005)
    assert debounced(debounce, 0.01, "late", 0.04) == ("late", 0.04)
    assert debounced(debounce, 0.02, "tracked", 0.005) == ("late", 0.04)
    assert debounced(debounce, 0.10, "late", 0.06) == ("late", 0.04)
    assert debounced(debounce, 0.12, "lost", 0.11) == ("lost", 0.11)
    assert debounced(debounce, 0.12 + 0.9 * HOLD, "tracked", 0.0)[0] == "lost"
    assert debounced(debounce, 0.12 + 1.1 * HOLD, "tracked", 0.0) == ("tracked", 0.0)
    assert debounced(debounce, 0.60, "stopped", 0.0)[0] == "stopped"
    assert debounced(debounce, 0.61, "tracked", 0.0)[0] == "tracked"


def test_ages_are_told_a_few_times_a_second_and_of_the_run_that_is_shown():
    debounce = Debounce()
    shown_ages = [debounced(debounce, tick / 100, "lost", tick / 100)[1] for tick in range(101)]
    assert len(set(shown_ages)) <= 1.0 / REFRESH + 1
    assert max(shown_ages) >= 1.0 - REFRESH
    assert debounced(debounce, 1.01, "tracked", 0.0, run=2)[0] == "tracked"
    assert debounced(debounce, 0.50, "tracked", 0.0, run=2)[0] == "tracked"


def test_a_simulation_is_shown_as_it_is():
    debounce, one = Debounce(), frame()
    assert debounce.debounced(one) is one


@given(st.integers(0, 2**32 - 1), st.integers(1, 40))
def test_numbers_do_not_lie_upon_each_other_and_those_written_stay(seed, count):
    rng = np.random.default_rng(seed)
    at, size = rng.uniform(0.0, 10.0, (count, 2)), np.tile([0.6, 0.3], (count, 1))
    written = clear_labels(at, size, np.zeros(count, bool))
    assert written[0]
    apart = np.abs(at[:, None] - at)
    over = (apart < size).all(axis=-1) & ~np.eye(count, dtype=bool)
    assert not over[np.ix_(written, written)].any()
    assert np.all(over[~written][:, written].any(axis=1))
    closer = at + rng.uniform(-0.04, 0.04, (count, 2))
    assert np.all(clear_labels(closer, size, written)[written])
