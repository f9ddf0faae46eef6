"""Flying missions, and what is measured of them, against naive versions."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import cdist

from agents import Flock, run_records
from agents.observables.following import (
    keep_following,
    least_clearances,
    nearest_pairs,
    settling_tick,
    spread_bound,
)
from agents.run_records import SINCE, fly
from worlds.input_error import InputError
from worlds.layout import world
from worlds.queries.clearance import clearance

SCENE = "liu2021-mission"


@st.composite
def traces(draw):
    """Positions (T, N, dim) at which links break and form, and who is informed."""
    ticks, n, dim = draw(st.integers(1, 6)), draw(st.integers(1, 9)), draw(st.sampled_from([2, 3]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    trace = rng.uniform(0.0, 1.6, (n, dim)) + rng.normal(0.0, 0.15, (ticks, n, dim)).cumsum(axis=0)
    informed = rng.uniform(size=n) < 0.3
    informed[draw(st.integers(0, n - 1))] = True
    return trace, informed


def by_axis(trace):
    """As the compiled functions take it."""
    return np.ascontiguousarray(trace.transpose(0, 2, 1))


def naive_following(trace, informed, r):
    """Who is in a component with an information agent at every tick."""
    follows = np.ones(len(informed), bool)
    for position in trace:
        _, label = connected_components(cdist(position, position) <= r)
        follows &= np.isin(label, label[informed])
    return follows


@settings(max_examples=80, deadline=None)
@given(traces())
def test_followers_are_those_of_the_components(case):
    trace, informed = case
    n = len(informed)
    follows = np.ones(n, bool)
    for part in (trace[:2], trace[2:]):
        keep_following(
            by_axis(part), informed, 0.7, follows, np.zeros(n, bool), np.zeros(n, np.int64)
        )
    assert follows.tolist() == naive_following(trace, informed, 0.7).tolist()


@settings(max_examples=80, deadline=None)
@given(traces())
def test_least_distances_of_pairs(case):
    trace, informed = case
    n = len(informed)
    least2 = np.full((n, n), np.inf)
    for part in (trace[:1], trace[1:]):
        nearest_pairs(by_axis(part), least2)
    naive = np.min([cdist(position, position) for position in trace], axis=0)
    above = np.triu_indices(n, 1)
    np.testing.assert_allclose(np.sqrt(least2[above]), naive[above], rtol=1e-12, atol=0.0)
    assert np.isinf(least2[np.tril_indices(n)]).all()


def test_least_clearances_are_shapelys():
    flock = Flock("hwvem-nav", world=SCENE, rng=1)
    trace = np.random.default_rng(5).uniform((15.5, 7.5), (19.5, 10.5), (40, 7, 2))
    least = np.full(7, np.inf)
    least_clearances(by_axis(trace), flock.engine.surroundings, least)
    naive = np.min([clearance(flock.world, position) for position in trace], axis=0)
    assert (naive < 0.0).any()
    np.testing.assert_allclose(least, naive, rtol=0.0, atol=1e-9)


@given(st.lists(st.sampled_from([0.5, 2.0, 2.5, 9.0, float("nan")]), min_size=1, max_size=8))
def test_settling_is_for_good(distance):
    for_good = [k for k in range(len(distance)) if all(d <= 2.0 for d in distance[k:])]
    assert settling_tick(np.array(distance), 2.0) == (for_good[0] if for_good else None)


def test_the_bound_of_a_flock_holds_a_hexagonal_lattice():
    k = np.arange(-9, 10)
    a, b = np.meshgrid(k, k)
    away = np.sort(np.hypot(a + 0.5 * b, b * 3.0**0.5 / 2.0).ravel())
    for n in (7, 19, 37, 61):
        assert away[n - 1] * 4.0 < spread_bound(n, 4.0) < 2.0 * away[n - 1] * 4.0


@pytest.fixture(scope="module")
def flight():
    """A flock of 8 on the papers' mission, flown to the end."""
    flock = Flock("hwvem-nav", agents=7, world=SCENE, rng=3)
    return flock, fly(flock, 1000)


def test_positions_are_those_of_a_flock_run_tick_by_tick(flight):
    _, record = flight
    again = Flock("hwvem-nav", agents=7, world=SCENE, rng=3)
    for k in range(len(record.position)):
        assert record.position[k].tobytes() == again.position.tobytes()
        again.run(1)
    assert len(record.position) == record.ticks + 1


def test_it_ends_when_the_information_agent_is_at_its_last_waypoint(flight):
    flock, record = flight
    path = flock.world.mission.path
    away = np.linalg.norm(record.position[:, 0] - np.array(path.waypoints[-1]), axis=1)
    assert record.arrived
    assert away[-1] <= path.switch
    assert (away[:-1] > path.switch).all()


def test_a_course_says_what_its_positions_say(flight):
    flock, record = flight
    position = record.position
    follows = naive_following(position[SINCE:], record.informed, 1.0)
    assert 0.0 < record.success == follows.mean()
    pairs = np.min([cdist(p, p) + np.diag([np.inf] * len(p)) for p in position], axis=0)
    assert record.least_pair == pytest.approx(pairs.min(), rel=1e-12)
    of_followers = pairs[np.ix_(follows, follows)].min()
    assert record.least_pair_of_followers == pytest.approx(of_followers, rel=1e-12)
    near = np.min([clearance(flock.world, p) for p in position])
    assert record.least_obstacle == pytest.approx(near, abs=1e-9)
    assert record.away.size == record.centre.size == 0


def test_no_number_depends_on_the_stretches_or_on_what_is_kept(flight, monkeypatch):
    _, whole = flight
    monkeypatch.setattr(run_records, "CHUNK", 37)
    thin = fly(Flock("hwvem-nav", agents=7, world=SCENE, rng=3), 1000, every=10)
    assert thin.position.tobytes() == whole.position[::10].tobytes()
    assert (thin.ticks, thin.arrived) == (whole.ticks, True)
    assert thin.follows.tolist() == whole.follows.tolist()
    assert thin.pairs.tobytes() == whole.pairs.tobytes()
    assert thin.clearance.tobytes() == whole.clearance.tobytes()


def test_a_mission_may_run_out_of_time():
    flock = Flock("hwvem-nav", agents=3, world=SCENE, rng=1)
    record = fly(flock, 60)
    assert (record.ticks, record.arrived, flock.tick) == (60, False, 60)


def test_round_a_closed_path_nobody_arrives():
    scene = world(SCENE)
    path = scene.mission.path.model_copy(
        update={"closed": True, "waypoints": ((3.0, 3.0), (3.0, 1.0))}
    )
    round_trip = replace(scene, mission=scene.mission.model_copy(update={"path": path}))
    record = fly(Flock("hwvem-nav", agents=2, world=round_trip, rng=1), 200)
    assert (record.ticks, record.arrived) == (200, False)


def test_a_mission_begins_at_tick_0():
    flock = Flock("hwvem-nav", agents=3, world=SCENE, rng=1)
    flock.run(2)
    with pytest.raises(InputError, match="the flock is at tick 2: a mission begins at tick 0"):
        fly(flock, 10)


def test_what_is_called_between_may_end_it():
    def stop():
        raise KeyboardInterrupt

    flock = Flock("hwvem-nav", agents=3, world=SCENE, rng=1)
    with pytest.raises(KeyboardInterrupt):
        fly(flock, 1000, between=stop)


def test_settling_and_coming_through(flight):
    _, record = flight
    there = replace(
        record, centre=np.array([9.0, 1.0, 3.0, 1.0, 1.0]), away=np.array([1.0, 7.0, 99.0]), dt=0.5
    )
    assert there.settled() == 1.5
    assert there.settled(0.5) is None
    assert there.through(6.0) == pytest.approx(2 / 3)
    assert there.through(4.0) == pytest.approx(1 / 3)
