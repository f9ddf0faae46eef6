"""The bands that cars leave behind, flat or rising in time."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.models.declare import Vehicle
from app.viewer.scene.draw.drawn_frame import Picture
from app.viewer.scene.marks.ribbons import INJECTED, LAID, RISE, Ribbons, heights, ribbon_agents
from app.viewer.scene.marks.trails import TrailHistory, thin_knots
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.drawing_style import TRAILS, DrawingStyle, trail_turns
from app.viewer.scene.shown.frame import MissionProgress
from tests.viewer.fleet import AREA, frame, known, node, shown
from tests.viewer.test_scene_worlds import Stand, draw
from worlds.world import World


def band(trails: str, ticks: range, length: int = 40, **changes: Any) -> tuple[Any, Any, Picture]:
    """What is drawn behind a car along +x, 0.01 a tick, after these ticks."""
    scene = Stand()
    part = Ribbons(scene)
    for tick in ticks:
        one = frame(
            tick,
            **{
                "position": np.array([[-2.0 + 0.01 * tick, 0.0]]),
                "heading": np.array([[1.0, 0.0]]),
                "speed": np.ones(1),
                "informed": np.zeros(1, bool),
                "ids": np.array([1]),
                "cars": known(1),
                "progress": MissionProgress(),
                "world": AREA,
            }
            | changes,
        )
        last = shown(one, DrawingStyle(trails=trails, trail_length=length))
        draw(part, last)
    return node(scene, "/pieces"), node(scene, "/plumb"), last


def test_a_flat_ribbon_lies_where_the_car_has_been():
    pieces, plumb, last = band("ribbon", range(101))
    assert pieces.visible
    assert not plumb.visible
    at = pieces.batched_positions
    assert at[:, 2] == pytest.approx(LAID)
    assert at[:, 0].min() >= 1.25 * (-2.0 + 0.01 * 60) - 1e-5
    assert at[:, 0].max() <= 1.25 * (-2.0 + 0.01 * 100) + 1e-5
    assert np.sum(np.diff(np.sort(at[:, 0]))) == pytest.approx(1.25 * 0.39, rel=0.02)
    assert np.all(pieces.batched_scales[:, 1] < last.length * Vehicle().width / Vehicle().length)


def test_a_band_that_rises_does_so_with_time_up_to_the_present_above_the_car():
    for ticks, height in ((range(21), 0.5), (range(101), 1.0)):
        pieces, plumb, last = band("rising in time", ticks)
        order = np.argsort(pieces.batched_positions[:, 0])
        along, up = pieces.batched_positions[order][:, [0, 2]].T
        assert np.all(np.diff(up) > 0.0)
        slope = np.diff(up) / np.diff(along)
        assert slope == pytest.approx(RISE * 10.0 / 40 / (0.01 * 1.25), rel=1e-3)
        ((top, foot),) = plumb.points
        assert top == pytest.approx([*last.at[0, :2], height * RISE * 10.0 + LAID], rel=1e-5)
        assert foot == pytest.approx([*last.at[0, :2], 0.0])


def test_bands_break_at_the_seam_and_are_forgotten():
    seam = World("wrap", (6.0, 8.0), ("wrap", "wrap"))
    scene = Stand()
    part = Ribbons(scene)
    for tick, x in enumerate([5.7, 5.8, 5.9, 0.0, 0.1]):
        place = np.array([[x, 0.0]] * 3)
        one = frame(tick, world=seam, position=place, progress=MissionProgress(), cars=None)
        draw(part, shown(one, DrawingStyle(trails="ribbon", trail_length=16)))
    pieces = node(scene, "/pieces")
    assert len(pieces.batched_positions) == 3 * 3
    draw(part, shown(one, DrawingStyle(trails="line", trail_length=16)))
    assert not pieces.visible
    draw(part, shown(replace(one, tick=9), DrawingStyle(trails="ribbon", trail_length=16)))
    assert not pieces.visible


def test_where_cars_have_been_is_there_as_soon_as_somebody_asks():
    scene = Stand()
    part = Ribbons(scene)
    for tick in range(0, 4001, 10):
        angle = 2.0 * np.pi * tick / 1140
        at = np.array([[np.cos(angle), np.sin(angle)]])
        one = frame(
            tick, position=at, heading=at, speed=np.ones(1), informed=np.zeros(1, bool),
            ids=np.array([1]), cars=known(1), progress=MissionProgress(),
        )  # fmt: skip
        draw(part, shown(one))
    pieces = node(scene, "/pieces")
    assert not pieces.visible
    draw(part, shown(one, DrawingStyle(trails="rising in time", trail_length=trail_turns(one.dt))))
    assert pieces.visible
    x, y, up = pieces.batched_positions.T
    around = np.unwrap(np.arctan2(y, x)[np.argsort(up)])
    assert around[-1] - around[0] == pytest.approx(2.0 * np.pi * 4000 / 1140, rel=0.02)
    assert up.max() == pytest.approx(RISE * 10.0, rel=0.02)
    draw(part, shown(replace(one, tick=4001), DrawingStyle(trails="ribbon", trail_length=100)))
    assert pieces.visible
    assert len(pieces.batched_positions) < 20


def test_where_other_agents_have_been_is_not_kept_for_nothing():
    scene = Stand()
    part = Ribbons(scene)
    for tick in range(20):
        draw(part, shown(frame(tick, cars=None)))
    draw(part, shown(frame(20, cars=None), DrawingStyle(trails="ribbon")))
    assert not node(scene, "/pieces").visible


@given(st.integers(1, 60), st.integers(50, 3000), st.integers(4, 240))
def test_what_is_thinned_is_enough_and_keeps_what_it_has_shown(apart, length, knots):
    ticks = np.arange(0, 4000, apart)
    kept = thin_knots(ticks, 4000, length, knots)
    step = max(1, length // knots)
    assert len(kept) <= length // step + 2
    assert np.all(ticks[kept] >= 4000 - length)
    assert np.all(np.diff(ticks[kept]) <= step + apart)
    more = np.append(ticks, 4000 + apart)
    later = more[thin_knots(more, 4000 + apart, length, knots)]
    still = ticks[kept][ticks[kept] >= 4000 + apart - length][1:]
    assert set(still.tolist()) <= set(later.tolist())


def test_the_injected_car_leaves_a_band_too():
    ids, here, colour = ribbon_agents(shown(frame()))
    assert ids.tolist() == [1, 2, 3, INJECTED]
    assert here[-1] == pytest.approx([2.5, 0.0, 0.0])
    assert colour[-1] == pytest.approx(palette.GOAL)
    assert len(ribbon_agents(shown(frame(), DrawingStyle(mission=False)))[0]) == 3
    assert len(ribbon_agents(shown(frame(cars=None)))[0]) == 3


@given(st.integers(0, 500), st.integers(0, 500), st.integers(1, 300))
def test_heights_go_from_the_oldest_shown_to_the_present(began, lasted, length):
    now = began + lasted
    first = max(began, now - length)
    up = heights(np.arange(first, now + 1), began, now, length)
    assert up[0] == 0.0
    assert up[-1] == pytest.approx(min(lasted, length) / length)
    assert np.all(np.diff(up) > 0.0)


def test_the_past_keeps_no_more_than_it_is_asked_for():
    past = TrailHistory()
    for tick in range(100):
        here = np.array([[float(tick), 0.0, 0.0]])
        changed = past.remember(frame(tick), np.array([7]), here, length=40, knots=10)
        assert changed is (tick % 4 == 0)
    assert past.ticks == list(range(56, 97, 4))
    assert [knot[0, 0] for knot in past.knots] == past.ticks
    assert past.began == 0


def test_a_look_refuses_a_trail_that_nobody_knows():
    with pytest.raises(ValueError, match="trails = 'smoke' is not one of off, line, ribbon"):
        DrawingStyle(trails="smoke")
    assert [DrawingStyle(trails=one).trails for one in TRAILS] == list(TRAILS)
