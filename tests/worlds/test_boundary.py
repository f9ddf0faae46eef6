"""Boundary points: where they are, and which of them are near."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from asking import within
from fine import demand_clear, demand_round, united
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scenes import crowds
from scipy.spatial import cKDTree

from worlds.mission import Goal, Mission
from worlds.obstacles import Box, Disc, Ring, Sphere
from worlds.queries.boundary import reference_place
from worlds.queries.outlines import solids
from worlds.queries.survey import survey_world
from worlds.world import World
from worlds.world_rotation import rotate_places, rotate_world


def flat(*obstacles, edges=("open", "open"), spacing=0.5):
    return World("test", (20.0, 20.0), edges, obstacles=tuple(obstacles), boundary_spacing=spacing)


def points_of(surroundings):
    return np.column_stack([surroundings.point_x, surroundings.point_y])


@settings(max_examples=40, deadline=None)
@given(crowds, st.sampled_from([0.2, 0.5, 2.0]))
@example(
    obstacles=(
        Disc(centre=(0.0, 0.0), radius=2.0),
        Disc(centre=(0.0, 1.0), radius=2.0),
        Ring(centre=(0.0, 0.0), radius=4.438000000000001, width=2.438),
    ),
    spacing=0.2,
)
def test_they_lie_on_the_united_outline_and_leave_no_gap(obstacles, spacing):
    demand_round(flat(*obstacles), 3.0)
    solid, slack = united(obstacles)
    outline = solid.boundary
    points = points_of(survey_world(flat(*obstacles, spacing=spacing), 3.0))
    assert shapely.distance(outline, shapely.points(points)).max() < 1e-9 + slack
    # No place of the outline is further than half the spacing from a point.
    reached = shapely.union_all(
        shapely.buffer(shapely.points(points), 0.5 * spacing + 1e-6, quad_segs=64)
    )
    assert shapely.difference(outline, reached).length < 1e-3 * outline.length


def test_each_side_is_divided_evenly_between_its_corners():
    points = points_of(survey_world(flat(Box(low=(1, 1), high=(3, 3)), spacing=0.6), 2.0))
    assert len(points) == 16
    at = (1.25, 1.75, 2.25, 2.75)
    expected = [(x, y) for x in at for y in (1, 3)] + [(x, y) for x in (1, 3) for y in at]
    assert np.array(sorted(points.tolist())) == pytest.approx(np.array(sorted(expected)))


def test_a_disc_has_its_points_on_the_circle_the_first_towards_the_goal():
    goal = Mission(goal=Goal(route=((10.0, 16.0),)))
    world = replace(flat(Disc(centre=(10.0, 8.0), radius=2.0)), mission=goal)
    points = points_of(survey_world(world, 2.0)) - (10.0, 8.0)
    assert np.hypot(*points.T) == pytest.approx(2.0, abs=1e-14)
    angle = np.sort(np.arctan2(*points.T) % (2.0 * np.pi))  # from +y, clockwise
    assert len(angle) == np.ceil(2.0 * np.pi * 2.0 / 0.5)
    assert angle == pytest.approx(np.arange(len(angle)) * 2.0 * np.pi / len(angle), abs=1e-12)


def test_where_two_discs_meet_the_points_know_the_circles():
    discs = Disc(centre=(8.0, 10.0), radius=3.0), Disc(centre=(12.0, 10.0), radius=2.5)
    points = points_of(survey_world(flat(*discs), 2.0))
    one, other = (np.hypot(*(points - disc.centre).T) - disc.radius for disc in discs)
    assert np.minimum(np.abs(one), np.abs(other)) == pytest.approx(0.0, abs=1e-13)
    assert (np.maximum(one, other) > 0.0).all()
    # They meet at x = 8 + (16 + 9 - 6.25) / 8; from there on each arc is divided evenly.
    meets = np.arccos(18.75 / 8.0 / 3.0)
    angle = np.sort(
        np.arctan2(*(points[np.abs(one) < 1e-9] - discs[0].centre).T[::-1]) % (2 * np.pi)
    )
    length = 2.0 * np.pi - 2.0 * meets
    number = np.ceil(3.0 * length / 0.5)
    assert angle == pytest.approx(meets + length * (np.arange(number) + 0.5) / number, abs=1e-12)


scenes = st.tuples(crowds, st.integers(0, 2**32 - 1), st.sampled_from([0.2, 0.5, 2.0]))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(scenes, st.booleans())
def test_they_turn_and_move_with_the_scene_wherever_its_rings_begin(scene, led):
    obstacles, seed, spacing = scene
    rng = np.random.default_rng(seed)
    world = flat(*obstacles, spacing=spacing)
    if led:
        world = replace(world, mission=Mission(goal=Goal(route=(tuple(rng.uniform(0, 20, 2)),))))
    angle, by = rng.uniform(0.0, 360.0), rng.uniform(-50.0, 50.0, 2)
    other = rotate_world(world, angle, rng)
    moved = [one.moved(*by) for one in other.obstacles]
    mission = other.mission
    if led:
        route = (tuple(np.array(mission.goal.route[0]) + by),)
        mission = Mission(goal=Goal(route=route))
    other = replace(other, obstacles=tuple(moved), mission=mission)
    for one in (world, other):
        demand_round(one, 3.0)
        demand_clear(one)
    if not led:  # a round shape alone in the middle of all has no side of its own
        outlines = [one for _, parts in solids(world, 3.0) for one in parts]
        middle = reference_place(world, outlines)
        whole = [r.centre[0] for one in outlines for r in one.rings if len(r.start) == 1]
        assume(all(np.hypot(*(middle - centre)) > 1e-3 for centre in whole))
    points, found = points_of(survey_world(world, 3.0)), points_of(survey_world(other, 3.0))
    expected = rotate_places(points, angle, np.array([10.0, 10.0])) + by
    assert len(found) == len(expected)
    away, which = cKDTree(found).query(expected)
    assert away.max() < 1e-6
    assert len(set(which.tolist())) == len(found)


def test_hidden_parts_have_none():
    world = flat(
        Box(low=(-1, 5), high=(2, 7)), Disc(centre=(18, 10), radius=4), edges=("solid", "solid")
    )
    points = points_of(survey_world(world, 2.0))
    assert (points >= -1e-9).all()
    assert (points <= 20.0 + 1e-9).all()
    on_left = points[points[:, 0] == 0.0]
    assert not ((on_left[:, 1] > 5.0) & (on_left[:, 1] < 7.0)).any()
    corners = {(0.0, 0.0), (20.0, 0.0), (0.0, 20.0), (20.0, 20.0)}
    assert corners <= {tuple(p) for p in points.tolist()}
    assert len(np.unique(points, axis=0)) == len(points)


def test_solid_edges_of_a_corridor_have_both_ends():
    points = points_of(survey_world(flat(edges=("open", "solid"), spacing=5.0), 2.0))
    assert sorted(points.tolist()) == [[x, y] for x in (0, 5, 10, 15, 20) for y in (0, 20)]


def test_solid_edges_go_on_across_a_seam():
    points = points_of(survey_world(flat(edges=("wrap", "solid"), spacing=1.0), 3.0))
    assert points[:, 0].min() == -3.0
    assert points[:, 0].max() == 23.0


def test_there_are_none_in_space_or_without_outlines():
    tall = World(
        "tall", (9.0,) * 3, ("solid",) * 3, obstacles=(Sphere(centre=(4, 4, 4), radius=1),)
    )
    for world in (tall, flat()):
        surroundings = survey_world(world, 2.0)
        assert len(surroundings.point_x) == surroundings.most_points == 0
        assert len(within(surroundings, 4.0, 4.0, 2.0)) == 0


@settings(max_examples=40, deadline=None)
@given(crowds, st.integers(0, 1000), st.sampled_from([0.4, 3.0, 50.0]))
def test_those_within_reach_are_those_of_a_search_through_all(obstacles, seed, reach):
    surroundings = survey_world(flat(*obstacles, edges=("solid", "open")), reach)
    points = points_of(surroundings)
    rng = np.random.default_rng(seed)
    for x, y, share in rng.uniform([-8, -8, 0.1], [28, 28, 1.0], (40, 3)):
        r = reach * share if seed % 2 else reach
        expected = np.flatnonzero(np.hypot(points[:, 0] - x, points[:, 1] - y) <= r)
        found = within(surroundings, x, y, r)
        assert sorted(found.tolist()) == expected.tolist()
        assert len(found) < surroundings.most_points


def test_no_place_has_more_than_the_room_they_are_given():
    surroundings = survey_world(flat(Disc(centre=(10, 10), radius=1.0), spacing=0.1), 2.5)
    for x, y in np.random.default_rng(0).uniform(7.0, 13.0, (300, 2)):
        assert len(within(surroundings, x, y, 2.5)) < surroundings.most_points
