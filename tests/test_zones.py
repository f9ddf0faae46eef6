"""The thesis's zones, literal and safe, against their oracle; exact cases; what they are for."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import zones as oracle
from oracles.solids import box, sphere

from agents import Flock
from worlds.obstacles import Sphere
from worlds.world import World

SIDE = 12.0
BALLS = (((4.0, 4.0, 6.0), 1.5), ((8.0, 7.0, 3.0), 2.0))
ROOM = World(
    name="room",
    size=(SIDE,) * 3,
    edges=("solid",) * 3,
    obstacles=tuple(Sphere(centre=centre, radius=radius) for centre, radius in BALLS),
)
SKY = World(name="sky", size=(SIDE,) * 3, edges=("open",) * 3)
SOLIDS = [sphere(*ball) for ball in BALLS] + box((0.0,) * 3, (SIDE,) * 3)
BODILESS = {"body": 0.0, "d_0": 0.0}


def start(seed, n, spread):
    """Agents in the middle of the room, clear of the balls, with speeds."""
    rng = np.random.default_rng(seed)
    heading = rng.normal(size=(n, 3))
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    position = 0.5 * SIDE + rng.uniform(-0.5 * spread, 0.5 * spread, (n, 3))
    outside = [min(solid(place)[0] for solid in SOLIDS) > 0.3 for place in position]
    assume(sum(outside) > 0)
    keep = np.array(outside)
    speed = rng.uniform(0.5, 3.0, n)
    return {"position": position[keep], "heading": heading[keep], "speed": speed[keep]}


@pytest.mark.parametrize(
    ("model", "rule"), [("thesis", oracle.literal), ("safe", oracle.safe)], ids=["thesis", "safe"]
)
@pytest.mark.parametrize("solid", [False, True], ids=["sky", "room"])
@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 15),
    spread=st.sampled_from((2.0, 5.0, 9.0)),
    alpha=st.sampled_from((90.0, 200.0, 270.0, 359.0)),
)
def test_a_tick_is_the_papers(model, rule, solid, seed, n, spread, alpha):
    begin = start(seed, n, spread)
    p = oracle.Zones(alpha=alpha, body=0.0)
    flock = Flock(model, start=begin, world=ROOM if solid else SKY, alpha=alpha, rng=1, **BODILESS)
    # A cone's edge or a direction straight behind would hang on the last bits.
    solids = SOLIDS if solid else []
    position, heading, speed = (begin[k] for k in ("position", "heading", "speed"))
    wanted = np.array([rule(i, position, heading, speed, solids, p) for i in range(len(position))])
    assume(((wanted * heading).sum(axis=1) > -0.9999 * np.linalg.norm(wanted, axis=1)).all())
    flock.run(1)
    place, course, pace = oracle.tick(rule, position, heading, speed, solids, p)
    np.testing.assert_allclose(flock.position, place, atol=1e-9)
    np.testing.assert_allclose(flock.heading, course, atol=1e-8)
    np.testing.assert_allclose(flock.speed, pace, atol=1e-12)


def pair(gap, ahead=(1.0, 0.0, 0.0), other=(1.0, 0.0, 0.0)):
    return {
        "position": [(6.0, 6.0, 6.0), np.add((6.0, 6.0, 6.0), gap)],
        "heading": [ahead, other],
        "speed": [3.0, 3.0],
    }


def test_one_beside_is_not_seen_with_90_degrees_and_is_with_270():
    for alpha, turns in ((90.0, False), (270.0, True)):
        flock = Flock("thesis", start=pair((0.0, 3.0, 0.0)), world=SKY, alpha=alpha, d_0=0.0, rng=1)
        flock.run(1)
        assert (flock.heading[0, 1] > 0.1) == turns


def test_repulsion_is_felt_in_view_by_the_thesis_and_all_round_by_the_safe_ones():
    for model, turns in (("thesis", False), ("safe", True)):
        flock = Flock(model, start=pair((0.0, 1.0, 0.0)), world=SKY, d_0=0.0, rng=1)
        flock.run(1)
        assert (flock.heading[0, 1] < -0.1) == turns


def test_a_turn_is_at_most_12_degrees_a_tick_and_speed_gains_a_tenth():
    begin = pair((0.0, 3.0, 0.0))
    begin["speed"] = [1.0, 3.0]
    flock = Flock("thesis", start=begin, world=SKY, alpha=270.0, rng=1)
    flock.run(1)
    assert np.degrees(np.arccos(flock.heading[0, 0])) == pytest.approx(12.0)
    assert flock.speed == pytest.approx([1.1, 3.0])


def test_a_wall_ahead_turns_an_agent_round_and_one_behind_does_nothing():
    ahead = {"position": [(11.0, 6.0, 6.0)], "heading": [(0.8, 0.6, 0.0)], "speed": [1.0]}
    flock = Flock("thesis", start=ahead, world=ROOM, v0=1.0, gain=1000.0, rng=1)
    flock.run(30)
    assert flock.heading[0, 0] < 0.0
    assert flock.position[:, 0].max() < 11.7
    away = {"position": [(11.0, 10.0, 6.0)], "heading": [(-1.0, 0.0, 0.0)], "speed": [1.0]}
    flock = Flock("thesis", start=away, world=ROOM, v0=1.0, Q=1.2, rng=1)
    flock.run(1)
    np.testing.assert_array_equal(flock.heading, [(-1.0, 0.0, 0.0)])


def test_safe_zones_pass_each_other_head_on():
    flock = Flock("safe", start=pair((4.0, 0.1, 0.0), other=(-1.0, 0.0, 0.0)), world=SKY, rng=1)
    flock.run(30)
    assert len(flock.crashes) == 0
    flock = Flock(
        "safe", start=pair((4.0, 0.1, 0.0), other=(-1.0, 0.0, 0.0)), world=SKY, rng=1, t_s=0.0,
        d_r=0.05, alpha=0.0,
    )  # fmt: skip
    flock.run(30)
    assert len(flock.crashes) == 2


@pytest.mark.parametrize(
    "activation",
    ["synchronous", pytest.param("random", marks=pytest.mark.exhaustive), "sequential"],
)
@pytest.mark.parametrize("dim", [2, pytest.param(3, marks=pytest.mark.exhaustive)])
def test_both_activations_run_in_flat_and_solid_worlds(activation, dim):
    world = World(name="sky", size=(24.0,) * dim, edges=("wrap",) * dim)
    flock = Flock("safe", agents=20, world=world, activation=activation, rng=3)
    flock.run(200)
    assert np.isfinite(flock.position).all()
    np.testing.assert_allclose(np.linalg.norm(flock.heading, axis=1), 1.0, atol=1e-9)


def test_the_thesis_gathers_most_of_its_flock_and_the_safe_zones_do_not_crash():
    share, late = [], 0
    for seed in range(1, 9):
        flock = Flock("thesis", rng=seed)
        flock.run(3000)
        share.append(flock.observe("largest-group") / flock.active.sum())
        assert flock.observe("polarisation") > 0.9
        careful = Flock("safe", rng=seed)
        careful.run(1500)
        late += int((careful.crashes.tick > 100).sum())
    assert np.mean(share) > 0.85  # 0.98 +- 0.01 over 40 seeds
    assert late <= 2  # none over 40 seeds
