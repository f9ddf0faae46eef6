"""Nearest surfaces in space, against naive distances."""

import numpy as np
import pytest
from asking import Answer, each_solid, sights
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.geometry import to_box_edges, to_obstacle, to_prism, to_sphere
from scenes import crowds, solids

from worlds.obstacles import Box, Disc, Prism, Sphere
from worlds.queries.clearance import clearance
from worlds.queries.survey import survey_world
from worlds.world import World

FAR = 100.0


def space(*obstacles, edges=("open",) * 3, size=20.0):
    return World("test", (size,) * 3, edges, obstacles=tuple(obstacles))


def places(seed, n=40, low=-5.0, high=27.0):
    return np.random.default_rng(seed).uniform(low, high, (n, 3))


@settings(max_examples=30, deadline=None)
@given(solids, st.integers(0, 1000), st.sampled_from([1.0, 5.0, FAR]))
def test_distance_and_point_are_those_of_the_naive_oracle(obstacles, seed, reach):
    place = places(seed)
    expected = np.array([[to_obstacle(p, o) for o in obstacles] for p in place]).min(axis=1)
    answer = Answer(survey_world(space(*obstacles), reach), place)
    near = (expected <= reach) & (expected > 0.0)
    assert answer.distance[near] == pytest.approx(expected[near], abs=1e-9)
    assert np.isinf(answer.distance[expected > reach]).all()
    foot = answer.point[near] + answer.normal[near] * expected[near, None]
    assert foot == pytest.approx(place[near], abs=1e-7)
    assert np.linalg.norm(answer.normal[near], axis=1) == pytest.approx(1.0)
    touch = [min(abs(to_obstacle(p, o)) for o in obstacles) for p in answer.point[near]]
    assert np.array(touch) == pytest.approx(0.0, abs=1e-7)


@settings(max_examples=30, deadline=None)
@given(solids, st.integers(0, 1000))
def test_inside_the_depth_is_that_of_the_deepest_solid_or_more(obstacles, seed):
    place = places(seed, 100, 0.0, 22.0)
    each = np.array([[to_obstacle(p, o) for o in obstacles] for p in place])
    inside = each.min(axis=1) < 0.0
    found = Answer(survey_world(space(*obstacles), FAR), place).distance
    assert ((found < 0.0) == inside).all()
    assert (found[inside] <= each.min(axis=1)[inside] + 1e-9).all()


@settings(max_examples=25, deadline=None)
@given(crowds, st.integers(0, 1000))
def test_the_ground_agrees_with_the_clearance_of_arrays(obstacles, seed):
    world = space(*obstacles, edges=("open", "solid", "wrap"))
    place = places(seed, 100, 0.0, 20.0)
    found = Answer(survey_world(world, FAR), place).distance
    assert found == pytest.approx(clearance(world, place), abs=1e-9)


def test_a_cube_has_faces_edges_and_corners():
    surroundings = survey_world(space(Box(low=(0, 0, 0), high=(2, 2, 2))), FAR)
    answer = Answer(
        surroundings,
        [(1, 1, 3), (1, 1, -3), (3, 1, 1), (3, 1, 3), (3, 3, 1), (3, 3, 3), (1, 1, 0.25)],
    )
    root = np.sqrt([1.0, 9.0, 1.0, 2.0, 2.0, 3.0])
    assert answer.distance == pytest.approx([*root, -0.25])
    assert answer.smooth.tolist() == [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    assert answer.normal[5] == pytest.approx([3**-0.5] * 3)
    assert answer.normal[6].tolist() == [0.0, 0.0, -1.0]


def test_a_sphere_is_exact_and_round():
    place = places(4, 500)
    answer = Answer(survey_world(space(Sphere(centre=(10, 10, 10), radius=3)), FAR), place)
    expected = [to_sphere(p, (10, 10, 10), 3.0) for p in place]
    assert answer.distance == pytest.approx(np.array(expected), abs=1e-12)
    assert (answer.smooth == 1.0).all()


def test_the_middle_of_a_sphere_has_a_surface_too():
    answer = Answer(survey_world(space(Sphere(centre=(10, 10, 10), radius=3)), 1.0), [(10, 10, 10)])
    assert answer.distance[0] == -3.0
    assert np.linalg.norm(answer.normal[0]) == 1.0


def test_each_solid_of_a_stack_has_its_surface():
    world = space(
        Disc(centre=(10, 10), radius=2.0, top=4.0),
        Disc(centre=(10, 10), radius=2.0, bottom=10.0),
        Sphere(centre=(10, 10, 7), radius=1.0),
        edges=("open", "open", "solid"),
    )
    found = each_solid(survey_world(world, FAR), [(10.0, 10.0, 5.0)], 5)[0, :, 0]
    assert sorted(found.tolist()) == pytest.approx([1.0, 1.0, 5.0, 5.0, 15.0])


def test_six_solid_planes_close_a_box():
    place = places(9, 300, -3.0, 23.0)
    answer = Answer(survey_world(space(edges=("solid",) * 3), FAR), place)
    expected = [to_box_edges(p, (0, 0, 0), (20, 20, 20)) for p in place]
    assert answer.distance == pytest.approx(np.array(expected))


@settings(max_examples=20, deadline=None)
@given(solids, st.integers(0, 1000))
def test_a_line_of_sight_is_free_where_no_place_along_it_is_inside(obstacles, seed):
    start, end = places(seed, 5), places(seed + 1, 5)
    seen = sights(survey_world(space(*obstacles), 1.0), start, end)
    for free, a, b in zip(seen, start, end, strict=True):
        way = a + np.linspace(0.0, 1.0, 120)[:, None] * (b - a)
        least = min(naive(p, obstacles) for p in way)
        step = np.linalg.norm(b - a) / 119.0
        if least < 0.0:
            assert not free
        elif least > step:
            assert free


def naive(place, obstacles):
    return min(to_obstacle(place, o) for o in obstacles)


def test_one_sees_over_a_prism_but_not_through_its_top():
    surroundings = survey_world(
        space(Prism(points=((8, 8), (12, 8), (12, 12), (8, 12)), bottom=2, top=6)), 1.0
    )
    start = [(0, 10, 6.1), (0, 10, 5.9), (10, 10, 9), (0, 10, 1), (10, 10, 9), (10, 10, 4)]
    end = [(20, 10, 6.1), (20, 10, 5.9), (10, 10, 0), (20, 10, 1), (18, 10, 4), (10, 10, 5)]
    assert sights(surroundings, start, end).tolist() == [True, False, False, True, True, False]


def test_the_oracle_knows_a_unit_cube():
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    assert to_prism((0.5, 0.5, 0.5), square, 0.0, 1.0) == -0.5
    assert to_prism((2.0, 2.0, 2.0), square, 0.0, 1.0) == pytest.approx(3.0**0.5)
