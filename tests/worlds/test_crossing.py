"""Where a step first enters something solid, against shapely and against a walk in small steps."""

import math

import numpy as np
import pytest
import shapely
from fine import demand_round, united
from hypothesis import given, settings
from hypothesis import strategies as st

from worlds.obstacles import Box, Disc, Polygon, Prism, Ring, Sphere, Wall
from worlds.queries.clearance import clearance
from worlds.queries.crossing import first_crossing, is_crossed, is_far, skin
from worlds.queries.survey import survey_world
from worlds.world import World

SIDE = 10.0


def yard(seed, edges="solid"):
    """A box with some obstacles, which may overlap, thin ones among them."""
    rng = np.random.default_rng(seed)
    x, y, u, v = rng.uniform(1.0, 9.0, 4)
    points = [(5 + 3 * math.cos(a), 5 + 3 * math.sin(a)) for a in np.sort(rng.uniform(0, 6.28, 5))]
    return World(
        "yard",
        (SIDE, SIDE),
        (edges, edges),
        obstacles=(
            Wall(start=(x, y), end=(u, v), thickness=float(rng.choice([1e-3, 0.05, 0.4]))),
            Wall(start=(u, v), end=(y, x), thickness=0.01),
            Disc(centre=(v, u), radius=float(rng.uniform(0.05, 1.5))),
            Polygon(points=points),
        ),
    )


def free_places(world, rng, n):
    place = rng.uniform(0.0, SIDE, (4 * n, world.dim))
    return place[clearance(world, place) > 1e-6][:n]


def shares(world, surroundings, start, end):
    """The shares of steps from `start` to `end` (N, dim) at which each enters something."""
    pad = np.zeros((len(start), 3 - world.dim))
    a, d = np.hstack([start, pad]), np.hstack([end - start, pad])
    return [first_crossing(surroundings, *here, *way) for here, way in zip(a, d, strict=True)]


@settings(max_examples=40, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), reach=st.sampled_from((0.05, 0.5, 4.0)))
def test_on_the_plan_it_is_where_shapely_sees_the_step_go_in(seed, reach):
    rng = np.random.default_rng(seed)
    world = yard(seed)
    surroundings = survey_world(world, reach)
    free = shapely.box(0, 0, SIDE, SIDE).difference(united(world.obstacles, 2**15)[0])
    demand_round(world, reach)
    start = free_places(world, rng, 20)
    end = start + rng.normal(size=start.shape) * rng.choice([0.1, 1.0, 20.0], (len(start), 1))
    for a, b, at in zip(start, end, shares(world, surroundings, start, end), strict=True):
        step = shapely.LineString([a, b])
        out = step.intersection(free.boundary)
        if step.within(free):
            assert at.share == math.inf or out.distance(step) < 1e-8
            continue
        nearest = min(math.dist(a, p) for p in shapely.get_coordinates(out))
        assert at.share * math.dist(a, b) == pytest.approx(nearest, abs=1e-7)
        assert math.hypot(at.nx, at.ny) == pytest.approx(1.0, abs=1e-12)
        assert at.nx * (b - a)[0] + at.ny * (b - a)[1] < 0.0


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1))
def test_in_space_it_is_where_a_walk_in_small_steps_ends(seed):
    rng = np.random.default_rng(seed)
    x, y, z = rng.uniform(2.0, 8.0, 3)
    world = World(
        "hall",
        (SIDE,) * 3,
        ("solid", "open", "solid"),
        obstacles=(
            Sphere(centre=(y, x, z), radius=float(rng.uniform(0.2, 2.0))),
            Box(low=(x - 1, y - 1, z - 1), high=(x + 1, y + 1, z)),
            Prism(points=[(z, x), (z + 1.5, x + 0.2), (z, x + 2)], bottom=1.0, top=y),
            Wall(start=(1, 1), end=(9, 9), thickness=0.3, bottom=4.0, top=6.0),
        ),
    )
    surroundings = survey_world(world, 0.5)
    start = free_places(world, rng, 12)
    end = start + rng.normal(size=start.shape) * 4.0
    at = np.linspace(0.0, 1.0, 4001)[:, None]
    for a, b, found in zip(start, end, shares(world, surroundings, start, end), strict=True):
        depth = clearance(world, a + at * (b - a))
        if depth.min() > 1e-3:
            assert found.share == math.inf
        elif depth.min() < -1e-3:
            last_free = np.argmax(depth < 0.0) - 1
            assert found.share == pytest.approx(at[last_free, 0], abs=1.5 / 4000)


def test_a_disc_is_entered_where_its_circle_is_and_a_ring_from_either_side():
    """Closed form: the first root of |a + t d - c| = R."""
    rng = np.random.default_rng(3)
    disc, ring = Disc(centre=(5.0, 5.0), radius=2.0), Ring(centre=(5, 5), radius=4.0, width=1.0)
    for shape, r, inside in ((disc, 2.0, False), (ring, 4.0, False), (ring, 3.0, True)):
        world = World("yard", (SIDE, SIDE), ("open", "open"), obstacles=(shape,))
        surroundings = survey_world(world, 1.0)
        for angle in rng.uniform(0.0, 2.0 * math.pi, 60):
            out = np.array([math.cos(angle), math.sin(angle)])
            start = out * (rng.uniform(0.0, 2.9) if inside else rng.uniform(4.1, 5.0))
            step = rng.normal(size=2) * 6.0
            b, d2, c = start @ step, step @ step, start @ start - r * r
            root = b * b - d2 * c
            at = math.inf
            if root > 0.0 and (inside or b < 0.0):
                at = (-b + math.copysign(math.sqrt(root), 1.0 if inside else -1.0)) / d2
            found = first_crossing(surroundings, *(start + 5.0), 0.0, *step, 0.0)
            assert found.share == (pytest.approx(at, abs=1e-12) if at <= 1.0 else math.inf)
            if at <= 1.0:
                normal = (start + at * step) / r * (-1.0 if inside else 1.0)
                assert (found.nx, found.ny) == pytest.approx(tuple(normal), abs=1e-9)


def test_a_step_from_within_may_leave_and_a_step_along_a_wall_goes_on():
    world = World(
        "yard", (SIDE, SIDE), ("solid", "open"), obstacles=(Box(low=(4, 4), high=(6, 6)),)
    )
    surroundings = survey_world(world, 1.0)
    assert first_crossing(surroundings, 5.0, 5.0, 0.0, 3.0, 0.0, 0.0).share == math.inf
    assert first_crossing(surroundings, 3.9, 5.0, 0.0, 0.0, 30.0, 0.0).share == math.inf
    assert first_crossing(surroundings, 0.0, 1.0, 0.0, 0.0, 30.0, 0.0).share == math.inf
    assert first_crossing(surroundings, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0).share == 0.0
    assert first_crossing(surroundings, 1.0, 5.0, 0.0, 6.0, 0.0, 0.0).share == 0.5


def test_a_corner_and_a_joint_of_two_obstacles_let_nothing_through():
    corner = World(
        "yard", (SIDE, SIDE), ("open", "open"), obstacles=(Box(low=(4, 4), high=(6, 6)),)
    )
    steps = [(3.0, 3.0, 3.0, 3.0), (7.0, 3.0, -2.0, 2.0), (3.0, 7.0, 2.0, -2.0)]
    surroundings = survey_world(corner, 1.0)
    for x, y, dx, dy in steps:
        assert first_crossing(surroundings, x, y, 0.0, dx, dy, 0.0).share <= 0.5
    # 0.1 + 0.2 is a little more than 0.3: a gap that nobody sees on a plan.
    parts = Box(low=(0.0, 4.0), high=(0.3, 5.0)), Box(low=(0.1 + 0.2, 4.0), high=(9.0, 5.0))
    surroundings = survey_world(
        World("joint", (SIDE, SIDE), ("open", "open"), obstacles=parts), 1.0
    )
    for x in (0.3, 0.1 + 0.2, 0.30000000000000002):
        assert first_crossing(surroundings, x, 3.0, 0.0, 0.0, 4.0, 0.0).share == pytest.approx(0.25)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), reach=st.sampled_from((0.05, 0.5, 4.0)))
def test_where_all_is_far_nothing_is_within_the_step(seed, reach):
    rng = np.random.default_rng(seed)
    world = yard(seed)
    surroundings = survey_world(world, reach)
    place = free_places(world, rng, 50)
    room = clearance(world, place)
    for at, clear in zip(place, room, strict=True):
        for r in (0.9 * clear, 1.1 * clear, 3.0 * clear):
            if is_far(surroundings, *at, 0.0, r):
                assert r < clear
    far = [
        is_far(surroundings, *at, 0.0, min(0.01 * r, 0.02))
        for at, r in zip(place, room, strict=True)
    ]
    assert np.mean(far) > 0.1


def test_no_number_crosses_nothing():
    surroundings = survey_world(yard(1), 1.0)
    for bad in (math.nan, math.inf):
        assert first_crossing(surroundings, 5.0, 5.0, 0.0, bad, 0.0, 0.0).share == math.inf
    assert not is_crossed(surroundings, 5.0, 5.0, 0.0, math.nan, 5.0, 0.0)
    assert 0.0 < skin(0.0, 0.0, 0.0) < skin(1e4, 0.0, 0.0) < 1e-4
