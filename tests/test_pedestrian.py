"""Pedestrians of Helbing and Molnar 1995 against their oracle, in exact cases and in a corridor."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import pedestrian as oracle
from oracles.scenes import unit_vectors

from agents import Flock
from worlds.obstacles import Box
from worlds.queries.clearance import clearance
from worlds.world import World

SIZE = (16.0, 8.0)
BOX = ((4.0, 3.0), (6.0, 4.5))
CORRIDOR = World("corridor", SIZE, ("wrap", "solid"), obstacles=(Box(low=BOX[0], high=BOX[1]),))
EAST, WEST = (1.0, 0.0), (-1.0, 0.0)


def start(seed, n):
    """n people of any velocity, off the walls and off the middle of each other."""
    rng = np.random.default_rng(seed)
    position = rng.uniform((0.0, 0.3), (SIZE[0], SIZE[1] - 0.3), (60 * n, 2))
    position = position[clearance(CORRIDOR, position) > 0.3][:n]
    return {
        "position": position,
        "heading": unit_vectors(rng, n, 2),
        "speed": rng.uniform(0.0, 1.5, n),
    }


def velocity(flock):
    return flock.speed[:, None] * flock.heading


def aims(flock):
    """Desired directions (N, 2) and speeds (N,) of a flock that has made a tick."""
    e = np.column_stack([flock.signal("way_x"), flock.signal("way_y")])
    p = flock.parameters
    return e, np.maximum(0.1 * p.v0, p.v0 + p.spread * flock.signal("deviation"))


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 14),
    r=st.sampled_from((2.0, 5.0)),
    step_time=st.sampled_from((0.0, 0.6, 2.0)),
    fov=st.sampled_from((90.0, 200.0, 360.0)),
    c=st.sampled_from((0.0, 0.5)),
    ways=st.sampled_from(("two", "own")),
)
def test_every_tick_is_the_oracles(seed, n, r, step_time, fov, c, ways):
    given = {"r": r, "step_time": step_time, "fov": fov, "c": c}
    flock = Flock("pedestrian", start=start(seed, n), world=CORRIDOR, rng=5, ways=ways, **given)
    p = oracle.Setting(**given)
    x, v, ahead = flock.position.copy(), velocity(flock), flock.heading.copy()
    for _ in range(2):
        flock.run(1)
        e, v0 = aims(flock)
        expected = np.c_[np.sign(ahead[:, 0]), np.zeros(n)] if ways == "two" else ahead
        np.testing.assert_array_equal(e, expected)
        x, v = oracle.step(x, v, e, v0, SIZE, BOX, p)
        off = flock.position - x
        off[:, 0] = oracle.image(off[:, 0], SIZE[0])
        np.testing.assert_allclose(off, 0.0, atol=1e-8)
        np.testing.assert_allclose(velocity(flock), v, atol=1e-8)
        x, v = flock.position.copy(), velocity(flock)


def test_the_forces_shown_are_the_oracles_and_sum_up_to_the_wish():
    flock = Flock("pedestrian", start=start(3, 40), world=CORRIDOR, rng=5, haste=1.0)
    flock.run(1)
    x, v, (e, v0) = flock.position.copy(), velocity(flock), aims(flock)
    largest = np.zeros(4)
    total = np.zeros((40, 2))
    for row in range(40):
        shown = flock.inspect(row).forces
        assert list(shown) == ["drive", "pedestrians", "walls", "limit"]
        expected = oracle.forces(row, x, v, e, v0, SIZE, BOX, oracle.Setting())
        np.testing.assert_allclose(list(shown.values())[:3], expected, atol=1e-9)
        largest = np.maximum(largest, np.linalg.norm(list(shown.values()), axis=1))
        total[row] = sum(shown.values())
    assert largest.min() > 0.05
    flock.run(1)
    np.testing.assert_allclose(velocity(flock), v + 0.05 * total, atol=1e-9)


def pair(apart, headings=(EAST, WEST), speed=0.0, **given):
    first = {
        "position": [[10.0, 10.0], [10.0 + apart[0], 10.0 + apart[1]]],
        "heading": list(headings),
        "speed": [speed, speed],
    }
    return Flock(
        "pedestrian", start=first, world="open", size=20.0, rng=1, **({"spread": 0.0} | given)
    )


def test_alone_the_velocity_comes_to_the_desired_one_within_tau():
    """v(t) = v^0 (1 - (1 - dt / tau)^k) from rest, which is (2) in steps of dt."""
    first = {"position": [[1.0, 2.0]], "heading": [[-0.6, 0.8]]}
    flock = Flock("pedestrian", start=first, world="open", size=10.0, rng=1, spread=0.0)
    flock.run(10)
    assert flock.speed[0] == pytest.approx(1.34 * (1.0 - 0.9**10), rel=1e-12)
    assert flock.heading[0] == pytest.approx(WEST)
    flock.run(400)
    assert velocity(flock)[0] == pytest.approx([-1.34, 0.0], rel=1e-9)


def test_who_stands_is_a_circle_that_pushes_by_the_distance():
    """Without a step b = |r|: f = V^0 / sigma exp(-r / sigma) along r, in full from ahead."""
    flock = pair((0.9, 0.0), v0=0.1, tau=10.0, haste=5.0)
    flock.run(1)
    push = 2.1 / 0.3 * math.exp(-0.9 / 0.3)
    most = 5.0 * 0.1
    moved = 0.05 * (0.1 / 10.0 - push)
    assert abs(moved) < most
    assert velocity(flock) == pytest.approx(np.array([[moved, 0.0], [-moved, 0.0]]), rel=1e-9)


def test_from_behind_it_counts_c():
    heads, follows = (velocity(pair_of_followers(c)) for c in (1.0, 0.25))
    base = 0.05 * 0.1 / 10.0
    assert heads[0] == pytest.approx(follows[0]), "the one ahead is seen"
    assert follows[1, 0] - base == pytest.approx(0.25 * (heads[1, 0] - base), rel=1e-9)


def pair_of_followers(c):
    """Two that want to go east, the second 0.9 m ahead of the first, after a tick from rest."""
    flock = pair((0.9, 0.0), (EAST, EAST), c=c, v0=0.1, tau=10.0, haste=5.0)
    flock.run(1)
    return flock


def test_a_step_pushes_along_its_whole_length_and_to_its_sides():
    """Beside the middle of a step of 2 m, at y: 2 b = sqrt((2 sqrt(1 + y^2))^2 - 4) = 2 y."""
    for y in (0.2, 0.5, 1.0):
        f = oracle.repelled((1.0, y), 1.0, EAST, oracle.Setting(r=9.0, step_time=2.0))
        assert f == pytest.approx([0.0, 2.1 / 0.3 * math.exp(-y / 0.3)], abs=1e-12)
    first = {
        "position": [[10.0, 10.0], [11.0, 10.5]],
        "heading": [EAST, EAST],
        "speed": [1.0, 0.0],
    }
    given = {"fov": 360.0, "v0": 1.0, "tau": 10.0, "haste": 5.0, "spread": 0.0}
    flock = Flock("pedestrian", start=first, world="open", size=20.0, rng=1, **given)
    flock.run(1)
    assert velocity(flock)[1] == pytest.approx(
        [0.05 * 0.1, 0.05 * 7.0 * math.exp(-0.5 / 0.3)], rel=1e-9
    )


def test_desired_speeds_are_normal_and_follow_from_the_seed():
    made = [Flock("pedestrian", agents=4000, size=200.0, world="wrap", rng=s) for s in (1, 1, 2)]
    for flock in made:
        flock.run(1)
    one, again, other = (flock.signal("deviation") for flock in made)
    np.testing.assert_array_equal(one, again)
    assert (one != other).mean() > 0.99
    assert abs(one.mean()) < 4.0 / math.sqrt(4000)
    assert abs(one.std() - 1.0) < 4.0 / math.sqrt(8000)
    ways = made[0].signal("way_x")
    assert abs((ways > 0.0).mean() - 0.5) < 4.0 * 0.5 / math.sqrt(4000)
    made[0].run(20)
    np.testing.assert_array_equal(made[0].signal("way_x"), ways)


def test_nobody_is_faster_than_its_own_bound():
    flock = Flock("pedestrian", agents=200, rng=3)
    for _ in range(20):
        flock.run(10)
        assert (flock.speed <= 1.3 * aims(flock)[1] * (1.0 + 1e-12)).all()
    assert flock.observe("inside-obstacles") == 0
