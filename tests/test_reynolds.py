"""Reynolds' boids against their oracle, in exact cases and among obstacles."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import reynolds as oracle
from oracles import solids
from oracles.scenes import unit_vectors

from agents import Flock
from worlds.mission import Goal, Mission
from worlds.obstacles import Disc, Polygon, Sphere
from worlds.queries.clearance import clearance
from worlds.world import World

SIDE = 16.0
FLAT = (
    Polygon(points=((3.0, 3.0), (6.0, 3.5), (4.0, 7.0))),
    Disc(centre=(11.0, 10.0), radius=2.0),
)
ROUND = (
    Sphere(centre=(5.0, 6.0, 8.0), radius=2.0),
    Sphere(centre=(11.0, 10.0, 4.0), radius=2.5),
)
GOAL = (12.0, 3.0, 5.0)


def room(dim, goal=False):
    """A room with solid edges and obstacles; and the same for the oracle."""
    found = solids.box(np.zeros(dim), np.full(dim, SIDE))
    if dim == 2:
        found += [solids.flat(one) for one in FLAT]
    else:
        found += [solids.sphere(s.centre, s.radius) for s in ROUND]
    mission = Mission(goal=Goal(route=(GOAL[:dim],))) if goal else None
    shapes = FLAT if dim == 2 else ROUND
    return World("room", (SIDE,) * dim, ("solid",) * dim, obstacles=shapes, mission=mission), found


def start(seed, n, world, dim):
    """n boids somewhere free, some slower than they may be and some faster."""
    rng = np.random.default_rng(seed)
    position = rng.uniform(0.0, SIDE, (40 * n, dim))
    position = position[clearance(world, position) > 0.0][:n]
    return {
        "position": position,
        "heading": unit_vectors(rng, n, dim),
        "speed": rng.uniform(0.0, 3.5, n),
    }


def velocity(flock):
    return flock.speed[:, None] * flock.heading


@pytest.mark.parametrize("dim", [2, 3])
@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 14),
    fov=st.sampled_from((60.0, 200.0, 270.0, 360.0)),
    r=st.sampled_from((2.0, 5.0)),
    goal=st.booleans(),
)
def test_every_tick_is_the_oracles(dim, seed, n, fov, r, goal):
    world, found = room(dim, goal)
    p = oracle.Setting(fov=fov, r=r)
    first = start(seed, n, world, dim)
    flock = Flock("reynolds", start=first, world=world, guard=False, fov=fov, r=r)
    aim = np.array(GOAL[:dim]) if goal else None
    for _ in range(3):
        x, v = oracle.step(flock.position, flock.heading, flock.speed, found, aim, p)
        flock.run(1)
        np.testing.assert_allclose(flock.position, x, rtol=0, atol=1e-9)
        np.testing.assert_allclose(velocity(flock), v, rtol=0, atol=1e-8)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_forces_shown_are_the_oracles(dim):
    world, found = room(dim, goal=True)
    flock = Flock("reynolds", start=start(9, 60, world, dim), world=world)
    flock.run(1)
    state = flock.position, flock.heading, flock.speed, found, np.array(GOAL[:dim])
    seen = dict.fromkeys(flock.inspect(0).forces, 0.0)
    for row in range(60):
        expected = oracle.terms(row, *state, oracle.Setting())
        shown = flock.inspect(row).forces
        np.testing.assert_allclose(list(shown.values()), expected, atol=1e-9)
        seen = {name: seen[name] + np.abs(force).sum() for name, force in shown.items()}
    assert list(seen) == ["separation", "alignment", "cohesion", "avoidance", "seek"]
    assert min(seen.values()) > 0.0


def test_a_lone_boid_goes_straight():
    first = {"position": [[1.0, 2.0]], "heading": [[0.6, 0.8]], "speed": [2.0]}
    flock = Flock("reynolds", start=first, world="open", size=10.0)
    flock.run(100)
    assert flock.position[0] == pytest.approx([1.0 + 0.6 * 10.0, 2.0 + 0.8 * 10.0], rel=1e-12)
    assert flock.speed[0] == pytest.approx(2.0, rel=1e-12)


def test_of_two_in_a_row_only_the_one_behind_sees_the_other():
    first = {
        "position": [[0.0, 0.0], [4.0, 0.0]],
        "heading": [[1.0, 0.0], [1.0, 0.0]],
        "speed": [2.0, 2.0],
    }
    flock = Flock("reynolds", start=first, world="open", size=10.0, w_alignment=0.0)
    flock.run(1)
    pull = 8.0 * 0.6 * 4.0 / 5.0  # max_force, weight, distance over r_cohesion
    assert flock.speed == pytest.approx([2.0 + 0.05 * pull, 2.0], rel=1e-12)


def test_alignment_takes_up_the_mean_velocity_of_those_in_view():
    first = {
        "position": [[0.0, 0.0], [2.0, 0.0]],
        "heading": [[1.0, 0.0], [0.0, 1.0]],
        "speed": [2.5, 2.5],
    }
    alone = {"w_separation": 0.0, "w_cohesion": 0.0, "w_alignment": 0.5}
    flock = Flock("reynolds", start=first, world="open", size=10.0, fov=360.0, **alone)
    flock.run(1)
    force = 8.0 * 0.5 * np.array([-2.5, 2.5]) / 4.0  # max_force, weight, difference over max_speed
    np.testing.assert_allclose(velocity(flock)[0], [2.5, 0.0] + 0.05 * force, rtol=1e-12)
    np.testing.assert_allclose(velocity(flock)[1], [0.0, 2.5] - 0.05 * force, rtol=1e-12)


def test_close_boids_part():
    first = {
        "position": [[0.0, 0.0], [0.5, 0.0]],
        "heading": [[0.0, 1.0], [0.0, 1.0]],
        "speed": [2.0, 2.0],
    }
    flock = Flock("reynolds", start=first, world="open", size=10.0, w_cohesion=0.0)
    flock.run(1)
    assert velocity(flock)[:, 0] == pytest.approx([-0.05 * 8.0, 0.05 * 8.0], rel=1e-12)
    flock.run(100)
    assert flock.position[1, 0] - flock.position[0, 0] > 1.5


def test_a_boid_heading_straight_for_a_wall_turns_aside():
    world = World("hall", (40.0, 40.0), ("solid", "solid"))
    first = {"position": [[30.0, 20.0]], "heading": [[1.0, 0.0]], "speed": [3.0]}
    flock = Flock("reynolds", start=first, world=world, guard=False)
    nearest = math.inf
    for _ in range(200):
        flock.run(1)
        nearest = min(nearest, clearance(world, flock.position)[0])
    assert nearest > 0.4
    assert flock.position[0, 1] > 25.0


@pytest.mark.parametrize("dim", [2, 3])
def test_a_turned_scene_gives_a_turned_flight(dim):
    world = World("space", (SIDE,) * dim, ("open",) * dim)
    rng = np.random.default_rng(5)
    position, heading = rng.uniform(0, 6, (15, dim)), unit_vectors(rng, 15, dim)
    turn, _ = np.linalg.qr(rng.normal(size=(dim, dim)))
    one = Flock("reynolds", start={"position": position, "heading": heading}, world=world)
    turned = {"position": position @ turn.T, "heading": heading @ turn.T}
    other = Flock("reynolds", start=turned, world=world)
    one.run(20)
    other.run(20)
    np.testing.assert_allclose(other.position, one.position @ turn.T, atol=1e-8)


def test_speed_and_force_stay_within_their_limits():
    world, _ = room(2)
    flock = Flock("reynolds", start=start(1, 30, world, 2), world=world, guard=False)
    for _ in range(200):
        flock.run(1)
        assert flock.speed.min() >= 2.0 * (1 - 1e-12)
        assert flock.speed.max() <= 4.0 * (1 + 1e-12)
    free = Flock("reynolds", agents=60, world="open", size=8.0, rng=2, min_speed=0.0)
    hardest = 0.0
    for _ in range(100):
        before = velocity(free)
        free.run(1)
        hardest = max(hardest, np.linalg.norm(velocity(free) - before, axis=1).max() / 0.05)
    assert 7.9 < hardest <= 8.0 * (1 + 1e-9)


@pytest.mark.parametrize("dim", [2, 3])
def test_no_boid_enters_what_is_solid(dim):
    world, _ = room(dim)
    flock = Flock("reynolds", start=start(3, 60, world, dim), world=world)
    least = math.inf
    for _ in range(1000):
        flock.run(2)
        least = min(least, clearance(world, flock.position).min())
    assert least > 0.0


def test_boids_come_to_fly_one_way_without_collisions():
    flock = Flock("reynolds", agents=100, world="wrap", size=40.0, rng=1)
    flock.run(2000)
    polarisation, least = [], math.inf
    for _ in range(20):
        flock.run(50)
        polarisation.append(flock.observe("polarisation"))
        offset = flock.position[:, None] - flock.position
        offset -= 40.0 * np.round(offset / 40.0)
        apart = np.linalg.norm(offset, axis=2)
        least = min(least, apart[apart > 0.0].min())
    assert np.mean(polarisation) > 0.9
    assert least > 0.5


def test_boids_seek_the_goal():
    goal = np.array([50.0, 10.0])
    mission = Mission(goal=Goal(route=(tuple(goal),)))
    world = World("plain", (60.0, 20.0), ("open", "open"), mission=mission)
    rng = np.random.default_rng(6)
    first = {"position": rng.uniform(4, 12, (20, 2)), "heading": unit_vectors(rng, 20, 2)}
    nearest = {}
    for w_seek in (0.0, 0.5):
        flock = Flock("reynolds", start=first, world=world, w_seek=w_seek)
        nearest[w_seek] = math.inf
        for _ in range(100):
            flock.run(10)
            away = np.linalg.norm(flock.position.mean(axis=0) - goal)
            nearest[w_seek] = min(nearest[w_seek], away)
    assert nearest[0.5] < 5.0
    assert nearest[0.0] > 15.0
