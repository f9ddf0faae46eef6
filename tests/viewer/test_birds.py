"""Birds in space: their meshes, how they bank, beat and lie, and what of it is sent."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents import Flock
from agents.crashes import Crashes
from app.viewer.drawing import AGENT_BYTES, BIRD_BYTES, load
from app.viewer.frame import Frame
from app.viewer.picture import Camera
from app.viewer.scene import Look, palette
from app.viewer.scene.attitude import attitude, nose, rolled
from app.viewer.scene.bird import SHOULDER, TIP, beaten, body, wings
from app.viewer.scene.birds import SCALE, leftwards, upwards
from app.viewer.scene.crashes import FADES, MOST, CrashMarks
from app.viewer.scene.flight import (
    AMPLITUDE,
    DIHEDRAL,
    FLAT,
    FOLDED,
    GLIDING,
    LONGEST_BEAT,
    NIMBLE,
    STEEPEST,
    Flight,
    turned,
)
from app.viewer.scene.parts import Parts
from app.viewer.scene.picture import BIRDS_UP_TO, KEPT, POINTS_BEYOND, Picture, picture
from app.viewer.scene.stage import Stage
from app.viewer.scene.wake import Wake
from tests.viewer.test_scene_geometry import rotated
from tests.viewer.test_scene_worlds import Stand, draw
from worlds.world import World

SKY = World("sky", (20.0,) * 3, ("wrap",) * 3)
STEP = 1 / 40


class Clock:
    """Time as a test wants it."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def heading(azimuth: float, elevation: float = 0.0) -> np.ndarray:
    level = np.cos(elevation)
    return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])


def frame(headings: list[np.ndarray], tick: int = 0, **changes) -> Frame:
    count = len(headings)
    known = {
        "run": 1,
        "tick": tick,
        "world": SKY,
        "reach": 8.0,
        "speed_scale": 3.0,
        "position": 10.0 + np.arange(3.0 * count).reshape(count, 3) / (3.0 * count + 1.0),
        "heading": np.array(headings).reshape(-1, 3),
        "speed": np.full(count, 3.0),
        "informed": np.zeros(count, dtype=bool),
        "ids": np.arange(1, count + 1),
        "dt": 0.1,
        "unit": "s",
    }
    return Frame(**(known | changes))


def shown(one: Frame, look: Look | None = None) -> Picture:
    return picture(one, look or Look(), Stage.of(one))


def circling(flight: Flight, clock: Clock, rate: float, frames: int = 400, speed: float = 3.0):
    """The poses of a bird that has turned left at `rate` rad/s for long."""
    for tick in range(frames):
        clock.now += STEP
        one = frame([heading(0.1 * rate * tick)], tick, speed=np.array([speed]))
        poses = flight.follow(shown(one))
    return one, poses


def bank(wxyz: np.ndarray) -> float:
    """How far the right wing is down, rad, of a bird that flies level: an oracle by vectors."""
    left = rotated(wxyz, np.array([0.0, 1.0, 0.0]))
    over = rotated(wxyz, np.array([0.0, 0.0, 1.0]))
    return float(np.arctan2(left[2], over[2]))


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
    scale = beaten(np.array([angle]))[0]
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
    made = rolled(plain, roll)
    assert nose(made[0]) == pytest.approx(ahead[0], abs=1e-6)
    left, over = (rotated(plain[0], np.eye(3)[k]) for k in (1, 2))
    expected = np.cos(roll[0]) * left + np.sin(roll[0]) * over
    assert rotated(made[0], np.array([0.0, 1.0, 0.0])) == pytest.approx(expected, abs=1e-6)
    assert leftwards(made)[0] == pytest.approx(expected, abs=1e-5)
    assert upwards(made)[0] == pytest.approx(np.cross(ahead[0], expected), abs=1e-5)


def test_turning_left_is_above_nought_and_at_most_a_right_angle():
    before = np.array([heading(0.0), heading(1.0), heading(3.0), heading(0.0, 0.5 * np.pi)])
    after = np.array([heading(0.2), heading(0.7), heading(3.0 + np.pi), heading(0.0)])
    assert turned(before, after) == pytest.approx([0.2, -0.3, 0.0, 0.0], abs=1e-9)


@pytest.mark.parametrize("rate", [-1.0, -0.3, 0.3, 1.0])
def test_a_bird_banks_into_its_turn_by_speed_times_turning_over_gravity(rate):
    clock = Clock()
    one, poses = circling(Flight(clock), clock, rate)
    pull = one.speed_scale**2 / (NIMBLE * one.reach)
    angle = np.arctan(3.0 * np.arcsin(np.sin(0.1 * rate)) / 0.1 / pull)
    assert bank(poses.wxyz[0]) == pytest.approx(-angle, abs=2e-3)
    assert nose(poses.wxyz[0]) == pytest.approx(one.heading[0], abs=1e-5)


def test_no_bird_banks_further_than_the_steepest_or_at_rest():
    clock = Clock()
    _, poses = circling(Flight(clock), clock, 12.0)
    assert bank(poses.wxyz[0]) == pytest.approx(-STEEPEST, abs=1e-5)
    _, poses = circling(Flight(clock), clock, 12.0, speed=0.0)
    assert bank(poses.wxyz[0]) == pytest.approx(0.0, abs=1e-6)


def test_a_bird_leans_over_little_by_little():
    clock = Clock()
    flight = Flight(clock)
    banks = []
    for tick in range(60):
        clock.now += STEP
        poses = flight.follow(shown(frame([heading(2.0 * (tick > 20))], tick)))
        banks.append(bank(poses.wxyz[0]))
    assert np.allclose(banks[:21], 0.0, atol=1e-6)
    steps = np.abs(np.diff(banks))
    assert steps[20] == steps.max()
    assert 0.05 < steps.max() < 0.2
    assert abs(banks[-1]) < 0.1


def test_wings_beat_while_ticks_pass_and_stand_still_while_paused():
    clock = Clock()
    flight = Flight(clock)
    ahead = [heading(0.0)] * 3
    beats = []
    for tick in range(80):
        clock.now += STEP
        beats.append(flight.follow(shown(frame(ahead, tick))).beat)
    beats = np.array(beats)
    assert np.all(np.ptp(beats, axis=0) > 1.6 * AMPLITUDE)
    assert np.all(np.abs(beats - DIHEDRAL) <= AMPLITUDE)
    assert np.abs(np.diff(beats, axis=0)).max() < 0.5
    assert not np.allclose(beats[:, 0], beats[:, 1])
    for _ in range(5):
        clock.now += 3.0
        assert np.array_equal(flight.follow(shown(frame(ahead, 79))).beat, beats[-1])
    clock.now += 3.0
    after = flight.follow(shown(frame(ahead, 80))).beat
    slow = Flight(clock)
    slow.follow(shown(frame(ahead, 0)))
    assert np.abs(after - beats[-1]).max() < AMPLITUDE * 2.0 * np.pi * 3.0 * LONGEST_BEAT


def test_a_diving_bird_glides():
    clock = Clock()
    flight = Flight(clock)
    beats = []
    for tick in range(160):
        clock.now += STEP
        beats.append(flight.follow(shown(frame([heading(0.0, -0.8)], tick))).beat[0])
    assert np.abs(np.array(beats) - DIHEDRAL).max() <= GLIDING * AMPLITUDE + 1e-9


def test_rows_that_come_and_go_leave_the_others_as_they_were():
    clock = Clock()
    flight = Flight(clock)
    for tick in range(100):
        clock.now += STEP
        ahead = [heading(0.1 * tick), heading(-0.05 * tick), heading(1.0)]
        before = flight.follow(shown(frame(ahead, tick)))
    clock.now += STEP
    less = frame([ahead[2], ahead[0], heading(2.0)], 99, ids=np.array([3, 1, 9]))
    after = flight.follow(shown(less))
    for row, old in ((0, 2), (1, 0)):
        assert after.wxyz[row] == pytest.approx(before.wxyz[old], abs=1e-6)
        assert after.beat[row] == before.beat[old]
    assert bank(after.wxyz[2]) == pytest.approx(0.0, abs=1e-6)


def test_a_new_run_begins_level():
    clock = Clock()
    flight = Flight(clock)
    circling(flight, clock, 1.0, frames=50)
    clock.now += STEP
    poses = flight.follow(shown(frame([heading(2.0)], 51, run=2)))
    assert bank(poses.wxyz[0]) == pytest.approx(0.0, abs=1e-6)


def test_the_crashed_fall_nose_down_and_lie_flat_in_a_colour_of_their_own():
    clock = Clock()
    flight = Flight(clock)
    ahead = [heading(0.5, 0.7)] * 3
    flight.follow(shown(frame(ahead)))
    clock.now += STEP
    one = frame(ahead, 1, flying=np.array([True, False, False]), speed=np.array([3.0, 4.0, 0.0]))
    made = shown(one)
    poses = flight.follow(made)
    assert nose(poses.wxyz[0])[2] == pytest.approx(np.sin(0.7), abs=1e-5)
    assert nose(poses.wxyz[1])[2] < -0.8
    assert upwards(poses.wxyz)[2] == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)
    assert poses.beat[1:] == pytest.approx([FOLDED, FLAT])
    assert made.colour[1:] == pytest.approx(np.tile(palette.CRASHED, (2, 1)))
    assert nose(made.wxyz[2])[2] == pytest.approx(0.0, abs=1e-6)
    lifted = made.at[:, 2] - made.stage.shown(one.position)[:, 2]
    assert lifted[0] == 0.0
    assert np.all(lifted[1:] > 0.0)


@pytest.mark.parametrize(
    ("count", "dim", "birds", "kind"),
    [
        (40, 3, True, "birds"),
        (40, 3, False, "darts"),
        (40, 2, True, "darts"),
        (BIRDS_UP_TO + 1, 3, True, "darts"),
        (POINTS_BEYOND + 1, 3, True, "points"),
        (0, 3, True, "nobody"),
    ],
)
def test_a_flock_is_birds_or_darts_or_points(count, dim, birds, kind):
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
    )
    made = shown(one, Look(birds=birds))
    for node, name, value in parts.draw_flock(made):
        setattr(node, name, value)
    seen = {
        name
        for name, node in (
            ("birds", "/flock/birds/wings"),
            ("birds", "/flock/birds/bodies"),
            ("darts", "/flock/darts"),
            ("points", "/flock/points"),
        )
        if scene.there(node).visible
    }
    assert seen == ({kind} if kind != "nobody" else set())
    wanted = BIRD_BYTES / AGENT_BYTES if kind == "birds" else 1.0
    assert load(one, Look(birds=birds)) == pytest.approx(count * wanted)


def test_wings_are_at_the_shoulders_of_their_bodies():
    scene = Stand()
    parts = Parts(scene)
    one = frame([heading(0.3, 0.2), heading(2.0)])
    made = shown(one)
    for node, name, value in parts.draw_flock(made):
        setattr(node, name, value)
    bodies, both = scene.there("/flock/birds/bodies"), scene.there("/flock/birds/wings")
    size = SCALE * made.length
    over = both.batched_positions - bodies.batched_positions
    assert np.linalg.norm(over, axis=1) == pytest.approx(SHOULDER * size, rel=1e-3)
    assert both.batched_scales[:, 0] == pytest.approx(size)
    assert np.hypot(*both.batched_scales.T[1:]) == pytest.approx(size)
    sent = [bodies.batched_positions, bodies.batched_wxyzs, bodies.batched_colors]
    sent += [both.batched_positions, both.batched_wxyzs, both.batched_colors]
    assert sum(part.nbytes for part in [*sent, both.batched_scales]) == 2 * BIRD_BYTES


def test_the_wake_is_where_the_tips_have_been():
    scene = Stand()
    flight = Flight(Clock())
    wake = Wake(scene, "", flight)
    look = Look(wake=True, trail_length=16)
    for tick in range(12):
        one = frame([heading(0.0)], tick, position=np.array([[5.0 + 0.1 * tick, 6.0, 7.0]]))
        made = shown(one, look)
        flight.follow(made)
        draw(wake, made)
    lines = np.concatenate(
        [node.points for node in scene.sent if node.name.startswith("/flock/wake") and node.visible]
    )
    aside = TIP * SCALE * made.length
    across = np.unique(np.round(lines[:, :, 1] - made.at[0, 1], 5))
    assert across == pytest.approx([-aside, aside], abs=1e-4)
    assert np.unique(np.round(lines[:, :, 2], 5)) == pytest.approx([made.at[0, 2]], abs=1e-4)
    down = replace(one, tick=12, flying=np.array([False]))
    made = shown(down, look)
    flight.follow(made)
    draw(wake, made)
    assert not scene.there("/flock/wake/tip").visible
    draw(wake, shown(down, Look()))
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
        at = made.stage.shown(place)[0]
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
    places = np.random.default_rng(1).random((3 * MOST, 3)) * 20.0
    one = frame([heading(0.0)], 10_000, crashes=crashed(places, list(range(3 * MOST))))
    draw(marks, shown(one))
    drawn = scene.there("/flock/crashes").points.reshape(MOST, -1, 3).mean(axis=1)
    assert drawn == pytest.approx(shown(one).stage.shown(places[-MOST:]), abs=1e-5)


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
    flock.arrays.fate[3] = (0.0, 1.0, *flock.position[3])
    flock.speed[3] = 1e3
    taken = Camera(flock, 1).take()
    assert np.flatnonzero(taken.down).tolist() == [3]
    assert taken.crashes.row.tolist() == [3]
    assert taken.speed_scale == np.delete(flock.speed, 3).max()
    assert np.isnan(taken.saved).all()
    assert taken.kept == flock.parameters.d_r
    plain = Camera(Flock("vem", agents=3, dim=3, rng=1), 1).take()
    assert (plain.flying, plain.crashes, plain.saved, plain.kept) == (None, None, None, np.inf)
