"""What a click means."""

from __future__ import annotations

import numpy as np
import pytest

from app.viewer.editing.free_places import floor_place, obstacle_hit
from worlds.obstacles import Box, Disc, Ring, Sphere
from worlds.world import World

PLANE = World(
    "plane",
    (10.0, 10.0),
    ("open", "open"),
    obstacles=(Disc(centre=(2.0, 2.0), radius=1.0), Ring(centre=(7.0, 7.0), radius=2.0, width=0.5)),
)
DOWN = np.array([0.0, 0.0, -1.0])


def test_a_ray_meets_the_floor_in_front_of_it_only():
    place = floor_place(PLANE, np.array([1.0, 1.0, 5.0]), np.array([1.0, 0.0, -1.0]))
    np.testing.assert_allclose(place, [6.0, 1.0])
    assert floor_place(PLANE, np.array([1.0, 1.0, 5.0]), np.array([1.0, 0.0, 1.0])) is None
    assert floor_place(PLANE, np.array([1.0, 1.0, 5.0]), np.array([1.0, 0.0, 0.0])) is None
    assert floor_place(PLANE, np.array([np.nan, 1.0, 5.0]), DOWN) is None
    assert floor_place(PLANE, np.array([1.0, 1.0, 5.0]), np.array([1e300, 0.0, -1e-300])) is None


def test_the_floor_of_a_room_is_its_lower_end():
    room = World("room", (9.0, 9.0, 9.0), ("open",) * 3, low=(0.0, 0.0, -2.0))
    place = floor_place(room, np.array([1.0, 1.0, 3.0]), np.array([0.0, 1.0, -1.0]))
    np.testing.assert_allclose(place, [1.0, 6.0])


@pytest.mark.parametrize(
    ("at", "hit"),
    [((2.0, 2.5), 0), ((7.0, 7.0), None), ((8.8, 7.0), 1), ((5.0, 5.0), None)],
)
def test_from_above_an_obstacle_is_hit_within_its_outline(at, hit):
    assert obstacle_hit(PLANE, np.array([*at, 40.0]), DOWN, 0.5) == hit


def test_from_aside_its_top_counts_too():
    over, slope, level = np.array([-1.0, 2.0, 4.3]), np.array([1.0, 0.0, -1.0]), [1.0, 0.0, 0.0]
    assert obstacle_hit(PLANE, over, slope, 0.5) == 0
    assert obstacle_hit(PLANE, over, slope, 0.01) is None
    assert obstacle_hit(PLANE, np.array([-1.0, 2.0, 1.8]), slope, 0.5) is None
    assert obstacle_hit(PLANE, np.array([-1.0, 2.0, 0.2]), np.array(level), 0.5) == 0
    assert obstacle_hit(PLANE, np.array([-1.0, 2.0, 0.7]), np.array(level), 0.5) is None
    assert obstacle_hit(PLANE, np.array([4.0, 2.0, 0.2]), np.array(level), 0.5) is None


def test_of_two_in_a_line_the_first_is_meant():
    room = World(
        "room",
        (9.0, 9.0, 9.0),
        ("open",) * 3,
        obstacles=(
            Box(low=(3.0, 3.0, 0.0), high=(6.0, 6.0, 2.0)),
            Sphere(centre=(4.5, 4.5, 5.0), radius=1.0),
        ),
    )
    assert obstacle_hit(room, np.array([4.5, 4.5, 20.0]), DOWN, 0.0) == 1
    assert obstacle_hit(room, np.array([3.2, 4.5, 20.0]), DOWN, 0.0) == 0
    assert obstacle_hit(room, np.array([4.5, 4.5, -9.0]), -DOWN, 0.0) == 0
    assert obstacle_hit(room, np.array([4.5, 4.5, -9.0]), np.zeros(3), 0.0) is None
    assert obstacle_hit(room, np.array([4.5, 4.5, 20.0]), np.full(3, np.nan), 0.0) is None
