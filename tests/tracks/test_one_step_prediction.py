"""One-step prediction: the model's own rule, against versions that are written agent by agent."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.tracks.fit.frame_sample import FrameSample, sample_frames
from app.tracks.fit.one_step import (
    OneStepPredictor,
    angle_between,
    costs_of_kept_headings,
    frame_costs,
)
from app.tracks.fit.tick_scale import ScaledModel, tick_scale
from tracks.fitted_flocks import (
    capped_square,
    couzin_headings,
    mill,
    tracks_of,
    vem_headings,
)
from worlds.input_error import InputError
from worlds.world import World


def random_sample(seed, frames=4, individuals=12, side=6.0, missing=0.2, dim=2):
    rng = np.random.default_rng(seed)

    def directions():
        vectors = rng.normal(size=(frames, individuals, dim))
        return vectors / np.linalg.norm(vectors, axis=2, keepdims=True)

    place, heading, following = (
        rng.uniform(0.0, side, (frames, individuals, dim)), directions(), directions()
    )  # fmt: skip
    place[rng.random((frames, individuals)) < missing] = np.nan
    following[rng.random((frames, individuals)) < missing] = np.nan
    speed = np.ones((frames, individuals))
    return FrameSample(place, heading, speed, following, np.arange(frames))


def naive_costs(sample, headings, most=0.5):
    """The cost of each frame, of a rule (place, heading) -> headings."""
    costs = []
    for k in range(len(sample.frame)):
        rows = np.flatnonzero(np.isfinite(sample.position[k]).all(axis=1))
        predicted = headings(sample.position[k, rows], sample.heading[k, rows])
        squares = [
            capped_square(predicted[at], sample.following[k, row], most)
            for at, row in enumerate(rows)
            if np.isfinite(sample.following[k, row]).all()
        ]
        costs.append(np.mean(squares))
    return np.array(costs)


@pytest.mark.parametrize("seed", range(6))
def test_costs_of_vem_are_those_of_the_naive_version(seed):
    side = 6.0
    sample = random_sample(seed, side=side)
    r = [0.3, 0.8, 1.4, 2.0, 2.5, 2.9][seed]
    predictor = OneStepPredictor(ScaledModel("vem", {}, ()), World(size=(side, side)))
    expected = naive_costs(sample, lambda x, u: vem_headings(x, u, r, (side, side)))
    np.testing.assert_allclose(predictor.costs(sample, {"r": r}), expected, rtol=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_costs_of_couzin_are_those_of_the_naive_version(seed):
    sample = random_sample(seed, side=8.0)
    dr_o, dr_a = [(0.0, 5.0), (2.0, 0.0), (3.0, 10.0), (1.5, 4.0), (6.0, 2.0), (0.0, 0.0)][seed]
    world = World(size=(8.0, 8.0), edges=("open",))
    predictor = OneStepPredictor(ScaledModel("couzin", {"sigma": 0.0}, ()), world)
    expected = naive_costs(sample, lambda x, u: couzin_headings(x, u, dr_o, dr_a))
    costs = predictor.costs(sample, {"dr_o": dr_o, "dr_a": dr_a})
    np.testing.assert_allclose(costs, expected, rtol=1e-9)


def test_a_flock_that_is_used_again_remembers_nothing():
    sample = random_sample(1, side=8.0)
    world = World(size=(8.0, 8.0), edges=("open",))
    predictor = OneStepPredictor(ScaledModel("couzin", {"sigma": 0.0}, ()), world)
    first = predictor.costs(sample, {"dr_o": 3.0, "dr_a": 10.0})
    predictor.costs(random_sample(2, side=8.0), {"dr_o": 0.0, "dr_a": 30.0})
    np.testing.assert_array_equal(predictor.costs(sample, {"dr_o": 3.0, "dr_a": 10.0}), first)
    assert len(predictor.flocks) <= 12  # one for each number of individuals


@pytest.mark.parametrize("model", ["inertial-spin", "reynolds", "dorsogna", "hwvem"])
def test_rules_with_memory_or_free_speeds_begin_anew_at_each_frame(model):
    sample = random_sample(3, side=6.0)
    world = World(size=(6.0, 6.0))
    predictor = OneStepPredictor(ScaledModel(model, {}, ()), world)
    first = predictor.predict(sample, {})
    predictor.predict(random_sample(4, side=6.0), {})
    np.testing.assert_array_equal(predictor.predict(sample, {}), first)
    assert np.isfinite(first[sample.present]).all()


def test_in_space_too():
    sample = random_sample(5, side=3.0, dim=3, missing=0.0)
    predictor = OneStepPredictor(ScaledModel("vem", {}, ()), World(size=(3.0, 3.0, 3.0)))
    period = (3.0, 3.0, 3.0)
    expected = [
        np.mean([
            capped_square(p, f)
            for p, f in zip(vem_headings(x, u, 1.0, period), following, strict=True)
        ])
        for x, u, following in zip(sample.position, sample.heading, sample.following, strict=True)
        if np.isfinite(following).all()
    ]  # fmt: skip
    whole = np.isfinite(sample.following).all(axis=(1, 2))
    np.testing.assert_allclose(predictor.costs(sample, {"r": 1.0})[whole], expected, rtol=1e-9)


def test_small_angles_are_exact_and_large_ones_count_half_a_radian():
    angles = np.array([1e-9, 1e-4, 0.3, 0.5, 2.0, math.pi])
    turned = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    ahead = np.broadcast_to([1.0, 0.0], turned.shape)
    np.testing.assert_allclose(angle_between(ahead, turned), angles, rtol=1e-12)
    one = (1, len(angles), 2)
    sample = FrameSample(
        np.zeros(one), ahead.reshape(one), np.ones(one[:2]), turned.reshape(one), np.arange(1)
    )
    expected = np.mean([1e-18, 1e-8, 0.09, 0.25, 0.25, 0.25])
    np.testing.assert_allclose(costs_of_kept_headings(sample), expected, rtol=1e-9)
    np.testing.assert_allclose(frame_costs(sample, turned.reshape(one)), 0.0, atol=1e-30)


def test_headings_are_shuffled_within_an_individual_with_their_next_ones():
    sample = random_sample(7, frames=20)
    mixed = sample.with_shuffled_headings(1)
    np.testing.assert_array_equal(mixed.position, sample.position)
    np.testing.assert_array_equal(mixed.judged, sample.judged)
    turn = angle_between(sample.heading, sample.following)
    mixed_turn = angle_between(mixed.heading, mixed.following)
    moved = 0
    for row in range(12):
        at = sample.judged[:, row]
        np.testing.assert_allclose(np.sort(mixed_turn[at, row]), np.sort(turn[at, row]))
        moved += (mixed.heading[at, row] != sample.heading[at, row]).any(axis=1).sum()
    assert moved > 0.8 * sample.judged.sum()


def test_frames_of_a_fit_come_before_those_held_back_with_a_window_between():
    tracks = mill(frames=120)
    halves = sample_frames(tracks, tick_scale(tracks), 0.6, frames=15)
    assert halves.motion.frames == 7
    assert halves.fitted.frame.max() + 7 < halves.held_back.frame.min()
    assert len(halves.fitted.frame) == len(halves.held_back.frame) == 15


def test_who_is_in_a_gap_is_in_no_flock():
    place = mill(frames=120).position.copy()
    place[40:60, 0] = np.nan
    tracks = tracks_of(place, 0.1)
    halves = sample_frames(tracks, tick_scale(tracks), 0.6, frames=100)
    gone = (halves.fitted.frame >= 37) & (halves.fitted.frame <= 62)
    assert gone.any()
    assert not halves.fitted.present[gone, 0].any()
    assert halves.fitted.present[~gone, 0].all()


def test_too_few_frames_are_refused():
    tracks = mill(frames=120).frames(0, 20)
    with pytest.raises(InputError, match=r"mill has \d+ frames from which the next can be"):
        sample_frames(tracks, tick_scale(tracks), 0.6)
