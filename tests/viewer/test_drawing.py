"""When it is drawn: as soon as there is something new, seldom with nobody there, within bounds."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.viewer.scene.draw.attitude import (
    FINE,
    OF_LENGTH,
    ROUND,
    attitude,
    quantise_attitudes,
    rounded_places,
)
from app.viewer.scene.drawing import BURST, REST, Drawing, Rates, period
from app.viewer.scene.shown.drawing_style import DrawingStyle
from tests.viewer.sky import frame, heading
from tests.viewer.waiting import HandTime, until


class Stand:
    """Stands for the scene and the laboratory, and moves the clock."""

    def __init__(self, frame, watched: int = 1, **rates):
        self.frame, self.watched = frame, watched
        self.time = HandTime()
        self.worked = 0.0
        self.shown: list[float] = []
        self.panels = self.looks = self.state = 0
        self.news = self.time.event()
        self.moves = math.inf
        self.drawing = Drawing(
            self, self.latest, lambda: self.watched, self.before, self.refresh, self.news,
            lambda: self.moves, Rates(**rates), lambda: self.state, self.time, lambda: self.worked,
        )  # fmt: skip
        self.drawing.come = self.time.event()
        self.drawing.closing = self.time.event()

    def run(self, seconds: float) -> None:
        """Have it draw for so long."""
        end = self.time() + seconds
        while self.time() < end:
            self.drawing.draw_once()

    def another(self) -> None:
        """There is a frame that was not shown yet."""
        self.frame = frame([heading(0.0)] * 3)
        self.news.set()

    def show(self, _frame, _look) -> None:
        self.shown.append(self.time())

    def follow_cameras(self) -> None:
        pass

    def latest(self):
        return self.frame, DrawingStyle()

    def before(self) -> None:
        self.looks += 1

    def refresh(self) -> None:
        self.panels += 1


def stand(**changes) -> Stand:
    """A drawing that has drawn its first frame."""
    made = Stand(frame([heading(0.0)] * 3), **changes)
    made.drawing.draw_once()
    assert len(made.shown) == 1
    return made


def test_a_thread_draws_until_it_is_closed():
    made = Stand(frame([heading(0.0)] * 3))
    made.drawing.start()
    until(lambda: made.looks > 10, 60)
    made.drawing.close()
    assert not made.drawing.thread.is_alive()
    assert len(made.shown) == 1


def test_what_is_new_is_drawn_at_once_and_nothing_is_looked_for_without_news():
    made = stand()
    made.run(0.3)
    looks = made.looks
    made.run(1.0)
    assert made.looks - looks <= 1.0 / REST + 6
    told = made.time() + 0.3 * REST
    made.time.at(told, made.another)
    made.run(REST)
    assert made.shown[1:] == [told]


def test_with_nobody_there_little_is_drawn_and_who_comes_is_shown_what_is():
    made = stand(watched=0, unseen=0.5)
    panels = made.panels
    made.time.at(0.01, made.another, every=0.01)
    made.run(2.2)
    assert 4 <= len(made.shown) - 1 <= 5
    assert 4 <= made.panels - panels <= 5
    came = made.time() + 0.1

    def come() -> None:
        made.watched = 1
        made.drawing.show_to_newcomer()

    made.time.at(came, come)
    made.run(0.2)
    assert came in made.shown


def test_no_more_pictures_than_are_allowed():
    made = stand(fastest=0.1)
    made.time.at(0.005, made.another, every=0.005)
    made.run(1.5)
    assert 14 <= len(made.shown) - 1 <= 16


def test_panels_show_at_once_what_has_been_pressed():
    made = stand(panels=30.0)
    before = made.panels
    made.time.at(0.01, made.another, every=0.01)
    made.run(0.2)
    assert made.panels == before
    made.state = 1
    made.drawing.draw_once()
    assert made.panels == before + 1


def test_a_thread_that_draws_what_is_dear_keeps_to_its_share():
    made = stand(share=0.1)
    draw_at_cost(made, 0.05)
    made.run(2.0 * BURST)
    assert made.worked == pytest.approx(BURST, rel=0.3)
    before = made.worked, made.time()
    made.run(20.0)
    share = (made.worked - before[0]) / (made.time() - before[1])
    assert share == pytest.approx(0.1, abs=0.01)


def test_what_is_drawn_once_and_is_dear_keeps_no_page_waiting():
    made = stand(share=0.1)
    draw_at_cost(made, 0.8 * BURST)
    made.run(BURST)
    draw_at_cost(made, 0.001)
    before = len(made.shown)
    made.run(0.5)
    assert len(made.shown) - before > 5


def draw_at_cost(made: Stand, seconds: float) -> None:
    """Have every frame take so much work from now on; there is always a new one."""

    def work(_frame, _look) -> None:
        made.worked += seconds
        made.time.now += seconds
        made.shown.append(made.time())

    made.show = work
    made.time.at(made.time() + 0.005, made.another, every=0.005)


def test_a_class_has_a_bandwidth_of_its_own():
    assert period(300, 1, bandwidth=42_000.0) == pytest.approx(0.2)
    assert period(300, 1, bandwidth=1.0) == 0.25
    assert period(300, 1, fastest=1 / 15) == pytest.approx(1 / 15)


@pytest.mark.parametrize("length", [2.0, 0.3, 0.04, 0.003])
def test_places_are_off_by_less_than_can_be_seen(length):
    at = np.random.default_rng(1).uniform(-5.0, 5.0, (500, 3))
    off = np.abs(rounded_places(at, length) - at).max()
    assert off <= 0.5 * min(FINE, OF_LENGTH * length) + 1e-6
    assert off > 0.1 * min(FINE, 0.5 * OF_LENGTH * length)


def test_attitudes_are_off_by_less_than_can_be_seen_and_level_ones_are_few():
    generator = np.random.default_rng(2)
    angle = generator.uniform(-np.pi, np.pi, 5000)
    exact = attitude(np.column_stack([np.cos(angle), np.sin(angle)]))
    sent = quantise_attitudes(exact)
    apart = 2.0 * np.arccos(np.clip(np.abs((sent * exact).sum(axis=1)), 0.0, 1.0))
    assert apart.max() <= np.pi / ROUND + 1e-3
    assert len(np.unique(sent, axis=0)) <= 2 * ROUND
    assert np.linalg.norm(sent, axis=1) == pytest.approx(1.0, abs=1e-6)
    heading = generator.normal(size=(500, 3))
    exact = attitude(heading / np.linalg.norm(heading, axis=1, keepdims=True))
    assert np.abs(quantise_attitudes(exact) - exact).max() <= 2.0**-12 + 1e-7
