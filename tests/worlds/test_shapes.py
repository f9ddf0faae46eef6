"""Obstacles: their areas and places, and what is refused."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from scenes import flat, solids, unions

from worlds.input_error import InputError
from worlds.obstacles import SHAPES, CShape, Disc, Polygon, Ring, Union, Wall, obstacle


def circle_area(radius):
    return 0.5 * 128 * radius**2 * math.sin(2.0 * math.pi / 128)


@pytest.mark.parametrize(
    ("shape", "area", "bounds"),
    [
        (Disc(centre=(1, 2), radius=3), circle_area(3), (-2, -1, 4, 5)),
        (
            Ring(centre=(0, 0), radius=3, width=1),
            circle_area(3) - circle_area(2),
            (-3, -3, 3, 3),
        ),
        (Wall(start=(0, 0), end=(0, 4), thickness=0.5), 2.0, (-0.25, 0, 0.25, 4)),
        (CShape(centre=(0, 0), size=(4, 6), thickness=1), 12.0, (-2, -3, 2, 3)),
        (CShape(centre=(0, 0), size=(4, 6), thickness=1, opening=90), 12.0, (-3, -2, 3, 2)),
        (Polygon(points=((0, 0), (4, 0), (0, 4))), 8.0, (0, 0, 4, 4)),
    ],
)
def test_areas_and_bounds(shape, area, bounds):
    assert shape.footprint().area == pytest.approx(area)
    assert shape.footprint().bounds == pytest.approx(bounds)


@pytest.mark.parametrize(
    ("opening", "free"), [(0, (1.5, 0)), (90, (0, 1.5)), (180, (-1.5, 0)), (270, (0, -1.5))]
)
def test_a_pocket_is_open_where_it_says(opening, free):
    pocket = CShape(centre=(0, 0), size=(4, 4), thickness=1.0, opening=opening).footprint()
    assert not pocket.intersects(shapely.Point(free))
    assert pocket.intersects(shapely.Point(-free[0], -free[1]))


def test_a_pocket_at_right_angles_has_exact_corners():
    pocket = CShape(centre=(50, 23), size=(8, 14), thickness=1, opening=180)
    corners = {(46, 16), (54, 16), (54, 30), (46, 30), (46, 29), (53, 29), (53, 17), (46, 17)}
    assert set(pocket.footprint().exterior.coords) == corners


@given(st.one_of(flat, unions), st.floats(-50, 50), st.floats(-50, 50))
def test_moved_obstacles_keep_their_shape(shape, dx, dy):
    there = shape.moved(dx, dy)
    assert type(there) is type(shape)
    expected = shapely.transform(shape.footprint(), lambda at: at + np.array([dx, dy]))
    assert there.footprint().area == pytest.approx(expected.area)
    assert there.footprint().bounds == pytest.approx(expected.bounds, abs=1e-9)


@given(solids, st.integers(-9, 9))
def test_solids_move_upwards_too(shapes, dz):
    union = Union(parts=shapes)
    there = union.moved(0.0, 0.0, float(dz))
    before = [(low + dz, high + dz) for _, low, high in union.spans()]
    assert [(low, high) for _, low, high in there.spans()] == before
    assert [c[2] for c, _ in there.spheres()] == [c[2] + dz for c, _ in union.spheres()]


def test_a_flat_shape_moves_its_heights():
    there = Disc(centre=(0, 0), radius=1, bottom=1.0, top=3.0).moved(1, 2, 4)
    assert (there.centre, there.bottom, there.top) == ((1, 2), 5.0, 7.0)
    assert Disc(centre=(0, 0), radius=1).moved(0, 0, 4).top is None


DISC = {"shape": "disc", "centre": [0, 0], "radius": 1}


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({**DISC, "shape": "dics"}, "unknown shape 'dics': did you mean 'disc'?"),
        ({"centre": [0, 0]}, "has no shape"),
        ({"shape": "disc", "centre": [0, 0]}, "obstacle disc has no radius (w.toml)"),
        ({**DISC, "radius": -1}, "obstacle disc: radius = -1 is not allowed"),
        ({**DISC, "radius": True}, "radius = True is not allowed"),
        ({**DISC, "radius": float("nan"), "name": "pond"}, "obstacle 'pond': radius = nan"),
        ({**DISC, "centre": [0, float("inf")]}, "obstacle disc: centre.1 = inf is not allowed"),
        ({**DISC, "colour": "red"}, "obstacle disc has an unknown key 'colour'"),
        ({**DISC, "bottom": 3, "top": 2}, "obstacle disc: top = 2 is not above bottom = 3"),
        (
            {"shape": "wall", "start": [1, 1], "end": [1, 1], "thickness": 1},
            "start and end are both [1.0, 1.0]: a wall needs a length",
        ),
        (
            {"shape": "ring", "centre": [0, 0], "radius": 1, "width": 2},
            "width = 2 leaves no hole in radius = 1",
        ),
        (
            {"shape": "c", "centre": [0, 0], "size": [3, 2], "thickness": 1},
            "thickness = 1 leaves no room in size = [3.0, 2.0]",
        ),
        ({"shape": "box", "low": [0, 0], "high": [1, 0]}, "high = [1.0, 0.0] is not above"),
        ({"shape": "box", "low": [0, 0], "high": [1, 1, 1]}, "differ in dimension"),
        (
            {"shape": "box", "low": [0, 0, 0], "high": [1, 1, 1], "top": 4},
            "a box with three coordinates has its own bottom and top",
        ),
        (
            {"shape": "prism", "points": [[0, 0], [1, 0], [0, 1]], "bottom": 2, "top": 1},
            "top = 1 is not above bottom = 2",
        ),
        ({"shape": "polygon", "points": [[0, 0], [1, 1]]}, "at least 3 are needed"),
        ({"shape": "union", "parts": []}, "obstacle union: parts = [] is not allowed"),
        ({"shape": "union", "parts": [{**DISC, "radius": 0}]}, "union: parts.0.radius = 0"),
        ({"shape": "union", "parts": [{**DISC, "shape": "dot"}]}, "unknown shape 'dot'"),
    ],
)
def test_refusals(values, says):
    with pytest.raises(InputError) as refused:
        obstacle(values, "w.toml")
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)


def test_every_shape_is_known():
    assert len(SHAPES) == 9
