"""What drawings have that is harmless is read; what is wrong is told so that it can be found."""

import json
import warnings

import numpy as np
import pytest

from worlds.input_error import InputError
from worlds.obstacles import Polygon
from worlds.queries.clearance import clearance
from worlds.readers import read_geometry, world_around
from worlds.world import World

SOLID = {"obstacle": ["*"]}


@pytest.fixture
def wkt(tmp_path):
    def write(text):
        path = tmp_path / "plan.wkt"
        path.write_text(text)
        return path

    return write


def ring(*points):
    return {"type": "Polygon", "coordinates": [list(points)]}


def test_repeated_corners_count_once_and_warn_of_nothing(wkt):
    path = wkt("kiosk: POLYGON ((0 0, 8 0, 8 0, 8 8, 8 8, 0 8, 0 0, 0 0))")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        (made,) = read_geometry(path, SOLID).obstacles
        distance = clearance(world_around(read_geometry(path, SOLID)), np.array([[10.0, 4.0]]))
    assert made.points == ((0, 0), (8, 0), (8, 8), (0, 8))
    assert distance[0] < 2.0  # the edge of the box is nearer


def test_a_layout_with_repeated_corners_has_distances():
    block = Polygon(points=((2, 2), (8, 2), (8, 2), (8, 8), (2, 8), (2, 2)))
    assert block.points == ((2, 2), (8, 2), (8, 8), (2, 8))
    world = World("w", (20.0, 20.0), ("open", "open"), obstacles=(block,))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert clearance(world, np.array([[11.0, 2.0]]))[0] == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("hole", "area"),
    [
        ("0 2, 2 2, 2 4, 0 4, 0 2", 60.0),
        ("0 2, 2 2, 2 4, 0 2", 62.0),
        ("6 6, 8 6, 8 8, 6 8, 6 6", 60.0),
        ("2 2, 3 2, 3 3, 2 3, 2 2), (3 2, 4 2, 4 3, 3 3, 3 2", 62.0),
    ],
)
def test_a_hole_may_touch_the_outline_or_another(wkt, hole, area):
    (made,) = read_geometry(wkt(f"kiosk: POLYGON ((0 0, 8 0, 8 8, 0 8, 0 0), ({hole}))")).obstacles
    assert made.footprint().area == area
    assert made.footprint().is_valid


@pytest.mark.parametrize(
    ("holes", "words"),
    [
        ("(0 2, 8 2, 8 4, 0 4, 0 2)", "is cut into 2 by its holes: draw each part"),
        ("(6 2, 9 2, 9 4, 6 4, 6 2)", "a hole that crosses it: at (8.5, 3) the hole is outside"),
        ("(1 1, 5 1, 5 5, 1 1), (2 1.5, 6 1.5, 6 4, 2 1.5)", "two holes that overlap at"),
        ("(1 1, 3 3, 3 1, 1 3, 1 1)", "crosses itself at (2, 2)"),
    ],
)
def test_a_hole_that_leaves_no_one_area_is_told(wkt, holes, words):
    with pytest.raises(InputError) as refusal:
        read_geometry(wkt(f"kiosk: POLYGON ((0 0, 8 0, 8 8, 0 8, 0 0), {holes})"))
    assert words in str(refusal.value)


def test_outlines_open_by_rounding_are_closed_and_others_told(tmp_path, wkt):
    path = tmp_path / "plan.geojson"
    path.write_text(json.dumps(ring([0, 0], [4, 0], [4, 4], [0, 4], [1e-13, 0])))
    assert read_geometry(path, SOLID).obstacles[0].footprint().area == pytest.approx(16.0)
    near = wkt("kiosk: POLYGON ((0.1 0, 4 0, 4 4, 0 4, 0.10000000000001 0))")
    assert read_geometry(near).obstacles[0].points[0] == (0.1, 0)
    # So far from the origin that nine digits do not tell the ends apart.
    x = 474934567.25
    path.write_text(json.dumps(ring([x, 0], [x + 4, 0], [x + 4, 4], [x, 4], [x + 0.25, 0])))
    with pytest.raises(InputError) as refusal:
        read_geometry(path, SOLID)
    assert "begins at (474934567.25, 0) and ends at (474934567.5, 0), 0.25 apart: close it" in (
        str(refusal.value)
    )


@pytest.mark.parametrize("encoding", ["latin-1", "cp1252", "utf-8-sig", "utf-16"])
def test_names_in_any_usual_encoding_are_read(tmp_path, encoding):
    path = tmp_path / "plan.wkt"
    path.write_bytes("Säule: POLYGON ((0 0, 4 0, 4 4, 0 0))\n".encode(encoding))
    (made,) = read_geometry(path, SOLID).obstacles
    assert made.name == "Säule"


def test_what_is_no_text_is_told(tmp_path):
    path = tmp_path / "plan.wkt"
    path.write_bytes(b"\x00\x01\xff\xd8" * 9)
    with pytest.raises(InputError, match="is not a text file: it holds control codes"):
        read_geometry(path)
