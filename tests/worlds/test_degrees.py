"""Plans in degrees: recognised, asked about, projected to the metres that a geodesic measures."""

import json
import sys

import numpy as np
import pytest
import shapely
from pyproj import Geod

from worlds.input_error import InputError
from worlds.readers import open_drawing, read_geometry
from worlds.readers.degrees import question_of_degrees
from worlds.readers.drawing_contents import PlanQuestion

GEOD = Geod(ellps="WGS84")
RING = [[8.65, 49.87], [8.6513, 49.8702], [8.651, 49.871], [8.65, 49.871], [8.65, 49.87]]


@pytest.fixture
def plan(tmp_path):
    def write(ring=RING, ending="geojson", **more):
        path = tmp_path / f"campus.{ending}"
        if ending == "wkt":
            path.write_text(shapely.Polygon(ring).wkt)
        else:
            path.write_text(json.dumps({"type": "Polygon", "coordinates": [ring], **more}))
        return path

    return write


def crs(name):
    return {"type": "name", "properties": {"name": name}}


def test_degrees_without_a_word_are_asked_about(plan):
    with pytest.raises(PlanQuestion) as question:
        read_geometry(plan())
    line = str(question.value)
    assert "(8.65, 49.87) to (8.6513, 49.871), look like longitude and latitude" in line
    assert "give --degrees to project them to metres, or --unit m" in line
    assert [choice.options for choice in question.value.choices] == [
        {"degrees": True}, {"unit": "m"}
    ]  # fmt: skip


def test_degrees_that_the_file_names_are_asked_about(plan):
    path = plan([[0, 0], [9, 0], [9, 9], [0, 0]], crs=crs("urn:ogc:def:crs:OGC:1.3:CRS84"))
    with pytest.raises(PlanQuestion, match=r"\(as the file says\): give --degrees") as question:
        read_geometry(path)
    assert len(question.value.choices) == 1


@pytest.mark.parametrize("ending", ["geojson", "wkt"])
def test_projected_lengths_and_areas_are_those_of_the_ellipsoid(plan, ending):
    taken = read_geometry(plan(ending=ending), degrees=True)
    area, around = GEOD.geometry_area_perimeter(shapely.Polygon(RING))
    assert taken.walkable.area == pytest.approx(area, rel=1e-6)
    assert taken.walkable.length == pytest.approx(around, rel=1e-6)
    # In which direction: the first corner from the middle, as a geodesic has it.
    x, y = taken.walkable.exterior.coords[0]
    azimuth, _, distance = GEOD.inv(8.65065, 49.8705, 8.65, 49.87)
    assert np.hypot(x, y) == pytest.approx(distance, rel=1e-6)
    assert np.degrees(np.arctan2(x, y)) == pytest.approx(azimuth, abs=1e-4)
    assert taken.changes == (
        "degrees are projected to metres, (0, 0) is longitude 8.65065, latitude 49.8705",
    )


def test_the_widest_plan_keeps_its_lengths(plan):
    ring = [[8.0, 49.5], [9.0, 49.5], [9.0, 50.5], [8.0, 50.5], [8.0, 49.5]]
    taken = read_geometry(plan(ring), degrees=True)
    corners = np.array(taken.walkable.exterior.coords)
    for k in range(4):
        _, _, distance = GEOD.inv(*ring[k], *ring[k + 1])
        assert np.hypot(*(corners[k + 1] - corners[k])) == pytest.approx(distance, rel=2e-4)


def test_radii_and_thicknesses_are_metres(tmp_path):
    path = tmp_path / "trees.geojson"
    tree = {"type": "Feature", "properties": {"kind": "tree", "radius": 1.5},
            "geometry": {"type": "Point", "coordinates": [8.65, 49.87]}}  # fmt: skip
    floor = {"type": "Feature", "properties": {"kind": "walkable"},
             "geometry": {"type": "Polygon", "coordinates": [RING]}}  # fmt: skip
    path.write_text(json.dumps({"type": "FeatureCollection", "features": [floor, tree]}))
    (disc,) = read_geometry(path, degrees=True).obstacles
    assert disc.radius == 1.5


@pytest.mark.parametrize(
    ("ring", "more"),
    [
        ([[0, 0], [24, 0], [24, 9], [0, 0]], {}),
        ([[0, 0], [4, 0], [4, 4], [0, 0]], {}),
        ([[0.25, 1.125], [4.5, 1.125], [4.5, 4], [0.25, 1.125]], {}),
        ([[474934.5, 5524542.1], [474964.5, 5524542.1], [474964.5, 5524572.1],
          [474934.5, 5524542.1]], {}),
        (RING, {"crs": crs("EPSG:25832")}),
    ],
)  # fmt: skip
def test_lengths_are_not_taken_for_degrees(plan, ring, more):
    contents = open_drawing(plan(ring, **more))
    assert question_of_degrees(contents, [(x, y) for x, y in ring]) is None


@pytest.mark.parametrize(
    ("ring", "options", "words"),
    [
        ([[0, 0], [200, 0], [200, 9], [0, 0]], {}, "longitudes are from -180 to 180"),
        ([[0, 0], [3, 0], [3, 2], [0, 0]], {}, "3 degrees wide: at most 1 is projected"),
        (RING, {"unit": "m"}, "--unit and --scale cannot be given"),
        (RING, {"scale": 2.0}, "--unit and --scale cannot be given"),
    ],
)
def test_what_cannot_be_projected_is_refused(plan, ring, options, words):
    with pytest.raises(InputError, match=words):
        read_geometry(plan(ring), degrees=True, **options)


def test_the_extra_is_named_where_it_is_missing(plan, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyproj", None)
    monkeypatch.setattr("worlds.plug_ins.find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"needs the package pyproj.*uv sync --extra maps"):
        read_geometry(plan(), degrees=True)


def test_degrees_are_for_two_formats(tmp_path):
    path = tmp_path / "a.map"
    path.write_text("type octile\nheight 1\nwidth 2\nmap\n.@\n")
    with pytest.raises(InputError, match=r"--degrees is for \.geojson, \.json, \.wkt files"):
        read_geometry(path, degrees=True)
