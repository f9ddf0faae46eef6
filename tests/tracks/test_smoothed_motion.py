"""Velocities of tracks: exact for parabolas, of known loss on a circle, with known noise."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import track_measures as naive

from app.tracks.motion import smoothed_motion, unwrap_places, velocity_noise, window_frames
from app.tracks.tracks import Tracks
from worlds.input_error import InputError


def tracks_of(position, fps=25.0, **others):
    frame = others.pop("frame", np.arange(len(position)))
    ids = tuple(map(str, range(position.shape[1])))
    return Tracks(position, frame, frame / fps, ids, "m", **others)


def on_circle(a, fps, frames=200):
    t = np.arange(frames) / fps
    return np.stack([np.cos(a * t), np.sin(a * t)], axis=1)[:, None, :]


def test_a_parabola_is_exact():
    t = np.arange(60) / 25.0
    place = np.stack([1.0 + 2.0 * t - 3.0 * t**2, 5.0 - t + 0.5 * t**2], axis=1)[:, None, :]
    motion = smoothed_motion(tracks_of(place), 0.4)
    inside = slice(motion.frames // 2, -(motion.frames // 2))
    expected = np.stack([2.0 - 6.0 * t, -1.0 + t], axis=1)[inside, None]
    np.testing.assert_allclose(motion.velocity[inside], expected, atol=1e-11)
    np.testing.assert_allclose(motion.position[inside], place[inside], atol=1e-12)
    np.testing.assert_allclose(
        motion.acceleration[inside], np.broadcast_to([-6.0, 1.0], expected.shape), atol=1e-9
    )
    assert motion.noise < 1e-13


@pytest.mark.parametrize(
    ("frames", "factor"),
    [(3, 0.998934), (5, 0.996378), (7, 0.992553), (11, 0.981140), (25, 0.903846)],
)
def test_on_a_circle_speed_is_lost_as_the_formula_says(frames, factor):
    motion = smoothed_motion(tracks_of(on_circle(2.0, 25.0)), (frames - 1) / 25.0)
    assert motion.frames == frames
    assert np.nanmean(motion.speed) / 2.0 == pytest.approx(factor, abs=5e-7)
    m = frames // 2
    k = np.arange(1, m + 1)
    formula = (k * np.sin(k * 2.0 / 25.0)).sum() / (2.0 / 25.0 * (k**2).sum())
    assert np.nanmax(np.abs(motion.speed / 2.0 - formula)) < 1e-12


@pytest.mark.parametrize("frames", [5, 7, 11])
def test_noise_of_places_is_told_and_so_is_that_of_velocities(frames):
    rng = np.random.default_rng(2)
    place = np.arange(3000)[:, None, None] * 0.04 + rng.normal(0.0, 0.05, (3000, 10, 2))
    motion = smoothed_motion(tracks_of(place), (frames - 1) / 25.0)
    assert motion.noise == pytest.approx(0.05, rel=0.02)
    error = np.nanstd(motion.velocity - 1.0)
    assert error == pytest.approx(velocity_noise(0.05, frames, 0.04), rel=0.02)
    assert error == pytest.approx(motion.velocity_noise, rel=0.03)
    m = frames // 2
    formula = 0.05 * 25.0 / math.sqrt(2.0 * sum(k * k for k in range(1, m + 1)))
    assert velocity_noise(0.05, frames, 0.04) == pytest.approx(formula, rel=1e-12)


@pytest.mark.parametrize(("gap", "frames"), [(1, 3), (1, 7), (4, 5), (9, 11)])
def test_a_gap_of_g_frames_costs_g_and_2m(gap, frames):
    place = on_circle(1.0, 25.0)
    place[80 : 80 + gap] = np.nan
    motion = smoothed_motion(tracks_of(place), (frames - 1) / 25.0)
    m = frames // 2
    lost = np.flatnonzero(~np.isfinite(motion.speed[m:-m, 0])) + m
    assert lost.tolist() == list(range(80 - m, 80 + gap + m))


def test_frames_that_are_missing_in_the_file_are_a_gap_too():
    frame = np.delete(np.arange(100), [40, 41, 42])
    place = np.stack([frame * 1.0, 0.0 * frame], axis=1)[:, None, :]
    motion = smoothed_motion(tracks_of(place, frame=frame), 4 / 25.0)
    assert np.flatnonzero(~np.isfinite(motion.speed[2:-2, 0])).tolist() == [36, 37, 38, 39]
    assert np.nanmax(np.abs(motion.velocity[..., 0] - 25.0)) < 1e-9
    plain = smoothed_motion(tracks_of(place, frame=frame), 0.0)
    assert np.flatnonzero(~np.isfinite(plain.speed[:, 0])).tolist() == [0, 40]


def test_across_the_seam_nobody_jumps():
    place = np.cumsum(np.full((90, 2, 2), 0.3), axis=0) % 2.0
    place[30:33, 0] = np.nan
    motion = smoothed_motion(tracks_of(place, period=(2.0, 2.0)), 0.2)
    assert np.nanmax(np.abs(motion.velocity - 7.5)) < 1e-9
    assert np.nanmin(motion.position) >= 0.0
    assert np.nanmax(motion.position) < 2.0
    one_axis = unwrap_places(place, (2.0, 0.0))
    assert np.nanmax(np.abs(np.diff(one_axis[33:, :, 0], axis=0) - 0.3)) < 1e-9
    np.testing.assert_array_equal(one_axis[..., 1], place[..., 1])


def test_there_is_no_heading_below_the_least_speed():
    speed = np.array([0.1, 0.5, 2.0])
    place = np.arange(50)[:, None, None] / 25.0 * speed[:, None] * np.array([1.0, 0.0])
    place[..., 0] += 3.0
    motion = smoothed_motion(tracks_of(place), 0.2, least_speed=0.4)
    assert np.isfinite(motion.heading[20, :, 0]).tolist() == [False, True, True]
    np.testing.assert_allclose(motion.heading[20, 1:], [[1.0, 0.0]] * 2, atol=1e-9)
    still = smoothed_motion(tracks_of(np.ones((9, 1, 2))), 0.0)
    assert not np.isfinite(still.heading).any()


def test_who_turns_left_has_a_turn_above_zero():
    for a in (1.5, -1.5):
        motion = smoothed_motion(tracks_of(on_circle(a, 100.0), 100.0), 0.1)
        assert np.nanmean(motion.turn) == pytest.approx(a, rel=0.01)
        plain = smoothed_motion(tracks_of(on_circle(a, 100.0), 100.0), 0.0)
        assert np.nanmean(plain.turn) == pytest.approx(a, rel=1e-9)


def test_headings_of_the_file_may_be_taken():
    place = on_circle(1.0, 25.0)
    pointing = np.roll(place, 1, axis=2) * 3.0
    motion = smoothed_motion(tracks_of(place, heading=pointing), 0.2, use_file_headings=True)
    np.testing.assert_allclose(motion.heading, pointing / 3.0, atol=1e-12)
    with pytest.raises(InputError, match="holds no headings"):
        smoothed_motion(tracks_of(place), 0.2, use_file_headings=True)


def test_the_window_is_the_nearest_odd_number_of_frames():
    assert [window_frames(s, 0.04) for s in (0.05, 0.12, 0.2, 0.24, 0.96)] == [3, 5, 7, 7, 25]
    assert (
        "window 7 frames (0.24 s)" in smoothed_motion(tracks_of(on_circle(1, 25)), 0.24).describe()
    )


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    st.integers(0, 99), st.integers(3, 20), st.integers(1, 3), st.sampled_from((2, 3)),
    st.sampled_from((3, 5, 7)),
)  # fmt: skip
def test_it_is_what_a_fit_in_each_window_gives(seed, frames, n, dim, window):
    rng = np.random.default_rng(seed)
    place = rng.normal(size=(frames, n, dim))
    place[rng.random((frames, n)) < 0.1] = np.nan
    expected = naive.smoothed(place, window, 0.04)
    if not np.isfinite(expected[1]).any():
        with pytest.raises(InputError):
            smoothed_motion(tracks_of(place), (window - 1) * 0.04)
        return
    motion = smoothed_motion(tracks_of(place), (window - 1) * 0.04)
    for found, one in zip(
        (motion.position, motion.velocity, motion.acceleration), expected, strict=True
    ):
        np.testing.assert_allclose(found, one, atol=1e-7)


@pytest.mark.parametrize(
    ("place", "options", "words"),
    [
        (np.ones((1, 2, 2)), {}, "one frame alone"),
        (np.ones((9, 2, 2)), {"window": -1.0}, "window = -1 s"),
        (np.ones((9, 2, 2)), {"window": math.nan}, "window = nan s"),
        (np.ones((9, 2, 2)), {"window": 5.0}, "for 127 frames without a gap, the window of 5.04 s"),
        (np.ones((9, 2, 2)), {"least_speed": math.inf}, "least speed = inf"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(place, options, words):
    with pytest.raises(InputError, match=words) as caught:
        smoothed_motion(tracks_of(place), **options)
    assert "\n" not in str(caught.value)
