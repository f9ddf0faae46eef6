"""The guarded zones: their guard against an oracle, what it proves, and what a flock of it does."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import guarded as oracle
from oracles.solids import box, sphere

from agents import Flock
from agents.rules.terms.reserved_ball import SKIN, spiral
from worlds.obstacles import Sphere
from worlds.queries.clearance import clearance
from worlds.world import World

SIDE = 14.0
BALLS = (((4.0, 4.0, 6.0), 1.5), ((9.0, 8.0, 4.0), 2.0))
ROOM = World(
    name="room",
    size=(SIDE,) * 3,
    edges=("solid",) * 3,
    obstacles=tuple(Sphere(centre=centre, radius=radius) for centre, radius in BALLS),
)
SKY = World(name="sky", size=(SIDE,) * 3, edges=("open",) * 3)
FLOOR = World(name="floor", size=(SIDE,) * 2, edges=("solid",) * 2)
SOLIDS = [sphere(*ball) for ball in BALLS] + box((0.0,) * 3, (SIDE,) * 3)


def rooms(flock):
    """Centres (N, dim) and radii (N,) of the rooms that agents have told of."""
    out = np.column_stack([flock.signal(f"room_{axis}") for axis in "xyz"[: flock.world.dim]])
    return flock.position + out, flock.signal("room_radius")


def least_gap(flock):
    """The least gap between two rooms with their bodies, length; negative where they overlap."""
    centre, radius = rooms(flock)
    gap = np.linalg.norm(centre[:, None] - centre[None], axis=2)
    gap -= radius[:, None] + radius[None] + flock.parameters.body
    np.fill_diagonal(gap, np.inf)
    return gap.min()


def least_clearance(flock):
    """The least distance of a room with its body from what is solid, length."""
    centre, radius = rooms(flock)
    return (clearance(flock.world, centre) - radius - flock.parameters.body / 2).min()


def one_group(position, d_a):
    """Whether everybody is linked with everybody, from one nearer than d_a to the next."""
    near = np.linalg.norm(position[:, None] - position[None], axis=2) < d_a
    return bool((np.linalg.matrix_power(near.astype(float), len(near)) > 0.0).all())


@given(
    speed=st.floats(0.0, 3.0),
    v_min=st.floats(0.05, 1.5),
    a_max=st.floats(0.2, 5.0),
    theta_max=st.floats(30.0, 600.0),
    tau=st.sampled_from((0.05, 0.1)),
)
@settings(max_examples=200, deadline=None, derandomize=True)
def test_an_escape_ends_in_a_circle_and_stays_in_the_room_around_it(
    speed, v_min, a_max, theta_max, tau
):
    p = oracle.Guarded(v_min=v_min, a_max=a_max, theta_max=theta_max, tau=tau)
    centre, radius = oracle.room(np.zeros(2), np.array([1.0, 0.0]), np.array([0.0, 1.0]), speed, p)
    theta = math.radians(theta_max) * tau
    way = spiral.py_func(speed, v_min, a_max * tau, theta, tau)
    assert np.allclose((way.along, way.across), centre, atol=1e-6 / theta**2 * 1e-3)
    assert way.radius == pytest.approx(radius, rel=1e-6)
    corners = oracle.flight(speed, p, math.ceil(2.0 * math.pi / theta) + 200)
    away = np.linalg.norm(corners - (way.along, way.across), axis=1)
    assert away.max() <= way.radius + 1e-9
    if speed >= v_min:
        assert (np.diff(away) <= 1e-9).all()


def test_an_escape_without_slowing_down_is_the_circle_of_the_turn():
    theta = math.radians(12.0)
    way = spiral.py_func(1.0, 1.0, 0.1, theta, 0.1)
    r = 0.05 / math.sin(theta / 2)
    assert way.radius == pytest.approx(r, rel=1e-12)
    assert (way.along, way.across) == pytest.approx(
        (-r * math.sin(theta / 2), r * math.cos(theta / 2)), rel=1e-12
    )


def start(seed, n, spread, dim):
    """Agents in the middle, with speeds."""
    rng = np.random.default_rng(seed)
    heading = rng.normal(size=(n, dim))
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    position = 0.5 * SIDE + rng.uniform(-0.5 * spread, 0.5 * spread, (n, dim))
    apart = np.linalg.norm(position[:, None] - position[None], axis=2) + 9.0 * np.eye(n)
    keep = apart.min(axis=1) > 0.8
    if dim == 3:
        keep &= np.array([min(solid(place)[0] for solid in SOLIDS) > 0.4 for place in position])
    assume(keep.any())
    speed = rng.uniform(0.5, 1.0, n)
    return {"position": position[keep], "heading": heading[keep], "speed": speed[keep]}


@pytest.mark.parametrize(
    "where", ["sky", "room", pytest.param("floor", marks=pytest.mark.exhaustive)]
)
@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 12),
    spread=st.sampled_from((4.0, 7.0, 12.0)),
    alpha=st.sampled_from((90.0, 200.0, 270.0, 359.0)),
)
def test_every_tick_is_that_of_the_oracle(where, seed, n, spread, alpha):
    world = {"sky": SKY, "room": ROOM, "floor": FLOOR}[where]
    solids = {"sky": [], "room": SOLIDS, "floor": box((0.0,) * 2, (SIDE,) * 2)}[where]
    begin = start(seed, n, spread, world.dim)
    p = oracle.Guarded(alpha=alpha)
    flock = Flock("guarded", start=begin, world=world, alpha=alpha, rng=1)
    place, course, pace = (begin[key] for key in ("position", "heading", "speed"))
    told = oracle.first_rooms(place, course, pace, p)
    for _ in range(4):
        place, course, pace, told = oracle.tick(place, course, pace, told, solids, p)
        flock.run(1)
        if not flock.active.all():
            break
        np.testing.assert_allclose(flock.position, place, atol=1e-8)
        np.testing.assert_allclose(flock.heading, course, atol=1e-7)
        np.testing.assert_allclose(flock.speed, pace, atol=1e-12)
        centre, radius = rooms(flock)
        np.testing.assert_allclose(centre, [centre for centre, _ in told], atol=1e-8)
        np.testing.assert_allclose(radius, [radius for _, radius in told], atol=1e-8)


@pytest.mark.parametrize(
    "activation", ["synchronous", pytest.param("random", marks=pytest.mark.exhaustive)]
)
@pytest.mark.parametrize("alpha", [90.0, 270.0])
@pytest.mark.parametrize(
    "seed", [1, pytest.param(2, marks=pytest.mark.long), pytest.param(3, marks=pytest.mark.long)]
)
def test_rooms_that_are_apart_stay_apart_and_clear(activation, alpha, seed):
    flock = Flock("guarded", activation=activation, alpha=alpha, rng=seed)
    apart = False
    for _ in range(400):
        flock.run(1)
        now = least_gap(flock) >= 0.0 and least_clearance(flock) >= 0.0
        assert now or not apart
        apart = now
    assert apart
    assert least_gap(flock) >= 2.0 * SKIN - 1e-6
    assert flock.active.all()


@pytest.mark.parametrize("alpha", [90.0, 270.0])
@pytest.mark.parametrize("seed", [11, 12])
def test_a_run_among_the_blocks_of_the_thesis_ends_as_one_group_without_a_crash(alpha, seed):
    flock = Flock("guarded", alpha=alpha, rng=seed)
    flock.run(3000)
    assert len(flock.crashes) == 0
    assert one_group(flock.position, 5.0)
    assert flock.speed.mean() > 0.8


def test_without_the_guard_the_same_flock_crashes():
    flock = Flock("guarded", guard=False, rng=11)
    flock.run(1000)
    assert len(flock.crashes) > 5


def test_wishes_that_press_everybody_into_one_place_crash_nobody():
    flock = Flock("guarded", rng=5, w_c=5.0, w_a=5.0, d_r=0.05, d_o=0.05, gain=0.0)
    flock.run(1000)
    assert len(flock.crashes) == 0
    assert np.ptp(flock.position, axis=0).max() < 14.0


def test_two_that_fly_at_each_other_pass():
    begin = {
        "position": [(3.0, 7.0, 7.0), (11.0, 7.0, 7.0)],
        "heading": [(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)],
        "speed": [1.0, 1.0],
    }
    blind = {"w_c": 0.0, "d_r": 0.05, "d_o": 0.05, "d_a": 0.05}
    for guard, crashes in ((False, 2), (True, 0)):
        flock = Flock("guarded", start=begin, world=SKY, guard=guard, rng=1, **blind)
        flock.run(100)
        assert len(flock.crashes) == crashes
    assert flock.position[0, 0] > 7.0 > flock.position[1, 0]


def test_a_flock_on_a_walled_floor_does_not_crash():
    flock = Flock("guarded", agents=12, world=FLOOR, rng=4)
    flock.run(500)
    assert len(flock.crashes) == 0
    assert least_gap(flock) > 0.0


def test_rooms_are_seen_across_the_seam_of_a_torus():
    flock = Flock("guarded", agents=30, world="thesis-sky", rng=2)
    flock.run(1500)
    assert len(flock.crashes) == 0


def test_nobody_beyond_reach_can_be_in_the_way():
    flock = Flock("guarded", agents=2, d_c=0.0, d_a=0.05, d_o=0.05, d_r=0.05, rng=1)
    p = oracle.Guarded()
    widest = oracle.room(np.zeros(2), np.array([1.0, 0.0]), np.array([0.0, 1.0]), 1.5, p)[1]
    farthest = 8.0 * widest + 2.0 * 1.5 * 0.1 + 0.75 + 2.0 * SKIN
    assert flock.reach == pytest.approx(farthest, rel=1e-9)


def test_what_is_weighed_is_what_counts():
    begin = {
        "position": [(7.0, 7.0, 7.0), (8.5, 7.0, 7.0), (7.0, 9.2, 7.0), (7.0, 7.0, 11.0),
                     (1.0, 7.0, 7.0), (7.0, 7.0, -4.0)],
        "heading": [(1.0, 0.0, 0.0)] * 6,
    }  # fmt: skip
    flock = Flock("guarded", start=begin, world=SKY, alpha=270.0, w_c=0.8, w_a=0.3, rng=1)
    weights = np.zeros(6)
    found = flock.inspect(0)
    weights[found.neighbours] = found.weights
    # Near, beside in the zone of orientation, above in that of attraction, behind and only heard,
    # out of hearing; four are heard.
    assert np.allclose(weights, [0.0, 1.2, 1.2, 0.5, 0.2, 0.0])
