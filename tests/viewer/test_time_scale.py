"""The axis beside what rises with time: its marks are where the bands were then."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import viser
from hypothesis import given
from hypothesis import strategies as st

from app.viewer.scene.cameras.viewpoints import Sight, Viewpoints
from app.viewer.scene.draw.drawn_frame import Picture
from app.viewer.scene.marks.ribbons import MOST, RISE, Ribbons, age_marks, heights, present_height
from app.viewer.scene.shown.drawing_style import DrawingStyle
from tests.viewer.fleet import frame, shown
from tests.viewer.live_fleet import live_frame
from tests.viewer.test_scene_worlds import Stand, draw

LENGTH = 60


def drawn(ticks: range, trails: str = "rising in time", **changes: Any) -> tuple[Stand, Picture]:
    scene = Stand()
    part = Ribbons(scene)
    for tick in ticks:
        made = shown(frame(tick, **changes), DrawingStyle(trails=trails, trail_length=LENGTH))
        draw(part, made)
    return scene, made


def scale(scene: Stand) -> dict[str, float]:
    """Words and the heights that they are at."""
    nodes = [one for one in scene.sent if "/scale/words/" in one.name and one.visible]
    return {one.text: float(one.position[2]) for one in nodes}


@pytest.mark.parametrize("last", [25, 60, 200])
def test_marks_are_at_the_heights_of_their_ticks(last):
    scene, made = drawn(range(last + 1))
    found = scale(scene)
    expected = {"now": 0, "−0.2 s": 20, "−0.4 s": 40, "−0.6 s": 60}
    for words, ago in expected.items():
        if ago > last:
            assert words not in found
            continue
        (up,) = heights(np.array([last - ago]), 0, last, LENGTH)
        assert found.pop(words) == pytest.approx(up * RISE * made.stage.side)
    assert not found
    (lines,) = [one for one in scene.sent if one.name.endswith("/scale/lines")]
    (foot, top), *across = lines.points
    assert (foot[2], top[2]) == pytest.approx((0.0, min(last / LENGTH, 1.0) * RISE * 10.0))
    assert foot[:2] == pytest.approx([-3.75, 5.0])
    assert len(across) == len(scale(scene))


def test_ticks_are_its_unit_where_there_are_no_seconds():
    scene, _ = drawn(range(70), dt=1.0, unit="ticks", cars=None)
    assert list(scale(scene)) == ["now", "−20 ticks", "−40 ticks", "−60 ticks"]


def test_a_room_with_real_cars_has_it_too():
    scene = Stand()
    part = Ribbons(scene)
    for tick in range(70):
        draw(
            part,
            shown(live_frame(tick), DrawingStyle(trails="rising in time", trail_length=LENGTH)),
        )
    assert "−0.6 s" in scale(scene)


def test_it_is_hidden_where_nothing_rises_and_still_once_it_is_full():
    scene, made = drawn(range(80), "ribbon")
    assert scale(scene) == {}
    assert present_height(made) == 0.0
    scene = Stand()
    part = Ribbons(scene)
    look = DrawingStyle(trails="rising in time", trail_length=LENGTH)
    for tick in range(80):
        draw(part, shown(frame(tick), look))
    assert not [one for one, *_ in part.draw(shown(frame(80), look)) if "/scale/" in one.name]
    draw(part, shown(frame(81), replace(look, trails="off")))
    assert scale(scene) == {}
    draw(part, shown(frame(82), look))
    assert list(scale(scene)) == ["now", "−0.2 s", "−0.4 s", "−0.6 s"]


@given(st.floats(0.01, 1e5))
def test_marks_are_round_and_few(span):
    ages = age_marks(span)
    assert ages[0] == 0.0
    assert 2 <= len(ages) <= MOST
    assert ages[-1] <= span * (1.0 + 1e-6)
    assert float(f"{ages[1]:.1g}") == pytest.approx(ages[1])


class Browser:
    """Stands for a browser with a camera of its own."""

    client_id = 7

    def __init__(self) -> None:
        self.camera = SimpleNamespace(image_width=1440, image_height=900, _state=None)

    def atomic(self) -> nullcontext[None]:
        return nullcontext()


@pytest.mark.parametrize(
    ("name", "farther"), [("perspective", True), ("side", True), ("top-down", False)]
)
def test_a_camera_from_the_side_has_what_rises_in_view(name, farther):
    server = viser.ViserServer(host="localhost", port=0, verbose=False)
    try:
        viewpoints, away = Viewpoints(server), []
        for trails in ("off", "rising in time"):
            viewpoints.update((Sight(shown(frame(), DrawingStyle(trails=trails)), np.zeros(3)),))
            browser = Browser()
            viewpoints.place(browser, name)
            away.append(np.linalg.norm(browser.camera.position))
    finally:
        server.stop()
    assert bool(away[1] > 1.05 * away[0]) is farther
