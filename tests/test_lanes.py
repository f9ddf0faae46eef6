"""Lane order: exact cases, what chance gives, and a naive version."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents import Flock
from agents.observables.catalogue import OBSERVABLES
from agents.observables.lanes import lane_order
from worlds.input_error import InputError

BOX, OPEN = np.array([40.0, 10.0]), np.array([True, False])


def ways(signs):
    return np.column_stack([np.asarray(signs, float), np.zeros(len(signs))])


def test_lanes_have_one_and_pairs_side_by_side_none():
    y = np.repeat([1.0, 4.0, 7.0], 10)
    position = np.column_stack([np.linspace(0.0, 39.0, 30), y])
    lanes = ways(np.repeat([1, -1, 1], 10))
    assert lane_order(position, lanes, BOX, OPEN, 1.0) == 1.0
    mixed = ways(np.tile([1, -1], 15))
    assert lane_order(position, mixed, BOX, OPEN, 1.0) == 0.0
    assert lane_order(position, ways(np.ones(30)), BOX, OPEN, 1.0) == 1.0
    three_to_one = ways(np.tile([1, 1, 1, -1], 8)[:28])
    assert lane_order(position[:28] * [1, 0], three_to_one, BOX, OPEN, 1.0) == 0.25


def test_the_width_is_half_the_mean_distance_unless_given():
    position = np.array([[1.0, 1.0], [9.0, 4.5], [20.0, 1.0], [30.0, 4.5]])
    both = ways([1, -1, 1, -1])
    assert lane_order(position, both, BOX, OPEN) == 1.0  # strips of 5 m: 2.5 m to either side
    assert lane_order(position, both, BOX, OPEN, 7.1) == 0.0
    assert lane_order(position, both, BOX, OPEN, 6.9) == 1.0


def test_a_lane_across_the_seam_is_one():
    position = np.array([[1.0, 0.1], [2.0, 9.9]])
    both = ways([1, -1])
    assert lane_order(position, both, BOX, np.array([True, True]), 0.5) == 0.0
    assert lane_order(position, both, BOX, OPEN, 0.5) == 1.0


def test_of_few_and_of_what_is_no_crowd():
    nobody = np.empty((0, 2))
    assert lane_order(nobody, nobody, BOX, OPEN) == 0.0
    assert lane_order(np.ones((1, 2)), ways([-1]), BOX, OPEN) == 1.0
    with pytest.raises(InputError, match="width = 0"):
        lane_order(np.ones((1, 2)), ways([1]), BOX, OPEN, 0.0)


def test_chance_gives_about_one_over_those_of_a_strip():
    rng = np.random.default_rng(1)
    found = []
    for _ in range(300):
        position = rng.uniform((0.0, 0.0), BOX, (100, 2))
        found.append(lane_order(position, ways(rng.choice([-1, 1], 100)), BOX, OPEN, 12.0))
    n = np.mean([np.sum(np.abs(y - rng.uniform(0, 10, 100)) < 6.0) for y in rng.uniform(0, 10, 50)])
    assert np.mean(found) == pytest.approx(1.0 / n, rel=0.25)


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 40),
    width=st.floats(0.1, 15.0),
    image=st.booleans(),
)
def test_it_is_the_naive_count(seed, n, width, image):
    rng = np.random.default_rng(seed)
    position = rng.uniform((0.0, 0.0), BOX, (n, 2))
    heading = rng.normal(size=(n, 2))
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    shares = []
    for i in range(n):
        ahead = back = 0
        for j in range(n):
            d = abs(position[i, 1] - position[j, 1])
            if image:
                d = min(d, BOX[1] - d)
            if d <= width / 2:
                ahead += heading[j, 0] >= 0.0
                back += heading[j, 0] < 0.0
        shares.append(((ahead - back) / (ahead + back)) ** 2)
    images = np.array([True, image])
    found = lane_order(position, heading, BOX, images, width)
    assert found == pytest.approx(np.mean(shares), abs=1e-12)
    assert 0.0 <= found <= 1.0
    back = lane_order(position, heading * [-1.0, 1.0], BOX, images, width)
    assert back == pytest.approx(found, abs=1e-12)


def test_in_space_height_makes_no_difference():
    rng = np.random.default_rng(2)
    position, heading = rng.uniform(0.0, 9.0, (30, 3)), np.tile(np.eye(3)[0], (30, 1))
    heading[::3] *= -1.0
    box, images = np.full(3, 9.0), np.zeros(3, bool)
    flat = lane_order(position[:, :2], heading[:, :2], box[:2], images[:2], 0.7)
    assert lane_order(position, heading, box, images, 0.7) == flat < 1.0


def test_it_tells_of_a_corridor():
    one = OBSERVABLES["lane-order"]
    corridor = Flock("pedestrian", agents=5, rng=1)
    assert one.tells(corridor)
    assert not one.tells(Flock("vem", agents=5, rng=1))
    assert 0.0 <= corridor.observe("lane-order") <= 1.0
