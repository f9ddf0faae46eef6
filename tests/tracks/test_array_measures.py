"""Maps, leadership, structure: what is known exactly, what was published, and naive versions."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import track_measures as naive

from agents import Flock
from agents.observables.anisotropy import (
    border_distance,
    isotropic_gamma,
    neighbour_anisotropy,
    range_of_structure,
)
from agents.observables.leadership import leadership, pair_delays
from agents.observables.neighbour_map import neighbour_map
from worlds.input_error import InputError
from worlds.world import World

OPEN = np.ones(2), np.zeros(2, bool)
OPEN_SPACE = np.ones(3), np.zeros(3, bool)


def units(angle):
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def test_places_at_random_have_a_flat_map():
    rng = np.random.default_rng(5)
    n, side = 80, 10.0
    position = rng.uniform(0.0, side, (400, n, 2))
    heading = units(rng.uniform(0.0, math.tau, (400, n)))
    box = np.full(2, side), np.ones(2, bool)
    found = neighbour_map(position, heading, *box, 3.0, 12)
    flat = (n - 1) / side**2
    assert found.individuals == 400 * n
    assert found.density.mean() == pytest.approx(flat, rel=2e-3)
    # a pair is in the map twice, at places that are each other's mirrors if they head alike
    assert found.density.std() / flat < 4.0 * math.sqrt(2.0 / found.pairs.mean())


def test_thirty_per_cent_of_gaps_take_as_much_of_the_density():
    rng = np.random.default_rng(6)
    position = rng.uniform(0.0, 10.0, (400, 80, 2))
    position[rng.random((400, 80)) < 0.3] = np.nan
    heading = units(rng.uniform(0.0, math.tau, (400, 80)))
    found = neighbour_map(position, heading, np.full(2, 10.0), np.ones(2, bool), 3.0, 12)
    assert found.density.mean() == pytest.approx(0.7 * 79 / 100.0, rel=0.015)


TWO = {  # place of the second, seen from the first, which heads east; its turn to the left, deg
    "left, attracting": ((0.0, 6.0), 4.0),
    "left, repelling": ((0.0, 0.5), -4.0),
    "left, aligned with": ((0.0, 2.0), 0.0),
    "behind, not seen": ((-6.0, 0.0), 0.0),
    "right, attracting": ((0.0, -6.0), -4.0),
}


@pytest.mark.parametrize("case", TWO)
def test_two_couzin_agents_turn_by_the_place_of_the_neighbour(case):
    place, turn = TWO[case]
    flock = Flock("couzin", agents=2, world=World("open", size=40.0), rng=1, sigma=0.0,
                  dr_o=3.0, dr_a=10.0)  # fmt: skip
    flock.position[:] = np.array([[20.0, 20.0], [20.0 + place[0], 20.0 + place[1]]])
    flock.heading[:] = np.array([1.0, 0.0])
    before = flock.position.copy(), flock.heading.copy()
    flock.run(1)
    turned = np.degrees(np.arctan2(flock.heading[:, 1], flock.heading[:, 0]))
    turns = np.array([turned[0], np.nan])
    found = neighbour_map(*before, *OPEN, 8.0, 17, turn=turns)
    row, column = np.argwhere(np.isfinite(found.turn))[0]
    middle = (found.edges[1:] + found.edges[:-1]) / 2.0
    assert (middle[row], -middle[column]) == pytest.approx(place, abs=0.5)
    assert found.turn[row, column] == pytest.approx(turn, abs=1e-9)


def test_the_odd_part_leaves_out_what_all_do():
    # everybody turns at -20 and towards a neighbour at 5 besides
    rng = np.random.default_rng(7)
    position = rng.uniform(0.0, 4.0, (500, 2, 2))
    heading = units(np.zeros((500, 2)))
    left = (position[:, ::-1, 1] - position[:, :, 1]) > 0.0
    turn = -20.0 + np.where(left, 5.0, -5.0)
    found = neighbour_map(position, heading, *OPEN, 2.0, 2, turn=turn)
    np.testing.assert_allclose(found.turn, [[-15.0, -25.0]] * 2)
    np.testing.assert_allclose(found.odd_turn, [[5.0, -5.0]] * 2)


cases = {
    "seed": st.integers(0, 999),
    "n": st.integers(1, 7),
    "frames": st.integers(1, 4),
    "wraps": st.booleans(),
    "bins": st.integers(2, 6),
}


@settings(max_examples=60, deadline=None, derandomize=True)
@given(**cases)
def test_the_map_is_that_of_loops_over_pairs(seed, n, frames, wraps, bins):
    rng = np.random.default_rng(seed)
    position = rng.uniform(0.0, 4.0, (frames, n, 2))
    heading = units(rng.uniform(0.0, math.tau, (frames, n)))
    turn = rng.normal(size=(frames, n))
    for array in (position, heading):
        array[rng.random((frames, n)) < 0.2] = np.nan
    turn[rng.random((frames, n)) < 0.2] = np.nan
    box = np.full(2, 4.0), np.full(2, wraps)
    found = neighbour_map(position, heading, *box, 1.7, bins, turn=turn)
    pairs, sums, counted = naive.neighbour_counts(position, heading, turn, *box, 1.7, bins)
    np.testing.assert_array_equal(found.pairs, pairs)
    np.testing.assert_array_equal(found.turns, counted)
    np.testing.assert_allclose(np.nan_to_num(found.turn) * counted, sums, atol=1e-12)


# Leadership.


def copies(delays, frames=1500, seed=1, spread=0.15):
    """Headings (T, N, 2) of a random walk, each so many frames late."""
    angle = np.random.default_rng(seed).normal(0.0, spread, frames + max(delays)).cumsum()
    return units(np.stack([angle[max(delays) - d :][:frames] for d in delays], axis=1))


# With gaps the three means that a parabola is through are of different frames: the error falls with
# the root of their number.
@pytest.mark.parametrize(("lost", "frames"), [(0.0, 6000), (0.3, 60000)])
def test_copies_after_some_time_are_found_to_a_thousandth_of_a_second(lost, frames):
    delays = [0, 2, 4, 6, 8, 10]  # 0.2 to 1.0 s at 10 frames/s
    heading = copies(delays, frames)
    heading[np.random.default_rng(2).random(heading.shape[:2]) < lost] = np.nan
    found = leadership(heading, 20)
    expected = np.subtract.outer(delays, delays).T / 10.0
    wrong = np.abs(found.delay / 10.0 - expected)
    assert np.nanmax(wrong) < 1e-3
    assert np.isfinite(found.delay).sum() == 30
    others = (np.sum(delays) - 6 * np.array(delays)) / 5.0
    assert np.abs(found.lead - others).max() < 0.01
    assert found.resolved.all()


def test_a_flock_that_follows_a_turning_leader_is_resolved():
    rng = np.random.default_rng(3)
    lead = rng.normal(0.0, 0.05, 1600).cumsum()
    late = np.stack(
        [lead[100:]] + [lead[70:1570] + rng.normal(0, 0.05, 1500) for _ in range(11)], 1
    )
    found = leadership(units(late), 60)
    assert found.lead[0] == pytest.approx(30.0, abs=1.5)
    assert np.abs(found.lead[1:]).max() < 4.0
    assert found.resolved[0]


FLOCKS = 20
CHANCE = 3
"""Of FLOCKS with a chance of 5 % each at most, more than these are in one of sixty sets."""


def test_who_all_turn_at_once_lead_nobody():
    resolved = 0
    for seed in range(FLOCKS):
        rng = np.random.default_rng(seed)
        shared = rng.normal(0.0, 0.05, 1500).cumsum()
        found = leadership(units(shared[:, None] + rng.normal(0.0, 0.2, (1500, 20))), 30)
        assert np.isfinite(found.delay).any()
        resolved += found.resolved.any()
    assert resolved <= CHANCE


def test_who_keep_one_heading_lead_nobody():
    resolved = 0
    for seed in range(FLOCKS):
        noise = np.random.default_rng(seed).normal(0.0, 0.3, (1500, 20))
        noise[:, 0] = 0.0  # the leader never turns
        found = leadership(units(noise), 30)
        assert found.null_peak > 0.8
        resolved += found.resolved.any()
    assert resolved <= CHANCE


def test_too_short_a_time_resolves_nothing():
    found = leadership(copies([0, 3], 60), 10)
    assert found.blocks == 1
    assert not found.resolved.any()
    assert np.isnan(found.error).all()


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.integers(2, 4), st.integers(1, 6), st.sampled_from((2, 3)))
def test_delays_are_where_the_naive_curve_is_largest(seed, n, longest, dim):
    rng = np.random.default_rng(seed)
    heading = np.cumsum(rng.normal(size=(40, n, dim)), axis=0)
    heading /= np.linalg.norm(heading, axis=2, keepdims=True)
    heading[rng.random((40, n)) < 0.1] = np.nan
    found = pair_delays(heading, longest)
    for i in range(n):
        for j in range(i + 1, n):
            curve = naive.delay_curve(heading[:, i], heading[:, j], longest)
            if not np.isfinite(curve).any():
                assert np.isnan(found.peak[i, j])
                continue
            assert found.peak[i, j] == pytest.approx(np.nanmax(curve), abs=1e-12)
            assert found.peak[j, i] == found.peak[i, j]
            best = int(np.nanargmax(curve)) - longest
            if math.isfinite(found.delay[i, j]):
                assert abs(found.delay[i, j] - best) <= 0.5 + 1e-9
                assert found.delay[j, i] == -found.delay[i, j]
            elif abs(best) < longest:
                assert not np.isfinite(curve[best + longest - 1 : best + longest + 2]).all()


# Structure.


def lattice(sides, many, seed=0):
    """Places on a lattice with these sides, jittered so little that no rank changes."""
    axes = [np.arange(k) * side for k, side in zip(many, sides, strict=True)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(sides))
    return places + np.random.default_rng(seed).normal(0.0, 1e-6, places.shape)


@pytest.mark.parametrize("images", [False, True])
@pytest.mark.parametrize(
    ("sides", "many", "direction", "ranks", "gamma"),
    [
        ((1.0, 1.0, 2.0), (8, 8, 8), (0.0, 0.0, 1.0), 4, 1.0),
        ((2.0, 2.0, 1.0), (8, 8, 16), (0.0, 0.0, 1.0), 2, 0.0),
        ((1.0, 2.0), (12, 12), (0.0, 1.0), 2, 1.0),
        ((1.0, 2.0), (12, 12), (1.0, 0.0), 2, 0.0),
    ],
)
def test_a_lattice_has_all_its_neighbours_aside_or_ahead(
    sides, many, direction, ranks, gamma, images
):
    box = np.array(sides) * many, np.full(len(sides), images)
    found = neighbour_anisotropy(lattice(sides, many), np.array(direction), *box, ranks)
    np.testing.assert_allclose(found.gamma, gamma, atol=1e-6)
    np.testing.assert_allclose(found.distance, 1.0, atol=1e-4)
    assert (found.individuals > 80 if not images else found.individuals == np.prod(many)).all()


@pytest.mark.parametrize(("dim", "n"), [(2, 400), (3, 700)])
def test_places_at_random_have_no_structure(dim, n):
    rng = np.random.default_rng(4)
    box = np.full(dim, 1.0), np.ones(dim, bool)
    values = []
    for _ in range(150):
        direction = rng.normal(size=dim)
        values.append(neighbour_anisotropy(rng.random((n, dim)), direction, *box, 6).gamma)
    mean, spread = isotropic_gamma(dim)
    error = spread / math.sqrt(150)
    assert np.abs(np.mean(values, axis=0) - mean).max() < 3.5 * error
    assert np.std(values) == pytest.approx(spread, rel=0.1)


def test_the_shape_of_a_flock_is_no_structure():
    rng = np.random.default_rng(8)
    direction = np.array([1.0, 0.0])
    kept, all_of_them = [], []
    for _ in range(40):
        places = rng.random((100, 2)) * [8.0, 1.0]  # long, along its direction
        found = neighbour_anisotropy(places, direction, *OPEN, 8)
        kept.append(found.gamma[-1])
        all_of_them.append(naive.gamma(places, direction, 8))
    assert np.mean(all_of_them) < 0.25
    assert np.mean(kept) == pytest.approx(0.5, abs=3.5 * math.sqrt(1.0 / 8.0 / 40))


def test_how_far_a_place_is_inside():
    corners = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0], [1.0, 1.0], [3.5, 1.0]])
    inside = border_distance(corners, np.zeros(2, bool))
    np.testing.assert_allclose(inside, [0, 0, 0, 0, 1.0, 0.5], atol=1e-12)
    on_a_line = np.column_stack([np.arange(5.0), np.arange(5.0)])
    assert border_distance(on_a_line, np.zeros(2, bool)).tolist() == [0.0] * 5


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.sampled_from((2, 3)), st.integers(1, 4))
def test_with_no_border_it_is_the_naive_one(seed, dim, k):
    # a flock in the middle of a box that closes on itself far away
    rng = np.random.default_rng(seed)
    places, direction = rng.normal(size=(9, dim)), rng.normal(size=dim)
    found = neighbour_anisotropy(places, direction, np.full(dim, 1e4), np.ones(dim, bool), k)
    assert found.gamma[k - 1] == pytest.approx(naive.gamma(places, direction, k), abs=1e-9)


def test_where_structure_ends():
    gamma = np.array([0.8, 0.6, 0.4, 0.3, 0.35])
    assert range_of_structure(gamma, 3) == pytest.approx(3.0 + (0.4 - 1 / 3) / 0.1)
    assert math.isnan(range_of_structure(np.array([0.2, 0.9]), 3))
    assert math.isnan(range_of_structure(np.array([0.9, np.nan, 0.1]), 3))


WRONG = {
    "turn": (lambda: neighbour_map(np.ones((3, 4, 2)), np.ones((3, 4, 2)), *OPEN, 1.0,
                                   turn=np.ones((2, 4))), r"turn has shape \(2, 4\)"),
    "in space": (lambda: neighbour_map(np.ones((3, 3)), np.ones((3, 3)), *OPEN_SPACE, 1.0),
                 r"position has shape \(1, 3, 3\)"),
    "velocities": (lambda: neighbour_map(np.ones((3, 2)), 3 * np.ones((3, 2)), *OPEN, 1.0),
                   "no unit vectors"),
    "reach": (lambda: neighbour_map(np.ones((3, 2)), np.eye(2)[[0, 0, 0]], *OPEN, 0.0),
              "reach = 0.0"),
    "bins": (lambda: neighbour_map(np.ones((3, 2)), np.eye(2)[[0, 0, 0]], *OPEN, 1.0, 1),
             "bins holds 1"),
    "longest": (lambda: leadership(np.ones((20, 3, 2)), 10), "longest = 10 frames"),
    "one moment": (lambda: leadership(np.ones((20, 2)), 1), "heading has shape"),
    "direction": (lambda: neighbour_anisotropy(np.ones((9, 2)), [0.0, 0.0], *OPEN), "direction ="),
    "ranks": (lambda: neighbour_anisotropy(np.ones((9, 2)), [0.0, 1.0], *OPEN, 0),
              "neighbours holds 0"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_what_is_no_such_array_is_refused_in_one_line(case):
    ask, words = WRONG[case]
    with pytest.raises(InputError, match=words) as caught:
        ask()
    assert "\n" not in str(caught.value)


def test_few_or_nobody_have_no_structure_and_no_lead():
    few = neighbour_anisotropy(np.ones((3, 2)), np.array([1.0, 0.0]), *OPEN, 5)
    assert np.isnan(few.gamma).all()
    assert leadership(copies([0], 100), 5).lead.shape == (1,)
    empty = neighbour_map(np.full((2, 3, 2), np.nan), np.full((2, 3, 2), np.nan), *OPEN, 1.0)
    assert (empty.individuals, empty.pairs.sum()) == (0, 0)
    assert not empty.density.any()
