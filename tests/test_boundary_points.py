"""Boundary-point flocking: its state machine and forces against a naive version, its claims."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import boundary_points as oracle
from oracles.close_up import close_up
from oracles.goal_scenes import GoalScene, goal_of, goal_scene, goal_scenes, velocity_of
from oracles.olfati_saber import moved

from agents import Flock
from agents.engine.block import Me, PointBlock
from agents.engine.cache import compile_to_disk
from agents.rules import boundary_points as rule
from worlds.input_error import InputError
from worlds.obstacles import obstacle

CLEAR = 1e-7
"""Cases nearer to a threshold than this are left out: they hang on the last bits."""
SETTINGS = settings(max_examples=120, deadline=None, derandomize=True)
ANY = {
    "r": 5.0,
    "d": 3.0,
    "eps": 0.3,
    "h": 0.4,
    "a": 3.0,
    "b": 11.0,
    "c1a": 1.5,
    "c2a": 0.7,
    "c1b": 2.5,
    "c2b": 1.7,
    "c1g": 0.6,
    "c2g": 0.4,
    "tau_a": 0.3,
    "tau_e": 4.0,
    "tau_s": 50.0,
    "dtheta": 0.5,
    "d_min": 0.8,
    "p_max": 2.5,
    "dt": 0.2,
    "n_sub": 3.0,
}
"""No two gains alike, so that none can stand in for another."""


def demand(clear):
    """Let hypothesis look for another case."""
    assume(clear)


def memories(flock):
    """What each agent remembers, as the oracle has it."""
    names = flock.model.columns
    kept = dict(zip(names, flock.signals(), strict=True))
    found = []
    for i in range(len(flock.ids)):
        points = {
            name: np.array([kept[f"{name}_x"][i], kept[f"{name}_y"][i]])
            for name in ("split", "rejoin", "aim")
        }
        state = oracle.FOLLOW if kept["following"][i] else oracle.FREE
        blocked, scenario = bool(kept["blocked"][i]), int(kept["scenario"][i])
        found.append(oracle.Memory(state, blocked, scenario=scenario, **points))
    return found


def points_of(flock):
    """All boundary points, (M, 2)."""
    surroundings = flock.engine.surroundings
    return np.column_stack([surroundings.point_x, surroundings.point_y])


def compare_tick(flock):
    """Run one tick and compare it with the oracle's; gives the scenarios met, or None if unclear.

    A case is unclear if it hangs on the last bits of a number.
    """
    slack = [1.0]
    q, v, p = flock.position.copy(), velocity_of(flock), flock.parameters
    terms, after = oracle.forces(q, v, memories(flock), points_of(flock), goal_of(flock), p, slack)
    q, v = moved(q, v, terms.sum(axis=1), p)
    flock.run(1)
    if min(slack) < CLEAR:
        return None
    assert np.abs(flock.position - q).max() < 1e-8
    assert np.abs(velocity_of(flock) - v).max() < 1e-6
    for mine, theirs in zip(memories(flock), after, strict=True):
        assert (mine.state, mine.blocked, mine.scenario) == (
            theirs.state,
            theirs.blocked,
            theirs.scenario,
        )
        for name in ("split", "rejoin", "aim"):
            assert np.abs(getattr(mine, name) - getattr(theirs, name)).max() < 1e-8
    return {memory.scenario for memory in after}


@SETTINGS
@given(
    scene=goal_scenes(dims=(2,), hollow=True),
    given_=st.sampled_from(({}, {"sense": "clockwise"}, ANY, {**ANY, "sense": "clockwise"})),
)
def test_three_ticks_are_those_of_the_reading(scene, given_):
    flock = scene.flock("boundary-points", **given_)
    for _ in range(3):
        demand(compare_tick(flock) is not None)


@compile_to_disk
def explain(me, near, surroundings, p, out):
    rule.explain(me, near, surroundings, p, out)


def test_the_forces_shown_are_the_terms_of_the_reading():
    flock = goal_scene(5, 9, 2, True, 4, "moving").flock("boundary-points", **ANY)
    flock.run(1)
    q, v, p = flock.position, velocity_of(flock), flock.parameters
    terms, _ = oracle.forces(q, v, memories(flock), points_of(flock), goal_of(flock), p, [])
    assert (np.abs(terms).max(axis=(0, 2)) > 1e-3).all()
    flock.engine.surroundings.goal[:, :2] = goal_of(flock)
    for row in range(9):
        shown = np.empty((5, 3))
        me, around = close_up(flock, row)
        explain(me, around, flock.engine.surroundings, flock.context.parameters, shown)
        assert np.abs(shown[:, :2] - terms[row]).max() < 1e-8
        assert not shown[:, 2].any()


BARRIER = {"shape": "wall", "start": (15.0, 2.0), "end": (15.0, 22.0), "thickness": 1.0}
DISC = {"shape": "disc", "centre": (15.0, 12.0), "radius": 4.0}
HOOK = {
    "shape": "polygon",
    "points": [(14, 6), (20, 6), (20, 18), (10, 18), (10, 17), (19, 17), (19, 7), (14, 7)],
}


@pytest.mark.parametrize(
    ("sense", "shape"),
    [
        ("counterclockwise", BARRIER),
        pytest.param("clockwise", BARRIER, marks=pytest.mark.long),
        pytest.param("counterclockwise", DISC, marks=pytest.mark.long),
        ("clockwise", DISC),
        ("counterclockwise", HOOK),
        pytest.param("clockwise", HOOK, marks=pytest.mark.long),
    ],
    ids=lambda given: given if isinstance(given, str) else given["shape"],
)
def test_a_whole_way_round_an_obstacle(shape, sense):
    """Every tick from split to rejoin, and all of them through."""
    rng = np.random.default_rng(6)
    position = np.array([[x, y] for x in (3.5, 6.0) for y in (9.0, 12.0)])
    goal = np.array([[28.0, 12.5], [0.0, 0.0]])
    scene = GoalScene(position + rng.uniform(0, 0.3, (4, 2)), np.zeros((4, 2)),
                      (obstacle(shape),), goal)  # fmt: skip
    flock = scene.flock("boundary-points", sense=sense)
    met = [compare_tick(flock) for _ in range(700)]
    scenarios = set().union(*(one for one in met if one))
    assert scenarios == {1, 2, 3, 4}
    assert sum(one is None for one in met) < 30
    flock.run(800)
    assert np.linalg.norm(flock.position - goal[0], axis=1).max() < 6.0


# --- what an agent perceives ------------------------------------------------------------------


@compile_to_disk
def boundary_end(me, points, ax, ay, p):
    return rule.boundary_end(me, points, ax, ay, p)


@compile_to_disk
def is_blocked(me, points, gx, gy, width):
    return rule.is_blocked(me, points, gx, gy, width)


def around(points):
    """An agent at the origin and boundary points, as compiled code has them."""
    points = np.array(points, float).reshape(-1, 2)
    none, key = np.zeros(0), np.uint64(0)
    me = Me(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, none, np.zeros(10), False, 1.0, 1, 0, key, 1, 0.0)
    x, y = points.T.copy()
    return me, PointBlock(len(x), x, y, np.empty((4, len(x))))


def parameters(**values):
    scene = GoalScene(np.zeros((1, 2)), np.zeros((1, 2)), (), None)
    return scene.flock("boundary-points", **values).context.parameters


def at_phases(phases):
    """Boundary points in these directions from the x axis, each 2 m away."""
    return [(2.0 * math.cos(phase), 2.0 * math.sin(phase)) for phase in phases]


@pytest.mark.parametrize(
    ("phases", "counterclockwise", "clockwise"),
    [
        ([0.1, 0.5, 1.0, 3.0, 3.3], 1.0, 3.0),
        ([0.1, 0.5, 1.0], 1.0, 0.1),
        ([2.0], 2.0, 2.0),
        ([5.9, 0.2, 6.2, 0.4], 0.4, 5.9),
        ([0.0, 0.785398, 1.58], 0.785398, 1.58),
    ],
)
def test_the_boundary_ends_at_the_first_gap_of_dtheta(phases, counterclockwise, clockwise):
    """By hand: gaps of pi / 4 = 0.7854; from 1.0 to 3.0 in the first case, and round the back."""
    me, seen = around(at_phases(phases))
    for sense, phase in (("counterclockwise", counterclockwise), ("clockwise", clockwise)):
        x, y, found = boundary_end(me, seen, 1.0, 0.0, parameters(sense=sense))
        assert (x, y) == pytest.approx(at_phases([phase])[0], abs=1e-12)
        assert found == pytest.approx(phase, abs=1e-12)


@SETTINGS
@given(
    seed=st.integers(0, 2**32 - 1),
    number=st.integers(1, 40),
    dtheta=st.sampled_from((0.1, 0.3, 0.785, 2.0)),
    sense=st.sampled_from(("counterclockwise", "clockwise")),
)
def test_jumping_ahead_finds_what_sorting_finds(seed, number, dtheta, sense):
    rng = np.random.default_rng(seed)
    points, towards = rng.uniform(-6.0, 6.0, (number, 2)), rng.uniform(-6.0, 6.0, 2)
    slack = [1.0]
    p = SimpleNamespace(sense=sense, dtheta=dtheta)
    expected = oracle.by_phase(np.zeros(2), list(points), towards, p, slack)
    demand(min(slack) > 1e-9)
    me, seen = around(points)
    found = boundary_end(me, seen, *towards, parameters(sense=sense, dtheta=dtheta))
    assert found[:2] == tuple(expected)


@pytest.mark.parametrize(
    ("point", "blocked"),
    [
        ((3.0, 0.0), 1.0),
        ((3.0, 1.99), 1.0),
        ((3.0, 2.01), 0.0),
        ((-0.1, 0.0), 0.0),
        ((4.99, 0.0), 1.0),
        ((5.01, 0.0), 0.0),
    ],
)
def test_what_is_in_the_way(point, blocked):
    """Ahead, before the gamma agent at (5, 0), and within d_e = 2 m of the line to it."""
    assert is_blocked(*around([point]), 5.0, 0.0, 2.0) == blocked


def test_at_the_goal_nothing_is_in_the_way():
    assert is_blocked(*around([(0.5, 0.0)]), 0.0, 0.0, 2.0) == 0.0


# --- laws and claims --------------------------------------------------------------------------


def test_without_gamma_and_obstacles_momentum_is_kept():
    rng = np.random.default_rng(3)
    grid = np.array([[x, y] for x in range(0, 12, 3) for y in range(0, 9, 3)], float)
    scene = GoalScene(grid + rng.uniform(0, 0.5, (12, 2)), rng.uniform(-1, 1, (12, 2)), (), None)
    flock = scene.flock("boundary-points", p_max=50.0, dt=0.01, n_sub=10.0, d_min=0.5)
    before = velocity_of(flock)
    flock.run(500)
    after = velocity_of(flock)
    assert flock.speed.max() < 50.0
    assert np.abs(after - before).max() > 0.1
    assert np.abs(after.mean(axis=0) - before.mean(axis=0)).max() < 1e-11


def test_without_a_goal_boundary_points_push_but_do_not_tow():
    scene = GoalScene(np.array([[2.0, 6.0]]), np.zeros((1, 2)), (obstacle(DISC),), None)
    flock = scene.flock("boundary-points", r=12.0)
    assert len(points_of(flock)) > 0
    flock.run(1)
    assert {memory.scenario for memory in memories(flock)} == {0}
    assert flock.speed[0] > 0.0


def test_a_lone_agent_comes_to_a_goal_at_rest():
    goal = np.array([[15.0, 10.0], [0.0, 0.0]])
    flock = GoalScene(np.ones((1, 2)), np.zeros((1, 2)), (), goal).flock("boundary-points")
    flock.run(3000)
    assert flock.position == pytest.approx(goal[:1], abs=1e-6)


def test_it_is_defined_in_the_plane_only():
    goal = np.zeros((2, 3))
    with pytest.raises(InputError, match="boundary-points is defined in 2-D"):
        GoalScene(np.ones((1, 3)), np.zeros((1, 3)), (), goal).flock("boundary-points")


def test_there_are_no_information_agents_because_everybody_knows_the_goal():
    with pytest.raises(InputError, match="boundary-points has no information agents"):
        Flock("boundary-points", agents=5, informed=1, world="open", size=9.0)


def test_distances_stay_above_the_least_safe_one():
    """d_min = 1 m: 24 agents go round a wall and crowd around the goal behind it."""
    position = np.array([[x, y] for x in (-3.0, -0.5, 2.0, 4.5) for y in np.arange(5.0, 20.0, 2.5)])
    goal = np.array([[28.0, 12.5], [0.0, 0.0]])
    scene = GoalScene(position, np.zeros((24, 2)), (obstacle(BARRIER),), goal)
    flock = scene.flock("boundary-points")
    least_pair, least_point = math.inf, math.inf
    points, pairs = points_of(flock), np.triu_indices(24, 1)
    for q in flock.trace(2000):
        pair = np.linalg.norm(q[:, None] - q[None], axis=2)[pairs].min()
        point = np.linalg.norm(q[:, None] - points[None], axis=2).min()
        least_pair, least_point = min(least_pair, pair), min(least_point, point)
    assert np.linalg.norm(flock.position - goal[0], axis=1).max() < 14.0
    assert 1.0 < least_pair < 2.9
    assert 1.0 < least_point < 2.9
