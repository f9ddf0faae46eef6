"""What is shown between two ticks: on the shortest way, and then the tick itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.viewer.scene.shown.frame import Frame
from app.viewer.scene.shown.frame_interpolator import (
    PICTURES,
    SLOW,
    STEP,
    FrameInterpolator,
    interpolate,
)
from worlds.world import World

SIDE = 10.0
ROOM = World("room", (SIDE, SIDE), ("wrap", "wrap"))


def frame(tick: int, place: list[list[float]], angle: float = 0.0, **more) -> Frame:
    position = np.array(place, float)
    count = len(position)
    return Frame(
        run=1,
        tick=tick,
        world=ROOM,
        reach=1.0,
        speed_scale=1.0,
        position=position,
        heading=np.tile([np.cos(angle), np.sin(angle)], (count, 1)),
        speed=np.ones(count),
        informed=np.zeros(count, bool),
        ids=np.arange(count),
        **more,
    )


def test_agents_are_halfway_at_half_the_time_and_then_the_frame_itself_is_shown():
    between = FrameInterpolator()
    one, two = frame(0, [[1.0, 1.0]]), frame(1, [[2.0, 3.0]], np.pi / 2)
    assert between.frame(one, True, 1.0, 10.0) is one
    shown = between.frame(two, True, 1.0, 11.0)
    np.testing.assert_allclose(shown.position, [[1.0 + 1 / PICTURES, 1.0 + 2 / PICTURES]])
    shown = between.frame(two, True, 1.0, 11.0 + 0.475)
    np.testing.assert_allclose(shown.position, [[1.5, 2.0]])
    np.testing.assert_allclose(shown.heading, [[np.sqrt(0.5), np.sqrt(0.5)]])
    assert between.frame(two, True, 1.0, 11.48) is shown
    assert between.frame(two, True, 1.0, 12.0) is two


def test_across_the_edge_the_way_is_the_shortest():
    shown = interpolate(frame(0, [[9.8, 5.0]]), frame(1, [[0.2, 5.0]]), 0.75)
    np.testing.assert_allclose(shown.position, [[0.1, 5.0]])
    np.testing.assert_allclose(
        interpolate(frame(0, [[9.8, 5.0]]), frame(1, [[0.2, 5.0]]), 0.25).position, [[9.9, 5.0]]
    )


def test_who_turns_back_turns_at_once():
    shown = interpolate(frame(0, [[1.0, 1.0]]), frame(1, [[1.0, 1.0]], np.pi), 0.5)
    np.testing.assert_allclose(shown.heading, [[-1.0, 0.0]], atol=1e-9)


@given(
    st.lists(st.floats(0, 9.99), min_size=4, max_size=4),
    st.floats(0, 2 * np.pi),
    st.floats(0.0, 1.0),
)
def test_places_stay_in_the_world_and_headings_stay_units(numbers, angle, share):
    a, b = frame(0, [numbers[:2]]), frame(1, [numbers[2:]], angle)
    shown = interpolate(a, b, share)
    assert np.all((shown.position >= 0.0) & (shown.position <= SIDE))
    np.testing.assert_allclose(np.linalg.norm(shown.heading, axis=1), 1.0)


@pytest.mark.parametrize(
    ("later", "running", "speed"),
    [
        (frame(1, [[2.0, 3.0]]), True, 2.0 * SLOW),
        (frame(2, [[2.0, 3.0]]), True, 1.0),
        (replace(frame(1, [[2.0, 3.0]]), run=2), True, 1.0),
        (frame(1, [[2.0, 3.0], [1.0, 1.0]]), True, 1.0),
    ],
)
def test_what_is_not_the_next_tick_of_a_slow_run_is_shown_at_once(later, running, speed):
    between = FrameInterpolator()
    between.frame(frame(0, [[1.0, 1.0]]), running, speed, 0.0)
    assert between.frame(later, running, speed, 0.01) is later


def test_a_step_takes_a_moment_though_the_run_is_paused():
    between = FrameInterpolator()
    two = frame(1, [[2.0, 3.0]])
    between.frame(frame(0, [[1.0, 1.0]]), False, 1.0, 0.0)
    assert between.frame(two, False, 1.0, 0.5 * STEP) is not two
    assert between.frame(two, False, 1.0, 1.6 * STEP) is two


def test_two_flocks_go_together():
    one = frame(0, [[1.0, 1.0]], beside=frame(0, [[4.0, 4.0]]))
    two = frame(1, [[2.0, 1.0]], beside=frame(1, [[4.0, 5.0]]))
    shown = interpolate(one, two, 0.5)
    np.testing.assert_allclose(shown.beside.position, [[4.0, 4.5]])
