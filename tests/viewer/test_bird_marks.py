"""What birds leave behind: the wake of their tips, and marks where they crashed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from agents.state.agent_rows import Crashes
from app.viewer.scene.draw.agent_meshes import TIP
from app.viewer.scene.draw.agent_shapes import BIRD
from app.viewer.scene.marks.agents import FlockMotion
from app.viewer.scene.marks.flock_marks import FADES, MOST_CRASHES, CrashMarks
from app.viewer.scene.marks.trails import Wake
from app.viewer.scene.shown.drawing_style import DrawingStyle
from tests.viewer.sky import Clock, frame, heading, shown
from tests.viewer.test_scene_worlds import Stand, draw


def test_the_wake_is_where_the_tips_have_been():
    scene = Stand()
    flight = FlockMotion(Clock())
    wake = Wake(scene, "", flight)
    look = DrawingStyle(wake=True, trail_length=16)
    for tick in range(12):
        one = frame([heading(0.0)], tick, position=np.array([[5.0 + 0.1 * tick, 6.0, 7.0]]))
        made = shown(one, look)
        flight.follow(made)
        draw(wake, made)
    lines = np.concatenate(
        [node.points for node in scene.sent if node.name.startswith("/flock/wake") and node.visible]
    )
    aside = TIP * BIRD.scale * made.length
    across = np.unique(np.round(lines[:, :, 1] - made.at[0, 1], 5))
    assert across == pytest.approx([-aside, aside], abs=1e-4)
    assert np.unique(np.round(lines[:, :, 2], 5)) == pytest.approx([made.at[0, 2]], abs=1e-4)
    down = replace(one, tick=12, active=np.array([False]))
    made = shown(down, look)
    flight.follow(made)
    draw(wake, made)
    assert not scene.there("/flock/wake/tip").visible
    draw(wake, shown(down, DrawingStyle()))
    assert not any(node.visible for node in scene.sent)


def crashed(places: np.ndarray, ticks: list[int]) -> Crashes:
    count = np.arange(len(ticks))
    return Crashes(np.array(ticks), count + 1, count, places, np.ones(len(ticks), int))


def test_a_mark_stands_where_it_crashed_and_fades():
    scene = Stand()
    marks = CrashMarks(scene)
    place = np.array([[4.0, 5.0, 12.0]])
    greens = []
    for tick in (0, FADES // 2, FADES, 10 * FADES):
        one = frame([heading(0.0)], tick, crashes=crashed(place, [0]))
        made = shown(one)
        draw(marks, made)
        node = scene.there("/flock/crashes")
        at = made.stage.to_display(place)[0]
        level = node.points[np.ptp(node.points[..., 2], axis=1) == 0.0]
        assert level[..., 2] == pytest.approx(at[2], abs=1e-5)
        assert level.reshape(-1, 3).mean(axis=0) == pytest.approx(at, abs=1e-5)
        drops = len(node.points) - len(level)
        assert drops == (1 if tick < FADES else 0)
        greens.append(int(node.colors[0, 0, 1]))
    assert greens[0] < greens[1] < greens[2] == greens[3] < 255
    draw(marks, shown(frame([heading(0.0)])))
    assert not scene.there("/flock/crashes").visible


def test_of_very_many_crashes_the_latest_are_marked():
    scene = Stand()
    marks = CrashMarks(scene)
    places = np.random.default_rng(1).random((3 * MOST_CRASHES, 3)) * 20.0
    one = frame([heading(0.0)], 10_000, crashes=crashed(places, list(range(3 * MOST_CRASHES))))
    draw(marks, shown(one))
    drawn = scene.there("/flock/crashes").points.reshape(MOST_CRASHES, -1, 3).mean(axis=1)
    assert drawn == pytest.approx(shown(one).stage.to_display(places[-MOST_CRASHES:]), abs=1e-5)
