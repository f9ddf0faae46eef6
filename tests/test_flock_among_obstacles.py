"""The engine in worlds where something is solid: bouncing, traces, changes, saved states."""

import dataclasses
import math

import numpy as np
import pytest

from agents import Flock
from agents.spec import Spec
from worlds.input_error import InputError
from worlds.layout import world
from worlds.mission import Goal, Mission, Path
from worlds.obstacles import Disc, Wall
from worlds.queries.clearance import clearance
from worlds.world import World


def room(*obstacles, edges="solid", mission=None):
    return World("room", (10.0, 10.0), (edges, edges), obstacles=obstacles, mission=mission)


def lone(world, position, angle, **given):
    start = {"position": [position], "heading": [[math.cos(angle), math.sin(angle)]]}
    return Flock("vem", start=start, world=world, rng=1, v0=0.1, **given)


def test_an_agent_bounces_off_a_solid_edge_like_light():
    flock = lone(room(), (9.95, 5.0), math.pi / 6)
    flock.run(1)
    x = 9.95 + 0.1 * math.cos(math.pi / 6)
    np.testing.assert_allclose(flock.position[0], [20.0 - x, 5.05], atol=1e-12)
    np.testing.assert_allclose(flock.heading[0], [-math.cos(math.pi / 6), 0.5], atol=1e-12)


def test_an_agent_bounces_back_from_a_corner_of_the_box():
    flock = lone(room(), (9.99, 9.98), math.pi / 4)
    flock.run(1)
    step = 0.1 * math.sqrt(0.5)
    np.testing.assert_allclose(flock.position[0], [20 - 9.99 - step, 20 - 9.98 - step], atol=1e-12)
    np.testing.assert_allclose(flock.heading[0], [-math.sqrt(0.5)] * 2, atol=1e-12)


def test_an_agent_that_meets_a_wall_head_on_comes_straight_back():
    flock = lone(room(Wall(start=(5.0, 2.0), end=(5.0, 8.0), thickness=1.0)), (4.44, 5.0), 0.0)
    flock.run(1)
    np.testing.assert_allclose(flock.position[0], [4.46, 5.0], atol=1e-12)
    np.testing.assert_allclose(flock.heading[0], [-1.0, 0.0], atol=1e-12)


@pytest.mark.parametrize("model", ["vem", pytest.param("hwvem", marks=pytest.mark.exhaustive)])
@pytest.mark.parametrize("world", ["obstacles", "corridor"])
def test_a_flock_that_does_not_see_obstacles_never_ends_a_tick_inside_one(model, world):
    flock = Flock(model, agents=150, world=world, rng=4, eta=0.5, v0=0.2)
    for _ in range(60):
        flock.run(5)
        assert clearance(flock.world, flock.position).min() >= 0.0
    np.testing.assert_allclose(np.linalg.norm(flock.heading, axis=1), 1.0, atol=1e-12)


@pytest.mark.exhaustive
def test_in_three_dimensions_too():
    flock = Flock("vem", agents=100, world="rooms-3d", rng=4, eta=0.5, v0=0.2)
    assert flock.world.dim == 3
    for _ in range(40):
        flock.run(5)
        assert clearance(flock.world, flock.position).min() >= 0.0


def test_no_agent_starts_inside_an_obstacle():
    flock = Flock("vem", agents=500, world="obstacles", rng=8)
    assert clearance(flock.world, flock.position).min() > 0.0


def test_a_start_without_room_is_refused_in_one_line():
    full = room(Disc(centre=(5.0, 5.0), radius=9.0))
    with pytest.raises(InputError, match=r"agents = 5 do not fit .* outside the obstacles of room"):
        Flock("vem", agents=5, world=full, rng=1)


def test_a_trace_is_what_single_steps_give():
    one, other = (Flock("hwvem-nav", agents=19, rng=6) for _ in range(2))
    trace = one.trace(25)
    for tick in range(25):
        other.step()
        assert np.array_equal(other.position, trace[tick])
    assert one.tick == 25


@pytest.mark.parametrize("activation", ["synchronous", "sequential", "random"])
def test_member_by_member_is_the_same_tick(activation):
    whole, single = (Flock("hwvem-nav", agents=9, rng=6, activation=activation) for _ in range(2))
    for _ in range(20):
        whole.run(1)
        order = range(10) if activation == "synchronous" else single.engine.order(single.tick)
        for row in order:
            single.members[row].step()
        assert np.array_equal(whole.position, single.position)
        assert np.array_equal(whole.signals(), single.signals())


def test_threads_do_not_change_a_bit_among_obstacles():
    rng = np.random.default_rng(2)
    place = rng.uniform([0.0, 0.0], [60.0, 40.0], (18_000, 2))
    place = place[clearance(world("obstacles"), place) > 0.0][:14_000]
    angle = rng.uniform(0.0, math.tau, len(place))
    start = {"position": place, "heading": np.c_[np.cos(angle), np.sin(angle)]}
    one, two = (
        Flock("hwvem-nav", start=start, world="obstacles", rng=2, threads=threads)
        for threads in (1, 2)
    )
    one.run(3)
    two.run(3)
    assert np.array_equal(one.position, two.position)
    assert np.array_equal(one.heading, two.heading)


def test_a_saved_mission_goes_on_to_the_bit(tmp_path):
    flock = Flock("hwvem-nav", agents=19, rng=3)
    flock.run(200)
    flock.save(tmp_path / "half.parquet")
    again = Flock.load(tmp_path / "half.parquet")
    flock.run(150)
    again.run(150)
    assert np.array_equal(flock.position, again.position)
    assert flock.arrays.leg[0] == again.arrays.leg[0] > 0


def test_a_changed_world_is_part_of_the_run():
    flock = Flock("hwvem-nav", agents=9, rng=3)
    wall = Wall(start=(6.0, 5.0), end=(6.0, 7.0), thickness=0.3)
    more = dataclasses.replace(
        flock.world, name="with a wall", obstacles=(*flock.world.obstacles, wall)
    )
    flock.change_world(more)
    spec = Spec.from_toml(flock.spec.to_toml())
    assert spec.layout is not None
    again = Flock.from_spec(spec)
    assert again.world == flock.world
    flock.run(120)
    again.run(120)
    assert np.array_equal(flock.position, again.position)


def test_a_change_that_changes_nothing_changes_no_bit():
    one, other = (Flock("hwvem-nav", agents=9, rng=3) for _ in range(2))
    one.run(100)
    one.change_world(dataclasses.replace(one.world))
    one.run(100)
    other.run(200)
    assert np.array_equal(one.position, other.position)


def test_a_flock_keeps_its_dimensions():
    flock = Flock("hwvem-nav", agents=9, rng=3)
    with pytest.raises(InputError, match="2-D flock cannot go on in a 3-D world"):
        flock.change_world(Flock("vem", world="rooms-3d", rng=1).world)


def test_the_information_agent_goes_round_a_closed_path():
    corners = ((3.0, 3.0), (7.0, 3.0), (7.0, 7.0), (3.0, 7.0))
    path = Path(waypoints=corners, switch=0.2, closed=True)
    start = {"position": [[3.0, 5.0]], "heading": [[1.0, 0.0]], "informed": [True]}
    flock = Flock(
        "hwvem-nav", start=start, world=room(edges="open", mission=Mission(path=path)), rng=1
    )
    trace = flock.trace(400)[:, 0]
    for corner in corners:
        visits = np.linalg.norm(trace - corner, axis=1) <= 0.2
        assert np.count_nonzero(np.diff(visits.astype(int)) == 1) >= 2
    assert trace.min() > 2.7
    assert trace.max() < 7.3


@pytest.mark.parametrize("closed", [False, True])
def test_the_goal_goes_along_its_route(closed):
    route = ((1.0, 1.0), (4.0, 1.0), (4.0, 3.0))
    mission = Mission(goal=Goal(route=route, speed=0.5, closed=closed))
    flock = Flock("vem", agents=3, world=room(edges="open", mission=mission), rng=1)
    np.testing.assert_allclose(flock.goal_at([0, 2, 6, 8]), [[1, 1], [2, 1], [4, 1], [4, 2]])
    total = 5.0 + math.hypot(3.0, 2.0)
    end = flock.goal_at([10 + 2 * total])[0]
    if closed:
        np.testing.assert_allclose(flock.goal_at([2 * total + 2])[0], [2.0, 1.0])
    else:
        np.testing.assert_allclose(end, [4.0, 3.0])
    flock.run(9)
    np.testing.assert_allclose(flock.engine.surroundings.goal[0, :2], flock.goal_at([8])[0])


def test_a_goal_that_is_not_there_is_named():
    with pytest.raises(InputError, match="the world 'wrap' has no goal"):
        Flock("vem", agents=3, rng=1).goal_at([0])
