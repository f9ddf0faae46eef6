"""The drones of Vasarhelyi et al. 2018 against their oracle, in exact cases and among obstacles."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import solids
from oracles import vasarhelyi as oracle
from oracles.scenes import unit_vectors

from agents import Flock
from agents.engine.cache import kept
from agents.rules.vasarhelyi import braking
from worlds.obstacles import Disc, Polygon, Sphere
from worlds.queries.clearance import clearance
from worlds.world import World

SIDE = 80.0
FLAT = (
    Polygon(points=((20.0, 20.0), (32.0, 24.0), (22.0, 38.0))),
    Disc(centre=(55.0, 50.0), radius=9.0),
)
ROUND = (
    Sphere(centre=(25.0, 30.0, 40.0), radius=8.0),
    Sphere(centre=(60.0, 50.0, 20.0), radius=11.0),
)


@kept
def curve(r, a, p):
    return braking(r, a, p)


def room(dim, scale=1.0, shapes=True):
    """A room of SIDE with solid edges and, if wanted, obstacles; and the same for the oracle."""
    low, high = np.zeros(dim), np.full(dim, SIDE * scale)
    found = solids.box(low, high)
    given = ()
    if shapes and dim == 2:
        a, b = FLAT
        a = Polygon(points=tuple((scale * x, scale * y) for x, y in a.points))
        b = Disc(centre=tuple(scale * c for c in b.centre), radius=scale * b.radius)
        given = (a, b)
        found += [solids.flat(one) for one in given]
    elif shapes:
        given = tuple(
            Sphere(centre=tuple(scale * c for c in s.centre), radius=scale * s.radius)
            for s in ROUND
        )
        found += [solids.sphere(s.centre, s.radius) for s in given]
    return World("room", tuple(high), ("solid",) * dim, obstacles=given), found


def start(seed, n, world, dim, fastest):
    """n drones somewhere free, of any speed up to the fastest."""
    rng = np.random.default_rng(seed)
    position = rng.uniform(0.0, world.size[0], (40 * n, dim))
    position = position[clearance(world, position) > 0.0][:n]
    return {
        "position": position,
        "heading": unit_vectors(rng, n, dim),
        "speed": rng.uniform(0.0, fastest, n),
    }


def velocity(flock):
    return flock.speed[:, None] * flock.heading


@settings(deadline=None)
@given(a=st.floats(0.1, 20.0), p=st.floats(0.1, 10.0), v=st.floats(0.0, 30.0))
def test_braking_curve_is_the_speed_that_stops_in_the_distance(a, p, v):
    soft = a / p  # the speed below which it slows down exponentially
    distance = min(v, soft) / p + max(0.0, v**2 - soft**2) / (2 * a)
    assert curve(distance, a, p) == pytest.approx(v, abs=1e-9, rel=1e-9)


def test_braking_curve_starts_at_nothing_and_is_smooth_where_its_parts_meet():
    a, p = 4.16, 3.2
    assert [curve(r, a, p) for r in (-50.0, -1e-9, 0.0)] == [0.0, 0.0, 0.0]
    meet, e = a / p**2, 1e-6
    assert curve(meet, a, p) == pytest.approx(a / p, rel=1e-12)
    before = (curve(meet, a, p) - curve(meet - e, a, p)) / e
    after = (curve(meet + e, a, p) - curve(meet, a, p)) / e
    assert before == pytest.approx(p, rel=1e-5)
    assert after == pytest.approx(p, rel=1e-5)
    assert curve(10.0, a, p) == pytest.approx(math.sqrt(2 * a * 10.0 - (a / p) ** 2))


@pytest.mark.parametrize("dim", [2, pytest.param(3, marks=pytest.mark.exhaustive)])
@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 12),
    r=st.sampled_from((12.0, 30.0, 100.0)),
    r0_frict=st.sampled_from((5.0, 20.0, 85.3)),
    a_frict=st.sampled_from((0.3, 4.16)),
)
def test_every_tick_is_the_oracles(dim, seed, n, r, r0_frict, a_frict):
    world, found = room(dim)
    given = {"r": r, "r0_frict": r0_frict, "a_frict": a_frict, "c_frict": 0.3}
    p = oracle.Setting(**given)
    flock = Flock(
        "vasarhelyi",
        start=start(seed, n, world, dim, p.v_max),
        world=world,
        guard=False,
        **given,
    )
    for _ in range(3):
        x, v = oracle.step(flock.position, flock.heading, flock.speed, found, p)
        flock.run(1)
        np.testing.assert_allclose(flock.position, x, rtol=0, atol=1e-9)
        np.testing.assert_allclose(velocity(flock), v, rtol=0, atol=1e-9)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_forces_shown_are_the_oracles(dim):
    world, found = room(dim)
    flock = Flock("vasarhelyi", start=start(9, 12, world, dim, 6.0), world=world)
    flock.run(1)
    v = velocity(flock)
    largest = np.zeros(4)
    for row in range(12):
        expected = oracle.terms(row, flock.position, v, flock.heading, found, oracle.Setting())
        shown = flock.inspect(row).forces
        assert list(shown) == ["self-propulsion", "repulsion", "alignment", "shill"]
        np.testing.assert_allclose(list(shown.values()), expected, atol=1e-9)
        largest = np.maximum(largest, np.linalg.norm(expected, axis=1))
    assert largest.min() > 0.1


def test_a_lone_drone_takes_up_v_flock_along_its_heading():
    first = {"position": [[1.0, 2.0]], "heading": [[0.6, 0.8]], "speed": [0.0]}
    flock = Flock("vasarhelyi", start=first, world="open", size=10.0)
    flock.run(1)
    assert flock.speed[0] == pytest.approx(0.1 * 4.0, rel=1e-12)
    flock.run(399)
    assert flock.speed[0] == pytest.approx(4.0, rel=1e-12)
    way = flock.position[0] - [1.0, 2.0]
    assert way / np.linalg.norm(way) == pytest.approx([0.6, 0.8], rel=1e-12)


def test_two_drones_push_each_other_apart_alike():
    first = {
        "position": [[-3.0, 0.0], [3.0, 0.0]],
        "heading": [[0.0, 1.0], [0.0, 1.0]],
        "speed": [2.0, 2.0],
    }
    flock = Flock("vasarhelyi", start=first, world="open", size=10.0, v_max=50.0, a_max=50.0)
    flock.run(1)
    v = velocity(flock)
    push = 0.13 * (25.6668 - 6.0)
    assert v[:, 0] == pytest.approx([-0.1 * push, 0.1 * push], rel=1e-12)
    assert v[:, 1] == pytest.approx([2.2, 2.2], rel=1e-12)
    flock.run(300)
    assert flock.position[0] * [-1.0, 1.0] == pytest.approx(flock.position[1], rel=1e-9)
    assert flock.position[1, 0] - flock.position[0, 0] > 20.0


def test_a_difference_within_the_slack_is_left_alone():
    first = {
        "position": [[0.0, 0.0], [30.0, 0.0]],
        "heading": [[0.0, 1.0], [0.0, 1.0]],
        "speed": [4.0, 4.0],
    }
    for other, changed in ((4.62, False), (4.64, True)):
        flock = Flock("vasarhelyi", start={**first, "speed": [4.0, other]}, world="open", size=9.0)
        flock.run(1)
        assert (flock.speed[0] != 4.0) == changed


@pytest.mark.parametrize("dim", [2, 3])
def test_a_turned_scene_gives_a_turned_flight(dim):
    world = World("space", (SIDE,) * dim, ("open",) * dim)
    first = start(4, 15, world, dim, 6.0)
    turn, _ = np.linalg.qr(np.random.default_rng(8).normal(size=(dim, dim)))
    turned = {**first, "position": first["position"] @ turn.T, "heading": first["heading"] @ turn.T}
    straight = Flock("vasarhelyi", start=first, world=world)
    other = Flock("vasarhelyi", start=turned, world=world)
    straight.run(30)
    other.run(30)
    np.testing.assert_allclose(other.position, straight.position @ turn.T, atol=1e-8)


def test_a_flight_at_a_tenth_of_the_scale_is_the_same_flight():
    scale = 0.1
    large, _ = room(2)
    small, _ = room(2, scale)
    first = start(2, 10, large, 2, 6.0)
    one = Flock("vasarhelyi", start=first, world=large)
    first = {**first, "position": scale * first["position"], "speed": scale * first["speed"]}
    other = Flock("vasarhelyi-tenth", start=first, world=small)
    one.run(100)
    other.run(100)
    np.testing.assert_allclose(other.position, scale * one.position, atol=1e-7)


def test_speed_and_acceleration_stay_within_the_drones_limits():
    world, _ = room(2)
    flock = Flock("vasarhelyi", start=start(1, 25, world, 2, 6.0), world=world, guard=False)
    hardest = 0.0
    for _ in range(200):
        before = velocity(flock)
        flock.run(1)
        hardest = max(hardest, np.linalg.norm(velocity(flock) - before, axis=1).max() / 0.1)
        assert flock.speed.max() <= 6.0 * (1 + 1e-12)
    assert hardest <= 6.0 * (1 + 1e-9)
    assert hardest > 5.9  # they were pushed to it


@pytest.mark.parametrize("dim", [2, 3])
def test_no_drone_enters_what_is_solid(dim):
    world, _ = room(dim)
    flock = Flock("vasarhelyi", start=start(3, 25, world, dim, 6.0), world=world)
    least = math.inf
    for _ in range(400):
        flock.run(5)
        least = min(least, clearance(world, flock.position).min())
    assert least > 0.0


def test_drones_come_to_fly_as_a_flock():
    world = World("field", (250.0, 250.0), ("solid", "solid"))
    flock = Flock("vasarhelyi", agents=30, world=world, rng=1)
    flock.run(3000)
    polarisation = []
    for _ in range(20):
        flock.run(50)
        polarisation.append(flock.observe("polarisation"))
    assert np.mean(polarisation) > 0.9
