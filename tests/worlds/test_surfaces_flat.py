"""Nearest surfaces on the plan, against shapely."""

import math

import numpy as np
import pytest
import shapely
from asking import Answer, each_solid, surfaces_within
from fine import demand_round, united
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scenes import crowds

from worlds.obstacles import Box, CShape, Disc, Polygon, Ring, Wall
from worlds.queries.clearance import clearance
from worlds.queries.survey import survey_world
from worlds.world import World

FAR = 100.0


FILLED_RING = (
    Disc(centre=(0.0, 0.0), radius=1.0),
    Ring(centre=(0.0, 0.0), radius=4.0, width=3.0),
)
"""Its images across the edges have holes without width, by rounding."""


def flat(*obstacles, size=20.0, edges=("open", "open"), low=()):
    return World("test", (size, size), edges, low=low, obstacles=tuple(obstacles))


def signed(outline, place):
    away = shapely.distance(outline.boundary, shapely.points(place))
    return np.where(shapely.contains_xy(outline, *place.T), -away, away)


def places(seed, n=200, low=-8.0, high=30.0):
    return np.random.default_rng(seed).uniform(low, high, (n, 2))


@settings(max_examples=60, deadline=None)
@given(crowds, st.integers(0, 1000), st.sampled_from([0.5, 3.0, FAR]))
def test_distance_point_and_normal_are_shapelys(obstacles, seed, reach):
    world = flat(*obstacles)
    place = places(seed)
    demand_round(world, reach)
    outline, slack = united(obstacles)
    close = 1e-9 + slack
    expected = signed(outline, place)
    answer = Answer(survey_world(world, reach), place)
    near = expected <= reach
    assert answer.distance[near] == pytest.approx(expected[near], abs=close)
    assert np.isinf(answer.distance[expected > reach + close]).all()
    assert answer.signed == pytest.approx(answer.distance, abs=1e-12)
    point, normal = answer.point[near, :2], answer.normal[near, :2]
    assert (shapely.distance(outline.boundary, shapely.points(point)) <= close).all()
    assert point + normal * expected[near, None] == pytest.approx(place[near], abs=1e-7 + slack)
    assert np.linalg.norm(normal, axis=1) == pytest.approx(1.0)
    assert (answer.normal[:, 2] == 0.0).all()


@settings(max_examples=40, deadline=None)
@given(crowds, st.integers(0, 1000), st.sampled_from([0.0, 0.5, 3.0, 50.0]))
def test_the_surface_within_a_distance_is_the_nearest_to_the_bit_or_none(obstacles, seed, r):
    surroundings = survey_world(flat(*obstacles), 20.0)
    place = places(seed)
    nearest = surfaces_within(surroundings, place, FAR)
    within = surfaces_within(surroundings, place, r)
    near = nearest[:, 0] <= r
    assert np.array_equal(within[near], nearest[near])
    assert np.isinf(within[~near, 0]).all()
    assert np.array_equal(nearest[:, 0], Answer(surroundings, place).distance)


@settings(max_examples=40, deadline=None)
@given(crowds, st.integers(0, 1000), st.sampled_from([2.0, FAR]))
def test_every_connected_outline_has_a_surface_of_its_own(obstacles, seed, reach):
    world = flat(*obstacles, edges=("solid", "open"))
    place = places(seed, 60)
    demand_round(world, reach)
    solid, slack = united(obstacles)
    parts = shapely.get_parts(solid)
    surroundings = survey_world(world, reach)
    assert len(surroundings.span) == len(parts)
    found = each_solid(surroundings, place, len(parts) + 2)
    assert (found[:, :, 4] <= 1.0).all()
    expected = np.sort([signed(part, place) for part in parts], axis=0)
    expected[expected > reach] = np.inf
    each = np.sort(found[:, :-2, 0], axis=1).T
    assert each == pytest.approx(expected, abs=1e-9 + slack)
    walls = np.column_stack([place[:, 0], 20.0 - place[:, 0]])
    walls[walls > reach] = np.inf
    assert found[:, -2:, 0] == pytest.approx(walls)


def test_a_square_has_four_sides_and_four_corners():
    answer = Answer(
        survey_world(flat(Box(low=(0.0, 0.0), high=(2.0, 2.0))), 5.0),
        [(1.0, 3.0), (3.0, 3.0), (5.0, 6.0), (1.0, 0.5), (2.0, 1.0), (2.0, 2.0)],
    )
    root = math.sqrt(0.5)
    assert answer.distance == pytest.approx([1.0, math.sqrt(2.0), 5.0, -0.5, 0.0, 0.0])
    assert answer.smooth.tolist() == [1.0, 0.0, 0.0, 1.0, 1.0, 0.0]
    assert answer.point[:, :2].tolist()[:4] == [[1.0, 2.0], [2.0, 2.0], [2.0, 2.0], [1.0, 0.0]]
    assert answer.normal[:, :2] == pytest.approx(
        np.array([(0, 1), (root, root), (0.6, 0.8), (0, -1), (1, 0), (root, root)])
    )


def test_curves_are_smooth_everywhere():
    place = places(3, 500)
    world = flat(Disc(centre=(10.0, 10.0), radius=4.0), Ring(centre=(2, 2), radius=2.0, width=0.5))
    assert (Answer(survey_world(world, FAR), place).smooth == 1.0).all()


def test_a_disc_and_a_ring_are_truly_round():
    """Closed forms: |p - c| - R outside of a disc, R - |p - c| within a ring's hole."""
    place = places(4, 4000)
    world = flat(Disc(centre=(15.0, 12.0), radius=3.5), Ring(centre=(3, 4), radius=4.0, width=1.0))
    answer = Answer(survey_world(world, FAR), place)
    to_disc = np.hypot(*(place - (15.0, 12.0)).T) - 3.5
    off = np.hypot(*(place - (3.0, 4.0)).T)
    expected = np.minimum(to_disc, np.where(off < 3.5, 3.0 - off, off - 4.0))
    assert answer.distance == pytest.approx(expected, abs=1e-13)
    assert clearance(world, place) == pytest.approx(expected, abs=1e-13)
    out = place[to_disc == expected] - (15.0, 12.0)
    normal = out / np.hypot(*out.T)[:, None]
    assert answer.normal[to_disc == expected, :2] == pytest.approx(normal, abs=1e-12)
    foot = (15.0, 12.0) + 3.5 * normal
    assert answer.point[to_disc == expected, :2] == pytest.approx(foot, abs=1e-12)
    assert (answer.smooth == 1.0).all()


def test_where_a_disc_and_a_wall_meet_the_corner_is_where_the_circle_is():
    """A disc of 5 at (10, 8) and a wall up to y = 11: they meet at x = 10 +- 4."""
    world = flat(Disc(centre=(10.0, 8.0), radius=5.0), Box(low=(1, 8), high=(19, 11)))
    surroundings = survey_world(world, FAR)
    assert len(surroundings.span) == 1
    answer = Answer(surroundings, [(6.0, 11.0), (14.0, 11.0), (10.0, 14.0), (13.0, 14.0)])
    assert answer.distance == pytest.approx([0.0, 0.0, 1.0, math.sqrt(45.0) - 5.0], abs=1e-13)
    assert answer.smooth.tolist() == [0.0, 0.0, 1.0, 1.0]


def test_the_middle_of_a_disc_is_as_deep_as_it_is_wide():
    answer = Answer(survey_world(flat(Disc(centre=(5.0, 5.0), radius=2.0)), 1.0), [(5.0, 5.0)])
    assert answer.distance[0] == pytest.approx(-2.0, abs=1e-15)
    assert np.linalg.norm(answer.normal[0]) == pytest.approx(1.0)


def test_an_outline_is_a_curve_where_it_turns_by_less_than_twenty_degrees():
    for turn, smooth in ((19.0, 1.0), (21.0, 0.0)):
        angle = math.radians(0.5 * turn)
        rise = 5.0 * math.tan(angle)
        roof = Polygon(points=((0, 0), (10, 0), (10, 5), (5, 5 + rise), (0, 5)))
        answer = Answer(survey_world(flat(roof), 5.0), [(5.0, 7.0 + rise)])
        assert answer.distance[0] == pytest.approx(2.0)
        assert answer.smooth[0] == smooth


def test_obstacles_that_meet_become_one_outline():
    left, right = Box(low=(0, 0), high=(2, 2)), Box(low=(2, 0), high=(4, 2))
    surroundings = survey_world(flat(left, right), 3.0)
    assert len(surroundings.span) == 1
    answer = Answer(surroundings, [(2.0, 1.5), (2.0, 2.5)])
    assert answer.distance == pytest.approx([-0.5, 0.5])
    assert answer.smooth.tolist() == [1.0, 1.0]


def test_a_place_between_shapes_that_touch_in_one_point_is_free():
    # Two triangles that touch in (10, 10), once as parts and once as a shape with a notch.
    apart = (
        Polygon(points=((10, 10), (12, 4), (14, 10.5))),
        Polygon(points=((10, 10), (6, 10.5), (8, 4))),
    )
    place = places(8, 2000, 9.0, 11.0)
    world = flat(*apart)
    expected = signed(united(apart)[0], place)
    assert Answer(survey_world(world, 9.0), place).distance == pytest.approx(expected, abs=1e-9)


def test_a_hole_that_touches_its_outline_in_one_point_is_free():
    shape = Polygon(
        points=((0, 0), (10, 0), (10, 10), (5, 9), (0, 10)),
        holes=(((5, 9), (2, 7.5), (5, 2), (8, 7.5)),),
    )
    assert shape.outline().is_valid
    place = places(5, 4000, 0.0, 11.0)
    expected = signed(shape.outline(), place)
    assert Answer(survey_world(flat(shape), FAR), place).distance == pytest.approx(
        expected, abs=1e-9
    )


def test_a_pocket_is_free_inside():
    pocket = CShape(centre=(10, 10), size=(6, 8), thickness=1.0, opening=180.0)
    answer = Answer(survey_world(flat(pocket), 9.0), [(10.0, 10.0), (12.5, 10.0), (7.0, 10.0)])
    assert answer.distance == pytest.approx([2.0, -0.5, 3.0])


@pytest.mark.parametrize("reach", [0.7, 4.0])
def test_solid_edges_are_planes(reach):
    world = flat(size=10.0, edges=("solid", "solid"), low=(-5.0, -5.0))
    place = places(1, 400, -7.0, 7.0)
    expected = np.minimum(5.0 - np.abs(place[:, 0]), 5.0 - np.abs(place[:, 1]))
    answer = Answer(survey_world(world, reach), place)
    near = expected <= reach
    assert answer.distance[near] == pytest.approx(expected[near])
    assert np.isinf(answer.distance[~near]).all()
    assert (answer.smooth[near] == 1.0).all()
    foot = answer.point[near] + answer.normal[near] * expected[near, None]
    assert foot[:, :2] == pytest.approx(place[near])


@settings(max_examples=25, deadline=None)
@given(crowds, st.integers(0, 1000))
@example((*FILLED_RING, Disc(centre=(1.0, 0.5), radius=1.0)), 0)
def test_obstacles_are_seen_across_wrapping_edges(obstacles, seed):
    place = places(seed, 100, 0.0, 20.0)
    demand_round(flat(*obstacles, edges=("wrap", "wrap")), 3.0)
    outline, slack = united(obstacles)
    images = [(dx, dy) for dx in (-20.0, 0.0, 20.0) for dy in (-20.0, 0.0, 20.0)]
    everywhere = shapely.union_all(
        [shapely.transform(outline, lambda at, by=by: at + by) for by in images]
    )
    answer = Answer(survey_world(flat(*obstacles, edges=("wrap", "wrap")), 3.0), place)
    expected = signed(everywhere, place)
    # A grid of images may differ from the union by rounding only.
    near = expected <= 2.999
    assert answer.distance[near] == pytest.approx(expected[near], abs=1e-7 + slack)


def test_nothing_is_near_in_an_empty_world():
    surroundings = survey_world(flat(), 5.0)
    assert surroundings.solids == 0
    assert np.isinf(Answer(surroundings, places(2)).distance).all()


def test_a_flat_and_a_tall_ground_have_one_type():
    import numba

    tall = World(
        "tall", (5.0, 5.0, 5.0), ("solid",) * 3, obstacles=(Disc(centre=(1, 1), radius=1),)
    )
    all_surroundings = [
        survey_world(w, 2.0)
        for w in (flat(), tall, flat(Wall(start=(0, 0), end=(3, 3), thickness=1)))
    ]
    assert len({numba.typeof(surroundings) for surroundings in all_surroundings}) == 1
