"""When it is drawn: as soon as there is something new, seldom with nobody there, within bounds."""

from __future__ import annotations

import math
import threading
import time

import numpy as np
import pytest

from app.viewer.scene.draw.attitude import FINE, OF_LENGTH, ROUND, attitude, places, turned
from app.viewer.scene.drawing import REST, Drawing, Rates, period
from app.viewer.scene.shown.drawing_style import DrawingStyle
from tests.viewer.waiting import until


class Stand:
    """Stands for the scene and the laboratory."""

    def __init__(self, frame, watched: int = 1, **rates):
        self.frame, self.watched = frame, watched
        self.shown: list[float] = []
        self.panels = self.looks = self.state = 0
        self.news = threading.Event()
        self.moves = math.inf
        self.drawing = Drawing(
            self, self.latest, lambda: self.watched, self.before, self.refresh, self.news,
            lambda: self.moves, Rates(**rates), lambda: self.state,
        )  # fmt: skip

    def show(self, _frame, _look) -> None:
        self.shown.append(time.monotonic())

    def look_through(self) -> None:
        pass

    def latest(self):
        return self.frame, DrawingStyle()

    def before(self) -> None:
        self.looks += 1

    def refresh(self) -> None:
        self.panels += 1


@pytest.fixture
def stand(request):
    from tests.viewer.sky import frame, heading

    made = Stand(frame([heading(0.0)] * 3), **getattr(request, "param", {}))
    made.another = lambda: frame([heading(0.0)] * 3)
    made.drawing.start()
    until(lambda: made.shown, 5)
    yield made
    made.drawing.close()
    assert not made.drawing.thread.is_alive()


def test_what_is_new_is_drawn_at_once_and_nothing_is_looked_for_without_news(stand):
    time.sleep(0.3)
    looks = stand.looks
    time.sleep(1.0)
    assert stand.looks - looks <= 1.0 / REST + 6
    before = len(stand.shown)
    stand.frame, told = stand.another(), time.monotonic()
    stand.news.set()
    until(lambda: len(stand.shown) > before, 5)
    assert stand.shown[-1] - told < 0.5 * REST


@pytest.mark.parametrize("stand", [{"watched": 0, "unseen": 0.5}], indirect=True)
def test_with_nobody_there_little_is_drawn_and_who_comes_is_shown_what_is(stand):
    time.sleep(0.2)
    before, panels, began = len(stand.shown), stand.panels, time.monotonic()
    while time.monotonic() < began + 2.2:
        stand.frame = stand.another()
        stand.news.set()
        time.sleep(0.01)
    assert 1 <= len(stand.shown) - before <= 5
    assert 1 <= stand.panels - panels <= 5
    time.sleep(0.1)
    stand.frame, stand.watched, told = stand.another(), 1, time.monotonic()
    before = len(stand.shown)
    stand.drawing.welcome()
    until(lambda: len(stand.shown) > before, 5)
    assert stand.shown[before] - told < 0.2


@pytest.mark.parametrize("stand", [{"fastest": 0.1}], indirect=True)
def test_no_more_pictures_than_are_allowed(stand):
    before, began = len(stand.shown), time.monotonic()
    while time.monotonic() < began + 1.5:
        stand.frame = stand.another()
        stand.news.set()
        time.sleep(0.005)
    assert 8 <= len(stand.shown) - before <= 17


@pytest.mark.parametrize("stand", [{"panels": 30.0}], indirect=True)
def test_panels_show_at_once_what_has_been_pressed(stand):
    before = stand.panels
    for _ in range(20):
        stand.frame = stand.another()
        stand.news.set()
        time.sleep(0.01)
    assert stand.panels == before
    stand.state = 1
    stand.news.set()
    until(lambda: stand.panels == before + 1, 1)


@pytest.mark.parametrize("stand", [{"share": 0.1}], indirect=True)
def test_a_thread_that_draws_what_is_dear_keeps_to_its_share(stand):
    def work(_frame, _look) -> None:
        end = time.thread_time() + 0.05
        while time.thread_time() < end:
            pass
        stand.shown.append(time.monotonic())

    stand.show = work
    time.sleep(0.6)
    clock = time.pthread_getcpuclockid(stand.drawing.thread.ident)
    began, worked = time.monotonic(), time.clock_gettime(clock)
    while time.monotonic() < began + 2.0:
        stand.frame = stand.another()
        stand.news.set()
        time.sleep(0.005)
    assert 0.03 < (time.clock_gettime(clock) - worked) / (time.monotonic() - began) < 0.15


def test_a_class_has_a_bandwidth_of_its_own():
    assert period(300, 1, bandwidth=42_000.0) == pytest.approx(0.2)
    assert period(300, 1, bandwidth=1.0) == 0.25
    assert period(300, 1, fastest=1 / 15) == pytest.approx(1 / 15)


@pytest.mark.parametrize("length", [2.0, 0.3, 0.04, 0.003])
def test_places_are_off_by_less_than_can_be_seen(length):
    at = np.random.default_rng(1).uniform(-5.0, 5.0, (500, 3))
    off = np.abs(places(at, length) - at).max()
    assert off <= 0.5 * min(FINE, OF_LENGTH * length) + 1e-6
    assert off > 0.1 * min(FINE, 0.5 * OF_LENGTH * length)


def test_attitudes_are_off_by_less_than_can_be_seen_and_level_ones_are_few():
    generator = np.random.default_rng(2)
    angle = generator.uniform(-np.pi, np.pi, 5000)
    exact = attitude(np.column_stack([np.cos(angle), np.sin(angle)]))
    sent = turned(exact)
    apart = 2.0 * np.arccos(np.clip(np.abs((sent * exact).sum(axis=1)), 0.0, 1.0))
    assert apart.max() <= np.pi / ROUND + 1e-3
    assert len(np.unique(sent, axis=0)) <= 2 * ROUND
    assert np.linalg.norm(sent, axis=1) == pytest.approx(1.0, abs=1e-6)
    heading = generator.normal(size=(500, 3))
    exact = attitude(heading / np.linalg.norm(heading, axis=1, keepdims=True))
    assert np.abs(turned(exact) - exact).max() <= 2.0**-12 + 1e-7
