"""Boundary points: where they are, and which of them are near."""

import numpy as np
import pytest
import shapely
from asking import within
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import crowds

from worlds.obstacles import Box, Disc, Sphere
from worlds.queries.survey import survey
from worlds.world import World


def flat(*obstacles, edges=("open", "open"), spacing=0.5):
    return World("test", (20.0, 20.0), edges, obstacles=tuple(obstacles), boundary_spacing=spacing)


def points_of(surroundings):
    return np.column_stack([surroundings.point_x, surroundings.point_y])


@settings(max_examples=40, deadline=None)
@given(crowds, st.sampled_from([0.2, 0.5, 2.0]))
def test_they_lie_on_the_united_outline_and_leave_no_gap(obstacles, spacing):
    outline = shapely.union_all([o.footprint() for o in obstacles]).boundary
    points = points_of(survey(flat(*obstacles, spacing=spacing), 3.0))
    assert shapely.distance(outline, shapely.points(points)) == pytest.approx(0.0, abs=1e-9)
    # No place of the outline is further than half the spacing from a point.
    reached = shapely.union_all(
        shapely.buffer(shapely.points(points), 0.5 * spacing + 1e-6, quad_segs=64)
    )
    assert shapely.difference(outline, reached).length < 1e-3 * outline.length


def test_an_outline_is_divided_evenly_along_the_whole_of_it():
    points = points_of(survey(flat(Box(low=(1, 1), high=(3, 3)), spacing=0.6), 2.0))
    assert len(points) == 14
    ring = shapely.LinearRing([(1, 1), (3, 1), (3, 3), (1, 3)])
    along = np.sort(shapely.line_locate_point(ring, shapely.points(points)))
    assert np.diff(along) == pytest.approx(8.0 / 14.0)


def test_hidden_parts_have_none():
    world = flat(
        Box(low=(-1, 5), high=(2, 7)), Disc(centre=(18, 10), radius=4), edges=("solid", "solid")
    )
    points = points_of(survey(world, 2.0))
    assert (points >= -1e-9).all()
    assert (points <= 20.0 + 1e-9).all()
    on_left = points[points[:, 0] == 0.0]
    assert not ((on_left[:, 1] > 5.0) & (on_left[:, 1] < 7.0)).any()
    corners = {(0.0, 0.0), (20.0, 0.0), (0.0, 20.0), (20.0, 20.0)}
    assert corners <= {tuple(p) for p in points.tolist()}
    assert len(np.unique(points, axis=0)) == len(points)


def test_solid_edges_of_a_corridor_have_both_ends():
    points = points_of(survey(flat(edges=("open", "solid"), spacing=5.0), 2.0))
    assert sorted(points.tolist()) == [[x, y] for x in (0, 5, 10, 15, 20) for y in (0, 20)]


def test_solid_edges_go_on_across_a_seam():
    points = points_of(survey(flat(edges=("wrap", "solid"), spacing=1.0), 3.0))
    assert points[:, 0].min() == -3.0
    assert points[:, 0].max() == 23.0


def test_there_are_none_in_space_or_without_outlines():
    tall = World(
        "tall", (9.0,) * 3, ("solid",) * 3, obstacles=(Sphere(centre=(4, 4, 4), radius=1),)
    )
    for world in (tall, flat()):
        surroundings = survey(world, 2.0)
        assert len(surroundings.point_x) == surroundings.most_points == 0
        assert len(within(surroundings, 4.0, 4.0, 2.0)) == 0


@settings(max_examples=40, deadline=None)
@given(crowds, st.integers(0, 1000), st.sampled_from([0.4, 3.0, 50.0]))
def test_those_within_reach_are_those_of_a_search_through_all(obstacles, seed, reach):
    surroundings = survey(flat(*obstacles, edges=("solid", "open")), reach)
    points = points_of(surroundings)
    rng = np.random.default_rng(seed)
    for x, y, share in rng.uniform([-8, -8, 0.1], [28, 28, 1.0], (40, 3)):
        r = reach * share if seed % 2 else reach
        expected = np.flatnonzero(np.hypot(points[:, 0] - x, points[:, 1] - y) <= r)
        found = within(surroundings, x, y, r)
        assert sorted(found.tolist()) == expected.tolist()
        assert len(found) < surroundings.most_points


def test_no_place_has_more_than_the_room_they_are_given():
    surroundings = survey(flat(Disc(centre=(10, 10), radius=1.0), spacing=0.1), 2.5)
    for x, y in np.random.default_rng(0).uniform(7.0, 13.0, (300, 2)):
        assert len(within(surroundings, x, y, 2.5)) < surroundings.most_points
