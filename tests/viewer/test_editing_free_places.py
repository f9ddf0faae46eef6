"""Agents that an obstacle comes upon are put on the nearest free place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.viewer.editing.free_places import GAP, move_out
from worlds.input_error import InputError
from worlds.obstacles import Box, Disc, Polygon, Sphere
from worlds.queries.clearance import clearance
from worlds.world import World

DISC = Disc(centre=(5.0, 5.0), radius=2.0)
PLANE = World("plane", (10.0, 10.0), ("open", "open"), obstacles=(DISC,))
SPACE = World(
    "space",
    (10.0, 10.0, 10.0),
    ("solid", "solid", "solid"),
    obstacles=(DISC, Sphere(centre=(8.0, 8.0, 8.0), radius=1.0)),
)


def test_where_nothing_is_solid_nothing_moves():
    position = np.random.default_rng(1).uniform(0, 10, (50, 2))
    assert move_out(replace(PLANE, obstacles=()), position) is position
    assert move_out(PLANE, position[:0]).shape == (0, 2)


def test_those_inside_come_out_the_nearest_way_and_the_others_stay():
    position = np.array([[5.5, 5.0], [5.0, 3.5], [9.0, 9.0]])
    free = move_out(PLANE, position)
    gap = GAP * 10.0
    np.testing.assert_allclose(free, [[7.0 + gap, 5.0], [5.0, 3.0 - gap], [9.0, 9.0]], atol=0.05)
    np.testing.assert_array_equal(free[2], position[2])


@settings(max_examples=40, deadline=None)
@given(
    discs=st.lists(
        st.tuples(st.floats(0, 10), st.floats(0, 10), st.floats(0.1, 2.5)), min_size=1, max_size=5
    ),
    edges=st.tuples(st.sampled_from(["open", "solid"]), st.sampled_from(["wrap", "solid"])),
    seed=st.integers(0, 99),
)
def test_no_free_place_is_nearer_than_the_one_taken(discs, edges, seed):
    """Against a search of a fine grid of free places around each agent, by plain distance."""
    obstacles = tuple(Disc(centre=(x, y), radius=r) for x, y, r in discs)
    world = World("w", (10.0, 10.0), edges, obstacles=obstacles)
    position = np.random.default_rng(seed).uniform(0.0, 10.0, (20, 2))
    try:
        free = move_out(world, position)
    except InputError:
        return
    assert (clearance(world, free) > 0.0).all()
    axis = np.linspace(-5.0, 15.0, 161)
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    grid = grid[clearance(world, grid) > 2.0 * GAP * 10.0]
    way = free - position
    wraps = np.array([edge == "wrap" for edge in edges])
    way -= np.where(wraps, np.rint(way / 10.0) * 10.0, 0.0)
    for place, went in zip(position, np.linalg.norm(way, axis=1), strict=True):
        nearest = np.linalg.norm(grid - place, axis=1).min(initial=np.inf)
        assert went <= nearest + 1e-9


def test_across_a_wrapping_edge_they_come_in_again():
    world = World("w", (10.0, 10.0), ("wrap", "wrap"), obstacles=(Disc(centre=(0.5, 5), radius=1),))
    free = move_out(world, np.array([[0.1, 5.0], [9.8, 5.0]]))
    np.testing.assert_allclose(free, [[9.49, 5.0], [9.49, 5.0]], atol=0.05)
    assert not np.array_equal(free[0], free[1])


def test_beyond_a_solid_edge_they_come_in_again():
    world = replace(PLANE, edges=("solid", "open"))
    free = move_out(world, np.array([[-1.0, 2.0], [11.0, -7.0]]))
    np.testing.assert_allclose(free, [[0.01, 2.0], [9.99, -7.0]], atol=1e-9)


def test_no_two_are_put_on_the_same_spot():
    notch = Polygon(points=((0.0, 0.0), (10.0, 0.0), (10.0, 6.0), (5.0, 3.0), (0.0, 6.0)))
    position = np.array([[5.0, 2.9], [5.0, 2.5], [5.0, 2.0], [5.0, 2.0]])
    free = move_out(replace(PLANE, obstacles=(notch,)), position)
    assert len(np.unique(free, axis=0)) == 4
    assert (clearance(replace(PLANE, obstacles=(notch,)), free) > 0.0).all()


def test_a_world_without_a_free_place_is_refused():
    full = Box(low=(-1.0, -1.0), high=(11.0, 11.0))
    world = World("full", (10.0, 10.0), ("solid", "solid"), obstacles=(full,))
    with pytest.raises(InputError, match="no free place would be left for the agents in full"):
        move_out(world, np.array([[5.0, 5.0]]))
    cube = World("full", (10.0,) * 3, ("solid",) * 3, obstacles=(full,))
    with pytest.raises(InputError, match="no free place would be left"):
        move_out(cube, np.full((1, 3), 5.0))


def test_in_space_they_come_out_of_columns_spheres_and_the_room_itself():
    position = np.random.default_rng(2).uniform(-0.5, 10.5, (300, 3))
    free = move_out(SPACE, position)
    assert (clearance(SPACE, free) > 0.0).all()
    out = clearance(SPACE, position) > 0.0
    np.testing.assert_array_equal(free[out], position[out])
    went = np.linalg.norm(free - position, axis=1)
    depth = -clearance(SPACE, position)
    # 102 rays are at most some 15 degrees from the shortest way, on top of the gap of 0.01.
    alone = (depth > 0.0) & (np.linalg.norm(position[:, :2] - 5.0, axis=1) < 2.0)
    alone &= (position[:, 2] > 2.0) & (position[:, 2] < 8.0)
    assert (went[alone] < 1.25 * depth[alone] + 0.1).all()
    assert alone.sum() > 10
