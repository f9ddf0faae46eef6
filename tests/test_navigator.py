"""The navigating UAV of Liu et al. 2021, sections 2.3 and 2.4, against its oracle."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import navigation, noise
from oracles import vicsek_family as family
from oracles.topology import contact, layers

from agents import Flock
from worlds.obstacles import Disc, Polygon, Wall
from worlds.queries.clearance import clearance
from worlds.world import World

OBSTACLES = (
    Disc(centre=(2.0, 2.0), radius=0.6),
    Wall(start=(-1.0, 0.2), end=(1.5, 0.4), thickness=0.3),
    Polygon(points=((3.2, 0.4), (4.2, 0.9), (3.6, 1.9), (3.4, 1.1))),
)
MODELS = ("vem-a-nav", "ivem-a-nav", "wvem-nav", "hwvem-nav")


def place(*obstacles, edges="open"):
    return World("test", (10.0, 10.0), (edges, edges), low=(-2.0, -2.0), obstacles=obstacles)


def outline():
    from shapely import union_all

    discs = tuple((one.centre, one.radius) for one in OBSTACLES if isinstance(one, Disc))
    straight = [one.footprint() for one in OBSTACLES if not isinstance(one, Disc)]
    return navigation.Area(union_all(straight), discs)


def random_start(seed, n, spread):
    rng = np.random.default_rng(seed)
    world = place(*OBSTACLES)
    position = rng.uniform([-1.5, -1.5], [5.0, 3.0], (400, 2))
    free = clearance(world, position)
    position = position[(free > 0.02) & (free < spread)][:n]
    angle = rng.uniform(0.0, math.tau, len(position))
    return {
        "position": position,
        "heading": np.c_[np.cos(angle), np.sin(angle)],
        "informed": np.arange(len(position)) == 0,
    }


def state_of(flock, model):
    n = len(flock.ids)
    layer = np.full(n, n + 1)
    if model != "ivem-a-nav" and "layer" in flock.model.columns:
        layer = flock.signal("layer").astype(int)
    return family.State(flock.position.copy(), flock.heading.copy(), layer, flock.informed.copy())


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("guard", [True, False])
@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 14), st.sampled_from((0.3, 0.6, 2.0)))
def test_every_tick_is_the_papers(model, guard, seed, n, spread):
    flock = Flock(
        model, start=random_start(seed, n, spread), world=place(*OBSTACLES), rng=5, guard=guard
    )
    p = navigation.Navigation(family.Parameters(v0=0.1, eta=0.1), guard=guard)
    area = outline()
    for _ in range(6):
        before = state_of(flock, model)
        heard = flock.signal("heard") == 1.0
        touch = contact(before.position, 1.0, (1, 1), "open")
        if model == "wvem-nav":
            before = family.State(
                before.position, before.heading, layers(touch, before.informed), before.informed
            )
        assume(clear_of_thresholds(model, before, heard, touch, area, p))
        turn = noise.turns(5, flock.tick, flock.ids, 0.1)
        position, heading, hears, layer = navigation.step(model, before, heard, area, p, turn)
        if guard and area.meets(before.position[0], position[0]):
            return  # what is solid holds the information UAV too: tests/test_solid_walls.py
        flock.run(1)
        np.testing.assert_allclose(flock.position, position, atol=1e-9)
        np.testing.assert_allclose(flock.heading, heading, atol=1e-9)
        assert (flock.signal("heard") == hears).all()
        if model == "hwvem-nav":
            assert (flock.signal("layer") == layer).all()


def clear_of_thresholds(model, state, heard, touch, area, p):
    """Whether no decision of the tick hangs on the last bits of a number."""
    gaps = np.linalg.norm(state.position[:, None] - state.position[None], axis=2)
    near = min(abs(gaps - bound).min() for bound in (1.0, 0.7))
    ok = near > 1e-6
    for i in range(len(heard)):
        surface = navigation.nearest(area, state.position[i])
        ok &= abs(surface.distance - p.r_avoid) > 1e-6
        ok &= abs(surface.distance - p.r_avoid / 2) > 1e-6
        ok &= abs(surface.distance) > 1e-6
        tangent = np.array([-surface.away[1], surface.away[0]])
        ok &= abs(tangent @ state.heading[i]) > 1e-6
        weight = touch[i] & heard
        if weight.any() and not state.informed[i]:
            mean = state.heading[weight].sum(axis=0)
            ok &= math.hypot(*mean) > 1e-3
    if model == "ivem-a-nav":
        theta = np.array([family.angle(u) for u in state.heading])
        apart = np.abs(theta[:, None] - theta[None]) + np.eye(len(theta))
        ok &= apart.min() > 1e-6 and np.minimum(theta, math.tau - theta).min() > 1e-6
    return bool(ok)


def lone(position, angle, *obstacles, **given):
    start = {
        "position": [position],
        "heading": [[math.cos(angle), math.sin(angle)]],
    }
    return Flock("hwvem-nav", start=start, world=place(*obstacles), rng=1, eta=0.0, **given)


WALL = Wall(start=(3.0, -1.0), end=(3.0, 6.0), thickness=0.2)


@pytest.mark.parametrize("angle", [0.4, -0.4, 1.2])
def test_a_wall_ahead_is_followed_along_the_tangent_nearer_to_the_heading(angle):
    flock = lone((2.5, 2.0), angle, WALL)
    flock.run(1)
    np.testing.assert_allclose(flock.heading[0], [0.0, math.copysign(1.0, angle)], atol=1e-12)
    assert flock.signal("heard")[0] == 0.0


def test_a_wall_further_than_r_avoid_is_not_noticed():
    flock = lone((2.3, 2.0), 0.4, WALL)
    flock.run(1)
    np.testing.assert_allclose(flock.heading[0], [math.cos(0.4), math.sin(0.4)], atol=1e-12)
    assert flock.signal("heard")[0] == 1.0


def test_a_wall_behind_is_left_alone():
    flock = lone((2.5, 2.0), 2.9, WALL)
    flock.run(1)
    np.testing.assert_allclose(flock.heading[0], [math.cos(2.9), math.sin(2.9)], atol=1e-12)


def test_at_a_corner_there_is_no_tangent_and_nothing_is_done():
    corner = Polygon(points=((3.0, 2.0), (4.0, 1.0), (4.0, 3.0)))
    flock = lone((2.7, 2.0), 0.1, corner, guard=False)
    flock.run(1)
    np.testing.assert_allclose(flock.heading[0], [math.cos(0.1), math.sin(0.1)], atol=1e-12)
    assert flock.signal("heard")[0] == 1.0


def test_the_literal_text_takes_an_agent_through_a_corner_and_the_guard_does_not():
    corner = Polygon(points=((3.0, 2.0), (4.0, 1.0), (4.0, 3.0)))
    free = lone((2.65, 2.0), 0.0, corner, guard=False)
    assert clearance(free.world, free.trace(8)[:, 0]).min() < -0.05
    guarded = lone((2.7, 2.0), 0.0, corner)
    assert clearance(guarded.world, guarded.trace(50)[:, 0]).min() > 0.0


def test_repulsion_and_attraction_meet_at_r_rep():
    """Two agents at rest relative to each other settle at the distance where both vanish."""
    start = {"position": [[0.0, 0.0], [0.0, 0.9]], "heading": [[1.0, 0.0], [1.0, 0.0]]}
    flock = Flock("hwvem-nav", start=start, world="open", size=10.0, rng=1, eta=0.0, c_att=0.05)
    flock.run(300)
    assert np.linalg.norm(flock.position[1] - flock.position[0]) == pytest.approx(0.7, abs=1e-3)


def test_no_speed_is_above_v0():
    flock = Flock("hwvem-nav", agents=49, rng=3)
    for _ in range(30):
        flock.run(5)
        assert flock.speed.max() <= 0.1 + 1e-12


@pytest.mark.parametrize("model", MODELS)
def test_no_agent_is_ever_inside_an_obstacle(model):
    flock = Flock(model, agents=19, rng=11)
    trace = flock.trace(640)
    assert clearance(flock.world, trace.reshape(-1, 2)).min() > 0.0


def test_the_information_agent_passes_every_waypoint():
    flock = Flock("hwvem-nav", agents=4, rng=2)
    path = np.array(flock.world.mission.path.waypoints)
    trace = flock.trace(640)[:, 0]
    for waypoint in path:
        assert np.linalg.norm(trace - waypoint, axis=1).min() <= flock.world.mission.path.switch
    assert flock.arrays.leg[0] == len(path)
    np.testing.assert_allclose(np.linalg.norm(np.diff(trace, axis=0), axis=1), 0.1, atol=1e-12)
