"""Birds in space: their meshes, their sizes, how the crashed lie, and what of it is sent."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents import Flock
from app.viewer.run.frame_builder import FrameBuilder
from app.viewer.scene.draw.agent_meshes import SHOULDER, TIP, body, wing_scales, wings
from app.viewer.scene.draw.agent_shapes import BIRD, MOTION
from app.viewer.scene.draw.attitude import (
    OF_LENGTH,
    attitude,
    left_directions,
    nose,
    roll_attitudes,
    up_directions,
)
from app.viewer.scene.draw.drawn_frame import KEPT, POINTS_BEYOND
from app.viewer.scene.drawing import AGENT_BYTES, ANIMAL_BYTES, POINT_BYTES, load
from app.viewer.scene.marks.agents import FlockMotion
from app.viewer.scene.scene import Parts
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.drawing_style import ANIMALS_UP_TO, AS_MODEL, DrawingStyle
from tests.viewer.sky import STEP, Clock, frame, heading, shown
from tests.viewer.test_scene_geometry import rotated
from tests.viewer.test_scene_worlds import Stand
from worlds.world import World


def test_the_meshes_are_as_alike_on_the_left_as_on_the_right():
    for vertices, faces in (body(), wings()):
        mirrored = vertices * np.array([1.0, -1.0, 1.0])
        assert {tuple(np.round(v, 9)) for v in vertices} == {
            tuple(np.round(v, 9)) for v in mirrored
        }
        assert faces.max() == len(vertices) - 1
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        assert np.all(np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-6)
    assert np.ptp(body()[0][:, 0]) == pytest.approx(1.08)
    assert np.abs(wings()[0][:, 1]).max() == TIP


@given(st.floats(-1.2, 1.2))
def test_a_scale_turns_both_wings_up_by_the_angle(angle):
    scale = wing_scales(np.array([angle]))[0]
    for side in (1.0, -1.0):
        tip = np.array([-0.13, side * TIP, TIP]) * scale
        expected = np.array([-0.13, side * TIP * np.cos(angle), TIP * np.sin(angle)])
        assert tip == pytest.approx(expected)
        assert np.linalg.norm(tip[1:]) == pytest.approx(TIP)


@given(st.integers(0, 2**32 - 1))
def test_a_roll_keeps_the_nose_and_turns_the_wings(seed):
    rng = np.random.default_rng(seed)
    ahead = rng.standard_normal((1, 3))
    ahead /= np.linalg.norm(ahead)
    roll = rng.uniform(-1.5, 1.5, 1)
    plain = attitude(ahead)
    made = roll_attitudes(plain, roll)
    assert nose(made[0]) == pytest.approx(ahead[0], abs=1e-6)
    left, over = (rotated(plain[0], np.eye(3)[k]) for k in (1, 2))
    expected = np.cos(roll[0]) * left + np.sin(roll[0]) * over
    assert rotated(made[0], np.array([0.0, 1.0, 0.0])) == pytest.approx(expected, abs=1e-6)
    assert left_directions(made)[0] == pytest.approx(expected, abs=1e-5)
    assert up_directions(made)[0] == pytest.approx(np.cross(ahead[0], expected), abs=1e-5)


def test_the_crashed_fall_nose_down_and_lie_flat_in_a_colour_of_their_own():
    clock = Clock()
    flight = FlockMotion(clock)
    ahead = [heading(0.5, 0.7)] * 3
    flight.follow(shown(frame(ahead)))
    clock.now += STEP
    one = frame(ahead, 1, active=np.array([True, False, False]), speed=np.array([3.0, 4.0, 0.0]))
    made = shown(one)
    poses = flight.follow(made)
    assert nose(poses.wxyz[0])[2] == pytest.approx(np.sin(0.7), abs=1e-5)
    assert nose(poses.wxyz[1])[2] < -0.8
    assert up_directions(poses.wxyz)[2] == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)
    assert poses.beat[1:] == pytest.approx([MOTION.folded, MOTION.flat])
    assert made.colour[1:] == pytest.approx(np.tile(palette.CRASHED, (2, 1)))
    assert nose(made.wxyz[2])[2] == pytest.approx(0.0, abs=1e-6)
    lifted = made.at[:, 2] - made.stage.to_display(one.position)[:, 2]
    assert lifted[0] == 0.0
    assert np.all(lifted[1:] > 0.0)


@pytest.mark.parametrize(
    ("count", "dim", "form", "chosen", "kind"),
    [
        (40, 3, "birds", AS_MODEL, "birds"),
        (40, 3, "birds", "darts", "darts"),
        (40, 2, "birds", AS_MODEL, "darts"),
        (40, 3, "fish", AS_MODEL, "fish"),
        (40, 2, "fish", AS_MODEL, "fish"),
        (40, 3, "fish", "birds", "birds"),
        (40, 2, "birds", "fish", "fish"),
        (ANIMALS_UP_TO + 1, 3, "birds", AS_MODEL, "darts"),
        (ANIMALS_UP_TO + 1, 2, "fish", AS_MODEL, "darts"),
        (POINTS_BEYOND + 1, 3, "birds", AS_MODEL, "points"),
        (0, 3, "birds", AS_MODEL, "nobody"),
    ],
)
def test_a_flock_is_what_its_model_is_about_or_what_is_chosen(count, dim, form, chosen, kind):
    scene = Stand()
    parts = Parts(scene)
    rng = np.random.default_rng(count)
    turn = rng.standard_normal((count, dim))
    one = frame(
        [],
        heading=turn / np.linalg.norm(turn, axis=1)[:, None],
        position=rng.random((count, dim)) * 20.0,
        speed=np.ones(count),
        informed=np.zeros(count, bool),
        ids=np.arange(count),
        world=World("sky", (20.0,) * dim, ("wrap",) * dim),
        form=form,
    )
    look = DrawingStyle(form=chosen)
    made = shown(one, look)
    for node, name, value in parts.draw_flock(made):
        setattr(node, name, value)
    seen = {
        name
        for name, node in (
            ("birds", "/flock/birds/wings"),
            ("birds", "/flock/birds/bodies"),
            ("fish", "/flock/fish/trunks"),
            ("fish", "/flock/fish/tails"),
            ("darts", "/flock/darts"),
            ("points", "/flock/points"),
        )
        if scene.there(node).visible
    }
    assert seen == ({kind} if kind != "nobody" else set())
    sent = {"birds": ANIMAL_BYTES, "fish": ANIMAL_BYTES, "points": POINT_BYTES}
    sent = sent.get(kind, AGENT_BYTES)
    assert load(one, look) == pytest.approx(count * sent / AGENT_BYTES)


def test_wings_are_at_the_shoulders_of_their_bodies():
    scene = Stand()
    parts = Parts(scene)
    one = frame([heading(0.3, 0.2), heading(2.0)])
    made = shown(one)
    for node, name, value in parts.draw_flock(made):
        setattr(node, name, value)
    bodies, both = scene.there("/flock/birds/bodies"), scene.there("/flock/birds/wings")
    size = BIRD.scale * made.length
    over = both.batched_positions - bodies.batched_positions
    assert np.linalg.norm(over, axis=1) == pytest.approx(
        SHOULDER * size, abs=2.0 * OF_LENGTH * made.length
    )
    assert both.batched_scales[:, 0] == pytest.approx(size)
    assert np.hypot(*both.batched_scales.T[1:]) == pytest.approx(size)
    sent = [bodies.batched_positions, bodies.batched_wxyzs, bodies.batched_colors]
    sent += [both.batched_positions, both.batched_wxyzs, both.batched_colors]
    assert sum(part.nbytes for part in [*sent, both.batched_scales]) == 2 * ANIMAL_BYTES


def test_birds_are_no_longer_than_the_distance_they_keep_nor_half_their_length():
    flat = World("plain", (20.0, 20.0), ("wrap", "wrap"))
    ahead = [heading(0.0)] * 50
    common = shown(frame(ahead)).length
    scale = shown(frame(ahead)).stage.scale
    kept = 0.8 * common / scale / KEPT
    assert shown(frame(ahead, kept=kept)).length == pytest.approx(0.8 * common)
    assert shown(frame(ahead, kept=0.01)).length == pytest.approx(0.5 * common)
    assert shown(frame(ahead, kept=99.0)).length == common
    level = {"world": flat, "heading": np.tile([1.0, 0.0], (50, 1)), "position": np.ones((50, 2))}
    assert shown(frame(ahead, **level, kept=0.01)).length == shown(frame(ahead, **level)).length


def test_a_frame_holds_who_flies_what_is_saved_and_the_distance_kept():
    flock = Flock("thesis", agents=12, rng=1)
    flock.arrays.crash_record[3] = (0.0, 1.0, *flock.position[3])
    flock.speed[3] = 1e3
    taken = FrameBuilder(flock, 1).build()
    assert np.flatnonzero(taken.is_down).tolist() == [3]
    assert taken.crashes.row.tolist() == [3]
    assert taken.speed_scale == np.delete(flock.speed, 3).max()
    assert np.isnan(taken.saved).all()
    assert taken.kept == flock.parameters.d_r
    plain = FrameBuilder(Flock("vem", agents=3, dim=3, rng=1), 1).build()
    assert (plain.active, plain.crashes, plain.saved, plain.kept) == (None, None, None, np.inf)
