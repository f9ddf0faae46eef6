"""Olfati-Saber's flocking: its functions, its forces against a naive version, its laws."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import olfati_saber as oracle
from oracles.close_up import close_up
from oracles.goal_scenes import GoalScene, goal_of, goal_scene, goal_scenes, velocity_of

from agents.catalogue import MODELS
from agents.engine.cache import compile_to_disk
from agents.observables.energy import potential
from agents.rules import olfati_saber as rule
from agents.rules.terms import sigma

CLEAR = 1e-7
"""Cases nearer to a threshold than this are left out: they hang on the last bits."""
SETTINGS = settings(max_examples=150, deadline=None, derandomize=True)
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
    "d_beta": 3.5,
    "p_max": 2.5,
    "dt": 0.2,
    "n_sub": 3.0,
}
"""No two gains alike, so that none can stand in for another."""
TABLE_3 = MODELS["olfati-saber"].parameters()


@compile_to_disk
def bump(z, h):
    return sigma.bump(z, h)


@compile_to_disk
def sigma_norm(d2, eps):
    return sigma.sigma_norm(d2, eps)


@compile_to_disk
def phi(z, a, b):
    return sigma.phi(z, a, b)


@compile_to_disk
def phi_alpha(s, p):
    return sigma.phi_alpha(s, p)


@compile_to_disk
def push(d2, p):
    return sigma.push(d2, p)


@compile_to_disk
def level(d2, alarm, d, tau_a, tau_e, tau_s):
    return sigma.level(d2, alarm, d, tau_a, tau_e, tau_s)


@compile_to_disk
def explain(me, near, surroundings, p, out):
    rule.explain(me, near, surroundings, p, out)


@compile_to_disk
def weigh(me, near, p, out):
    sigma.weigh(me, near, p, out)


def parameters(**values):
    """Parameters as compiled code has them."""
    scene = GoalScene(np.zeros((1, 2)), np.zeros((1, 2)), (), None)
    return scene.flock("olfati-saber", **values).context.parameters


# --- the functions ----------------------------------------------------------------------------


def test_sigma_norm_of_table_3():
    assert sigma_norm(16.0, 0.5) == 4.0
    assert sigma_norm(36.0, 0.5) == pytest.approx(2.0 * (math.sqrt(19.0) - 1.0), abs=1e-14)
    assert sigma_norm(0.0, 0.5) == 0.0


def test_bump_is_one_then_falls_to_nothing():
    assert [bump(z, 0.2) for z in (0.0, 0.1, 0.2)] == [1.0, 1.0, 1.0]
    assert bump(0.6, 0.2) == pytest.approx(0.5, abs=1e-15)
    assert bump(1.0, 0.2) == bump(1.5, 0.2) == 0.0
    z = np.linspace(0.0, 1.2, 4001)
    mine = np.array([bump(one, 0.2) for one in z])
    theirs = np.array([oracle.bump(one, 0.2) for one in z])
    assert np.abs(mine - theirs).max() < 4e-16
    assert (np.diff(mine) <= 0.0).all()


@pytest.mark.parametrize(("a", "b"), [(2.0, 20.0), (5.0, 5.0), (1.0, 100.0)])
def test_phi_is_nothing_at_zero_and_lies_between_minus_b_and_a(a, b):
    assert abs(phi(0.0, a, b)) < 1e-13
    assert phi(-1e9, a, b) == pytest.approx(-b, abs=1e-6)
    assert phi(1e9, a, b) == pytest.approx(a, abs=1e-6)


def test_phi_alpha_repels_nearer_than_d_and_attracts_up_to_r():
    p = parameters()
    assert abs(phi_alpha(sigma_norm(16.0, 0.5), p)) < 1e-13
    at = [phi_alpha(sigma_norm(x * x, 0.5), p) for x in (0.5, 3.9, 4.1, 5.9, 6.0, 7.0)]
    assert at[0] < at[1] < 0.0 < at[3] < at[2]
    assert at[4:] == [0.0, 0.0]


def test_flock_mates_push_with_up_to_19():
    """Which is what the printed phi_beta, bounded by 2, is up against."""
    p = parameters()
    assert min(phi_alpha(s, p) for s in np.linspace(0.0, 4.0, 401)) == pytest.approx(-19.0, abs=0.3)


@SETTINGS
@given(distance=st.floats(0.05, 7.0), moved=st.booleans())
def test_the_push_is_the_action_along_the_gradient_of_the_norm(distance, moved):
    p = parameters(**{k: v for k, v in ANY.items() if moved})
    z = np.array([distance, 0.0])
    s = oracle.sigma_norm(z, p.eps)
    force, rho = push(distance**2, p)
    assert force * distance == pytest.approx(
        oracle.phi_alpha(s, p) * oracle.gradient(z, p.eps)[0], abs=1e-12
    )
    assert rho == pytest.approx(oracle.bump(s / oracle.range_alpha(p), p.h), abs=1e-14)
    assert phi_alpha(s, p) == pytest.approx(oracle.phi_alpha(s, p), abs=1e-12)


@SETTINGS
@given(distance=st.floats(0.1, 5.95), step=st.just(1e-5))
def test_the_push_is_the_slope_of_the_potential(distance, step):
    """-grad psi, by finite differences of an integral that is taken apart from the kernel."""
    low, high = potential([distance - step, distance + step], TABLE_3)
    force, _ = push(distance**2, parameters())
    assert force * distance == pytest.approx((high - low) / (2 * step), abs=2e-6)


def test_the_weight_jumps_at_the_early_warning_distance_and_at_d():
    weights = [level(x * x, 2.0, 4.0, 0.1, 10.0, 1e4) for x in (0.0, 1.99, 2.0, 4.0, 4.01, 6.0)]
    assert weights == [1e4, 1e4, 10.0, 10.0, 0.1, 0.1]


@given(st.lists(st.floats(-9.0, 9.0), min_size=3, max_size=3))
def test_a_projection_is_its_own_square(vector):
    """And what it leaves out is along the normal, which is what the kernel writes."""
    vector = np.array(vector)
    assume(np.linalg.norm(vector) > 1e-3)
    a = vector / np.linalg.norm(vector)
    projection = np.eye(3) - np.outer(a, a)
    assert np.allclose(projection @ projection, projection, atol=1e-13)
    v = np.array([1.0, -2.0, 0.5])
    assert np.allclose(projection @ v - v, -(a @ v) * a, atol=1e-13)


# --- whole ticks ------------------------------------------------------------------------------


def expected(flock, scene, slack):
    """Positions and velocities after the next tick."""
    q, v, p = flock.position.copy(), velocity_of(flock), flock.parameters
    near = [oracle.shadows(scene.obstacles, at) for at in q]
    u = oracle.forces(q, v, near, goal_of(flock), p, slack).sum(axis=1)
    return oracle.moved(q, v, u, p)


@SETTINGS
@given(
    scene=goal_scenes(),
    given_=st.sampled_from(({}, {"beta": "printed"}, ANY, {**ANY, "beta": "printed"})),
)
def test_two_ticks_are_those_of_the_paper(scene, given_):
    flock = scene.flock("olfati-saber", **given_)
    for _ in range(2):
        slack = [1.0]
        q, v = expected(flock, scene, slack)
        assume(min(slack) > CLEAR)
        flock.run(1)
        assert np.abs(flock.position - q).max() < 1e-10
        assert np.abs(velocity_of(flock) - v).max() < 1e-9


def test_the_forces_shown_are_the_terms_of_the_paper():
    scene = goal_scene(5, 9, 2, False, 3, "moving")
    flock = scene.flock("olfati-saber", **ANY)
    flock.run(1)
    q, v, p = flock.position, velocity_of(flock), flock.parameters
    near = [oracle.shadows(scene.obstacles, at) for at in q]
    terms = oracle.forces(q, v, near, goal_of(flock), p, [])
    assert (np.abs(terms).max(axis=(0, 2)) > 1e-3).all()
    flock.engine.surroundings.goal[:, :2] = goal_of(flock)
    for row in range(9):
        shown = np.empty((5, 3))
        me, around = close_up(flock, row)
        explain(me, around, flock.engine.surroundings, flock.context.parameters, shown)
        assert np.abs(shown[:, :2] - terms[row]).max() < 1e-10
        assert not shown[:, 2].any()


def test_the_weights_shown_are_the_adjacency():
    flock = goal_scene(5, 9, 3, False, 0, "none").flock("olfati-saber")
    me, around = close_up(flock, 0)
    shown, p = np.empty(9), flock.parameters
    weigh(me, around, flock.context.parameters, shown)
    apart = flock.position - flock.position[0]
    expected = [
        oracle.bump(oracle.sigma_norm(z, p.eps) / oracle.range_alpha(p), p.h) for z in apart
    ]
    assert shown == pytest.approx(np.array([0.0, *expected[1:]]), abs=1e-14)


def test_forces_add_up_to_no_momentum():
    """Action and reaction: without gamma and obstacles the flock's mean velocity stays."""
    rng = np.random.default_rng(3)
    scene = GoalScene(rng.uniform(0, 9, (12, 3)), rng.uniform(-1, 1, (12, 3)), (), None)
    flock = scene.flock("olfati-saber", p_max=50.0)
    before = velocity_of(flock)
    flock.run(200)
    after = velocity_of(flock)
    assert flock.speed.max() < 50.0
    assert np.abs(after - before).max() > 0.1
    assert np.abs(after.mean(axis=0) - before.mean(axis=0)).max() < 1e-12


@pytest.mark.parametrize("dim", [2, 3])
def test_a_lone_agent_comes_to_a_goal_at_rest(dim):
    goal = np.zeros((2, dim))
    goal[0] = 15.0
    flock = GoalScene(np.ones((1, dim)), np.zeros((1, dim)), (), goal).flock("olfati-saber")
    flock.run(5000)
    assert np.abs(flock.position - 15.0).max() < 1e-6
    assert flock.speed.max() < 1e-6


def test_without_a_goal_a_lone_agent_goes_straight_on():
    scene = GoalScene(np.ones((1, 2)), np.array([[0.3, 0.4]]), (), None)
    flock = scene.flock("olfati-saber")
    flock.run(50)
    assert flock.position == pytest.approx(np.array([[1.3, 1.4]]), abs=1e-12)


def test_flock_mates_settle_in_a_lattice_of_spacing_d():
    scene = GoalScene(np.array([[0.0, 0.0], [3.0, 0.0], [1.5, 3.0]]), np.zeros((3, 2)), (), None)
    flock = scene.flock("olfati-saber")
    flock.run(5000)
    sides = np.linalg.norm(flock.position - np.roll(flock.position, 1, axis=0), axis=1)
    assert sides == pytest.approx(np.full(3, 4.0), abs=1e-6)


# --- the body ---------------------------------------------------------------------------------


def test_speeds_never_exceed_the_largest_and_ticks_are_parts_of_a_step():
    rng = np.random.default_rng(4)
    goal = np.array([[90.0, 90.0], [0.0, 0.0]])
    scene = GoalScene(rng.uniform(0, 9, (9, 2)), rng.uniform(-3, 3, (9, 2)), (), goal)
    flock = scene.flock("boundary-points", n_sub=5.0)
    assert flock.dt == pytest.approx(0.02)
    before = flock.position.copy()
    for _ in range(50):
        flock.run(1)
        assert flock.speed.max() <= 5.0 + 1e-12
        way = np.linalg.norm(flock.position - before, axis=1)
        assert way == pytest.approx(flock.speed * 0.02, abs=1e-12)
        before = flock.position.copy()


def test_at_rest_the_heading_is_kept():
    scene = GoalScene(np.zeros((1, 2)), np.zeros((1, 2)), (), None)
    flock = scene.flock("olfati-saber")
    heading = flock.heading.copy()
    flock.run(10)
    assert np.array_equal(flock.heading, heading)
    assert flock.position.tolist() == [[0.0, 0.0]]
