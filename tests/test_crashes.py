"""Crashes: who touches falls, lies, is counted with tick and place, and is no longer seen."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles.solids import box, sphere
from oracles.zones import touching

from agents import Flock
from agents.engine.solid_collision import GRAVITY
from agents.member import Member
from worlds.input_error import InputError
from worlds.obstacles import Box, Sphere
from worlds.world import World

SKY = World(name="sky", size=(20.0,) * 3, edges=("open",) * 3)
ROOM = World(
    name="room",
    size=(20.0,) * 3,
    edges=("solid",) * 3,
    obstacles=(Sphere(centre=(10.0, 10.0, 10.0), radius=2.0),),
)
TABLE = World(
    name="table",
    size=(20.0,) * 3,
    edges=("solid",) * 3,
    obstacles=(Box(low=(8.0, 8.0, 0.0), high=(12.0, 12.0, 4.0)),),
)


def at(position, heading=(1.0, 0.0, 0.0), speed=1.0):
    position = np.array(position, float)
    n = len(position)
    return {
        "position": position,
        "heading": np.tile(np.array(heading, float), (n, 1)),
        "speed": np.full(n, speed),
    }


def solitary(start, world=SKY, model="safe", **more):
    """Agents that take no notice of each other or of obstacles."""
    return Flock(
        model, start=start, world=world, rng=1, v0=1.0, d_r=0.05, d_o=0.05, d_a=5.0, alpha=0.0,
        gain=0.0, sigma=0.0, **({"t_s": 0.0} if model == "safe" else {}), **more,
    )  # fmt: skip


def towards_each_other():
    start = at([(5.0, 5.0, 5.0), (7.0, 5.0, 5.0), (5.0, 15.0, 5.0)])
    start["heading"][1] = (-1.0, 0.0, 0.0)
    return start


def test_two_that_meet_crash_at_the_tick_at_which_they_touch_and_nobody_else():
    flock = solitary(towards_each_other())
    flock.run(7)  # 2 apart, closing in by 0.2 a tick: 0.75 is passed in the seventh tick
    assert len(flock.crashes) == 0
    assert flock.active.all()
    flock.run(1)
    crashes = flock.crashes
    assert crashes.tick.tolist() == [7, 7]
    assert crashes.row.tolist() == [0, 1]
    assert crashes.cause.tolist() == [1, 1]
    np.testing.assert_allclose(crashes.place, [(5.7, 5.0, 5.0), (6.3, 5.0, 5.0)])
    assert flock.active.tolist() == [False, False, True]


@pytest.mark.parametrize("edges", ["open", "wrap"])
@pytest.mark.parametrize(
    ("dim", "activation"),
    [
        (2, "synchronous"),
        (3, "synchronous"),
        pytest.param(3, "random", marks=pytest.mark.exhaustive),
    ],
)
def test_two_at_the_very_same_place_crash_and_nobody_with_itself(dim, edges, activation):
    """Four on two spots, of which one at the seam, and one that is alone in a box of few cells."""
    world = World(name="box", size=(6.0,) * dim, edges=(edges,) * dim)
    spots = np.full((5, dim), 3.0)
    spots[2:4, 0], spots[4, 0] = 0.0, 5.0
    start = {"position": spots, "heading": np.tile(np.eye(dim)[0], (5, 1)), "speed": np.zeros(5)}
    start["heading"][1] = np.eye(dim)[1]  # who shares a place need not share a heading
    flock = solitary(start, world, activation=activation)
    flock.run(1)
    assert flock.active.tolist() == [False, False, False, False, True]
    assert flock.crashes.cause.tolist() == [1] * 4
    flock.run(3)
    assert flock.active.tolist() == [False, False, False, False, True]


def test_points_crash_only_where_they_coincide():
    flock = solitary(at([(5.0, 5.0, 5.0), (5.0, 5.0, 5.0), (5.0, 5.0, 5.001)], speed=0.0), body=0.0)
    flock.run(1)
    assert flock.active.tolist() == [False, False, True]


def test_crashed_agents_fall_freely_to_the_floor_and_lie():
    flock = solitary(at([(5.0, 5.0, 5.0), (5.5, 5.0, 5.0)]))
    flock.run(3)
    speed = np.cumsum(np.full(3, GRAVITY * 0.1))
    np.testing.assert_allclose(flock.position[:, 2], 5.0 - 0.1 * speed.sum())
    np.testing.assert_allclose(flock.speed, speed[-1])
    flock.run(20)
    np.testing.assert_array_equal(flock.position[:, 2], 0.0)
    np.testing.assert_array_equal(flock.speed, 0.0)
    np.testing.assert_array_equal(flock.position[:, 0], [5.0, 5.5])


def test_crashed_agents_come_to_rest_on_a_block():
    flock = solitary(at([(10.0, 10.0, 8.0), (10.4, 10.0, 8.0)]), TABLE)
    flock.run(40)
    np.testing.assert_allclose(flock.position[:, 2], 4.0, atol=0.01)
    assert (flock.position[:, 2] >= 4.0).all()


def test_in_two_dimensions_they_lie_where_they_crashed():
    world = World(name="plain", size=(20.0, 20.0), edges=("open", "open"))
    start = {"position": [(5.0, 5.0), (5.5, 5.0)], "heading": [(1.0, 0.0)] * 2, "speed": [1.0] * 2}
    flock = solitary(start, world)
    flock.run(5)
    np.testing.assert_array_equal(flock.position, start["position"])


def test_crashed_agents_are_no_longer_seen():
    def turned(with_wreck):
        places = [(5.0, 5.0, 5.0), (8.0, 6.0, 5.0)]
        start = at([*places, (8.4, 6.0, 5.0)] if with_wreck else places[:1])
        flock = Flock("thesis", start=start, world=SKY, rng=1, alpha=180.0, d_0=0.0)
        flock.run(1)  # the two touch at the start, and are seen in that tick only
        before = flock.heading[0].copy()
        flock.run(1)
        return bool(np.abs(flock.heading[0] - before).max() > 1e-9)

    seen = Flock("thesis", start=at([(5.0, 5.0, 5.0), (8.0, 6.0, 5.0)]), world=SKY, rng=1,
                 alpha=180.0, d_0=0.0)  # fmt: skip
    seen.run(2)
    assert seen.heading[0, 1] > 0.0
    assert not turned(True)
    assert not turned(False)


@pytest.mark.parametrize(
    ("place", "heading"),
    [
        ((18.9, 10.0, 10.0), (1.0, 0.0, 0.0)),
        ((10.0, 10.0, 1.1), (0.0, 0.0, -1.0)),
        ((7.0, 10.0, 10.0), (1.0, 0.0, 0.0)),
    ],
    ids=["wall", "floor", "obstacle"],
)
def test_a_wall_the_floor_and_an_obstacle_crash_an_agent(place, heading):
    flock = solitary(at([place], heading), ROOM)
    flock.run(20)
    assert flock.crashes.cause.tolist() == [2]
    assert flock.crashes.tick[0] in (7, 8)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 40), body=st.sampled_from((0.3, 0.75, 2.0)))
def test_who_touches_at_the_start_is_who_a_naive_look_finds(seed, n, body):
    rng = np.random.default_rng(seed)
    position = rng.uniform(0.1, 19.9, (n, 3))
    position = position[np.linalg.norm(position - 10.0, axis=1) > 2.0]
    n = len(position)
    assume(n > 0)
    solids = [sphere((10.0, 10.0, 10.0), 2.0), *box((0.0,) * 3, (20.0,) * 3)]
    flock = solitary(at(position), ROOM, body=body)
    flock.run(1)
    expected = touching(position, solids, body)
    found = np.zeros(n, int)
    found[flock.crashes.row] = flock.crashes.cause
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize(
    "activation", [pytest.param("random", marks=pytest.mark.exhaustive), "sequential"]
)
def test_in_turn_both_of_a_pair_crash_in_the_same_tick(activation):
    flock = solitary(towards_each_other(), activation=activation)
    flock.run(20)
    assert flock.crashes.tick.tolist() == [7, 7]
    assert flock.active.tolist() == [False, False, True]
    np.testing.assert_array_equal(flock.position[:2, 2], [0.0, 0.0] if flock.tick > 19 else 5.0)


@pytest.mark.parametrize("activation", ["synchronous", "sequential"])
def test_members_one_by_one_are_the_ticks_of_the_flock(activation):
    whole = Flock("safe", agents=60, world="thesis-blocks", rng=5, activation=activation)
    each = Flock("safe", agents=60, world="thesis-blocks", rng=5, activation=activation)
    whole.run(6)
    for _ in range(6):
        for member in each.agents:
            member.step()
    np.testing.assert_array_equal(whole.position, each.position)
    np.testing.assert_array_equal(whole.arrays.crash_record, each.arrays.crash_record)


def test_looked_at_only_as_the_run_starts():
    flock = solitary(towards_each_other(), model="thesis", contact="start", d_0=0.0)
    flock.run(40)
    assert len(flock.crashes) == 0
    flock = solitary(towards_each_other(), model="thesis", contact="start", d_0=2.0)
    flock.run(40)
    assert flock.crashes.tick.tolist() == [0, 0]


def test_threads_do_not_change_who_crashes():
    runs = [Flock("safe", agents=12_000, size=60.0, rng=2, threads=k) for k in (1, 2)]
    for flock in runs:
        flock.run(5)
    assert len(runs[0].crashes) > 100
    np.testing.assert_array_equal(runs[0].arrays.crash_record, runs[1].arrays.crash_record)
    np.testing.assert_array_equal(runs[0].position, runs[1].position)


def test_observables_leave_crashed_agents_out():
    flock = solitary(towards_each_other())
    assert flock.observe("groups") == 2
    assert flock.observe("polarisation") == pytest.approx(1.0 / 3.0)
    flock.run(8)
    assert flock.observe("groups") == 1
    assert flock.observe("polarisation") == 1.0
    assert flock.observe("nearest-neighbour") == np.inf


def test_a_saved_state_goes_on_with_its_crashed_agents(tmp_path):
    flock = Flock("safe", agents=50, world="thesis-blocks", rng=9, body=1.5)
    flock.run(5)
    assert len(flock.crashes) > 0
    flock.save(tmp_path / "state.parquet")
    again = Flock.load(tmp_path / "state.parquet")
    flock.run(20)
    again.run(20)
    np.testing.assert_array_equal(flock.position, again.position)
    np.testing.assert_array_equal(flock.arrays.crash_record, again.arrays.crash_record)


def test_agents_join_and_leave_a_flock_with_crashed_agents():
    flock = solitary(towards_each_other())
    flock.run(8)
    Member(flock, position=(1.0, 1.0, 1.0))
    assert flock.active.tolist() == [False, False, True, True]
    flock.members[0].remove()
    assert flock.active.tolist() == [False, True, True]
    assert flock.crashes.id.tolist() == [2]
    flock.run(1)


def test_a_start_keeps_its_spacing_to_all_bodies_and_walls():
    flock = Flock("safe", agents=50, world="thesis-blocks", rng=1, spacing=1.2)
    assert flock.observe("nearest-neighbour") >= 1.2
    assert flock.observe("obstacle-distance") >= 1.2
    assert flock.spec.spacing == 1.2
    again = Flock.from_spec(flock.spec)
    np.testing.assert_array_equal(flock.position, again.position)
    bare = Flock("safe", agents=50, world="thesis-blocks", rng=1)
    assert bare.observe("obstacle-distance") >= 0.375


def test_a_spacing_across_the_seam_counts():
    flock = Flock("safe", agents=300, world="thesis-sky", rng=1, spacing=1.5)
    assert flock.observe("nearest-neighbour") >= 1.5


@pytest.mark.parametrize("spacing", [-1.0, float("nan"), "far", True])
def test_a_spacing_that_is_none_is_refused(spacing):
    with pytest.raises(InputError, match="spacing = "):
        Flock("safe", spacing=spacing, rng=1)


def test_a_spacing_that_does_not_fit_is_refused():
    with pytest.raises(InputError, match="do not fit"):
        Flock("safe", agents=500, spacing=6.0, rng=1)


def test_models_without_bodies_have_no_crash_record():
    flock = Flock("couzin", agents=5, rng=1)
    flock.run(2)
    assert not flock.can_crash
    assert len(flock.crashes) == 0
    assert flock.active.all()
