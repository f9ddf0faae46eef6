"""The echelon rule against its oracle, exact slots, and the V that a flock makes of itself."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import echelon as oracle

from agents import Flock
from agents.observables.formation import saved_shares

OPEN = {"world": "open", "dim": 3, "size": 40.0, "rng": 1, "contact": "start", "body": 0.0}
AGILE = {"theta_max": 1800.0, "a_max": 50.0, "tau": 1.0, "v_min": 0.0, "v_max": 20.0}
"""A body that takes any wished velocity within a tick."""
SLOT = np.array([-0.8 * 2.5, 0.863 * 2.5, 0.0])
"""The slot to the left of a bird that heads for +x."""
HERE = np.array([10.0, 0.0, 0.0])


def birds(position, heading=None, speed=None, **given):
    """A flock of these birds in open space, without noise."""
    position = np.asarray(position, float)
    n = len(position)
    heading = np.tile([1.0, 0.0, 0.0], (n, 1)) if heading is None else heading
    speed = np.full(n, 3.5) if speed is None else speed
    begin = {"position": position, "heading": heading, "speed": speed}
    return Flock("echelon", start=begin, **({"sigma": 0.0} | OPEN | given))


@st.composite
def scenes(draw):
    """Positions, headings, speeds and parameters."""
    chance = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(1, 12))
    spread = draw(st.sampled_from((5.0, 15.0, 40.0)))
    flat = draw(st.sampled_from((0.05, 1.0)))
    position = chance.uniform(0.0, spread, (n, 3)) * [1.0, 1.0, flat]
    way = draw(st.sampled_from((0.0, 1.5, 6.0))) * np.eye(3)[0] + chance.normal(size=(n, 3))
    heading = way / np.linalg.norm(way, axis=1, keepdims=True)
    p = oracle.Numbers(
        d_r=draw(st.sampled_from((0.5, 1.8))),
        alpha=draw(st.sampled_from((120.0, 240.0, 359.0))),
        w=draw(st.sampled_from((0.0, 0.7, 1.0))),
        step=draw(st.sampled_from((0.5, 1.2))),
    )
    return position, heading, chance.uniform(1.0, 5.0, n), p


def all_wishes(position, heading, speed, p):
    return np.array([oracle.wish(i, position, heading, speed, p) for i in range(len(position))])


@settings(max_examples=150, deadline=None)
@given(scene=scenes())
def test_every_wish_is_the_oracles(scene):
    position, heading, speed, p = scene
    wished = all_wishes(position, heading, speed, p)
    nudge = 1e-8 * np.random.default_rng(0).standard_normal(position.shape)
    nudged = all_wishes(position + nudge, heading, speed, p)
    assume(np.abs(nudged - wished).max() < 1e-5)  # nothing hangs on the last bits of a number
    assume((np.linalg.norm(wished, axis=1) > 1e-3).all())
    straight = wished / np.linalg.norm(wished, axis=1, keepdims=True)
    assume((np.abs((straight * heading).sum(axis=1)) < 1.0 - 1e-9).all() or len(position) == 1)
    flock = birds(position, heading, speed, **AGILE, **dataclasses.asdict(p))
    flock.run(1)
    np.testing.assert_allclose(flock.speed[:, None] * flock.heading, wished, atol=1e-7)


def test_a_bird_in_its_slot_stays_there():
    flock = birds([HERE, HERE + SLOT])
    flock.run(200)
    np.testing.assert_allclose(flock.position[1] - flock.position[0], SLOT, atol=1e-9)
    np.testing.assert_allclose(flock.heading, [[1.0, 0.0, 0.0]] * 2, atol=1e-12)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_bird_takes_the_nearer_slot_from_further_behind_and_below(side):
    flock = birds([[20.0, 0.0, 0.0], [12.0, 4.0 * side, -1.5]])
    flock.run(600)
    gap = flock.position[1] - flock.position[0]
    u = flock.heading[0]
    right = np.array([u[1], -u[0], 0.0]) / math.hypot(u[0], u[1])
    assert gap @ u == pytest.approx(-2.0, abs=0.02)
    assert gap @ right == pytest.approx(-side * 0.863 * 2.5, abs=0.02)
    assert flock.signal("saved")[1] == pytest.approx(0.65, abs=0.03)


def test_a_slot_that_is_taken_is_left_to_the_one_in_it():
    """The third bird goes for the other side, though the left slot is nearer."""
    flock = birds([HERE, HERE + SLOT, [6.0, 0.3, 0.0]])
    flock.run(600)
    mirrored = SLOT * [1.0, -1.0, 1.0]
    np.testing.assert_allclose(flock.position[2] - flock.position[0], mirrored, atol=0.05)


def test_without_weight_slots_are_not_sought():
    flock = birds([[20.0, 0.0, 0.0], [12.0, 4.0, 0.0]], w=0.0)
    flock.run(600)
    assert np.linalg.norm(flock.position[1] - flock.position[0] - SLOT) > 2.0


def test_a_flock_that_flies_one_way_climbs_no_more_steeply_than_is_wished():
    """It starts with headings all over the sphere."""
    flock = Flock("echelon", agents=30, rng=2, climb=10.0, sigma=0.0)
    flock.run(3000)
    steep = np.degrees(np.arcsin(np.abs(flock.heading[:, 2])))
    assert steep.max() <= 10.0 + 1e-6


def test_the_figure_of_the_flock_is_that_of_its_positions():
    """The share is measured of the flock as it stood at the start of the last tick."""
    flock = Flock("echelon", agents=30, rng=3, d_a=20.0)
    flock.run(200)
    expected = saved_shares(
        flock.position, flock.heading, 2.5, flock.world.size, flock.world.images
    )
    flock.run(1)
    np.testing.assert_allclose(flock.signal("saved"), expected, atol=1e-9)


def test_a_flock_makes_echelons_that_save_and_without_slots_it_saves_nothing():
    seeking, plain = [], []
    for seed in range(1, 5):
        for w, found in ((1.0, seeking), (0.0, plain)):
            flock = Flock("echelon", agents=30, rng=seed, w=w)
            flock.run(4000)
            found.append(flock.signal("saved")[flock.active].mean())
    assert np.median(seeking) > 0.6
    assert max(plain) < 0.0


def test_the_bird_ahead_is_the_one_that_counts():
    flock = birds([HERE, HERE + SLOT, [30.0, 40.0, 0.0]])
    seen = flock.inspect(1)
    weight = dict(zip(seen.neighbours.tolist(), seen.weights.tolist(), strict=True))
    assert weight == {0: pytest.approx(1.0)}
