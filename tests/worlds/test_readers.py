"""Drawings as worlds: what is read is what is drawn, and what cannot be used is named."""

import json
import math

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from worlds.input_error import InputError
from worlds.obstacles import Disc, Polygon, Wall
from worlds.readers import read_geometry, world_around
from worlds.readers.formats.dxf import arc

SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0]]
BOW = [[0, 0], [2, 2], [2, 0], [0, 2], [0, 0]]


def feature(geometry, **properties):
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def polygon(*rings):
    return {"type": "Polygon", "coordinates": list(rings)}


@pytest.fixture
def geojson(tmp_path):
    def write(*features, **more):
        path = tmp_path / "plan.geojson"
        collection = {"type": "FeatureCollection", "features": list(features), **more}
        path.write_text(json.dumps(collection))
        return path

    return write


@pytest.fixture
def wkt(tmp_path):
    def write(*lines):
        path = tmp_path / "plan.wkt"
        path.write_text("\n".join(lines))
        return path

    return write


SOLID = {"obstacle": ["*"]}


def refused(path, roles=SOLID, **options):
    with pytest.raises(InputError) as refusal:
        read_geometry(path, roles, **options)
    line = str(refusal.value)
    assert "\n" not in line
    assert path.name in line
    return line


def test_geojson_features_are_obstacles_with_names_and_heights(geojson):
    hole = [[1, 1], [1, 2], [2, 2], [2, 1], [1, 1]]
    path = geojson(
        feature(polygon(SQUARE, hole), name="kiosk", top=3),
        feature({"type": "Point", "coordinates": [9, 2]}, id=7, radius=0.5, kind="tree"),
        feature({"type": "LineString", "coordinates": [[6, 0], [6, 5]]}, thickness=0.2),
        feature({"type": "MultiPolygon", "coordinates": [[SQUARE], [[[5, 5], [6, 5], [6, 6],
                                                                    [5, 5]]]]}, name="two"),
    )  # fmt: skip
    kiosk, tree, wall, one, other = read_geometry(path, SOLID, scale=2.0).obstacles
    assert kiosk == Polygon(
        name="kiosk",
        points=((0, 0), (8, 0), (8, 8), (0, 8)),
        holes=(((2, 2), (2, 4), (4, 4), (4, 2)),),
        top=6.0,
    )
    assert tree == Disc(name="7", centre=(18.0, 4.0), radius=1.0)
    assert wall == Wall(name="obstacle", start=(12, 0), end=(12, 10), thickness=0.4)
    assert (one.name, other.name) == ("two", "two")
    assert other.footprint().area == 2.0


def test_a_bare_geometry_and_a_collection_are_read(tmp_path):
    path = tmp_path / "plan.json"
    path.write_text(json.dumps({"type": "GeometryCollection", "geometries": [polygon(SQUARE)]}))
    assert read_geometry(path).walkable.area == 16.0
    assert [one.footprint().area for one in read_geometry(path, SOLID).obstacles] == [16.0]


def refused_role(path):
    with pytest.raises(InputError) as refusal:
        read_geometry(path, {"solid": ["trees"]})
    return str(refusal.value)


def test_layers_choose_what_is_solid_and_what_is_walkable(geojson):
    path = geojson(
        feature(polygon(SQUARE), kind="walkable"),
        feature({"type": "Point", "coordinates": [2, 2]}, radius=1, layer="trees"),
        feature({"type": "Point", "coordinates": [1, 1]}, kind="notes"),
    )
    taken = read_geometry(path, {"obstacle": ["Trees"], "ignore": ["notes"]})
    assert [one.name for one in taken.obstacles] == ["trees"]
    assert taken.walkable.equals(shapely.box(0, 0, 4, 4))
    turned = {"obstacle": ["walkable"], "walkable": ["trees"], "ignore": ["*"]}
    assert read_geometry(path, turned).walkable.area < math.pi
    line = refused(path, {"obstacle": ["tree"]})
    assert "unknown layer 'tree': did you mean 'trees'?" in line
    assert "unknown layer 'walk'" in refused(path, {"walkable": ["walk"]})
    both = {"obstacle": ["walkable"], "walkable": ["walk*", "Walkable"]}
    assert "layer 'walkable' cannot be obstacle and walkable" in refused(path, both)
    assert "unknown role 'solid'" in refused_role(path)
    assert "a Point at (1, 1) bounds no area" in refused(path)


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (feature(polygon(BOW), name="bow"), ["feature 1 'bow'", "crosses itself at (1, 1)"]),
        (feature(polygon(SQUARE[:-1])), ["not closed", "begins at (0, 0) and ends at (0, 4)"]),
        (feature(polygon([[0, 0], [1, 1], [2, 2], [0, 0]])), ["outline at (0, 0) has no area"]),
        (feature(polygon([[0, 0], [1, 1], [0, 0]])), ["has 2 points: at least 3"]),
        (feature(polygon([])), ["not closed: it has no point"]),
        (feature(polygon()), ["its Polygon has no outline"]),
        (feature(polygon([[0, 0], [1, float("nan")], [2, 2], [0, 0]])), ["point 2 is (1, nan)"]),
        (feature(polygon([[0, 0], [1, 0], [math.inf, 2], [0, 0]])), ["point 3 is (inf, 2)"]),
        (feature(polygon([[0, 0], [1, "x"], [2, 2], [0, 0]])), ["point 2 is [1, 'x'], not a pair"]),
        (feature(polygon([[0, 0, 1], [1, 0, 1], [2, 2, 1], [0, 0, 1]])),
         ["point 1 is (0, 0, 1)", "'bottom' and 'top'"]),
        (feature(polygon(SQUARE, [[8, 8], [9, 8], [9, 9], [8, 8]])), ["has a hole that is not"]),
        (feature({"type": "LineString", "coordinates": [[0, 0], [1, 0], [1, 5]]}),
         ["an open line from (0, 0) to (1, 5) bounds no area", "thickness"]),
        (feature({"type": "LineString", "coordinates": [[1, 1], [1, 1]]}), ["no length"]),
        (feature({"type": "Point", "coordinates": [3, 4]}), ["a Point at (3, 4)", "a radius"]),
        (feature({"type": "Point", "coordinates": [3, 4]}, radius=-1), ["radius = -1 at (3, 4)"]),
        (feature({"type": "Point", "coordinates": [3, 4]}, radius="1"), ["radius = '1'"]),
        (feature({"type": "Poligon"}), ["unknown geometry 'Poligon': did you mean 'Polygon'?"]),
        (feature({"type": "MultiPoint", "coordinates": []}), ["MultiPoint has no coordinates"]),
        (feature(None), ["feature 1: it has no geometry"]),
        (feature(polygon(SQUARE), top=1, bottom=2), ["top = 1 is not above bottom = 2"]),
        ({"type": "Fature"}, ["feature 1: its type is 'Fature', not Feature"]),
        ({"type": "Feature", "properties": 3}, ["'properties' is not an object"]),
    ],
)  # fmt: skip
def test_a_geojson_feature_that_cannot_be_used_is_named(geojson, made, words):
    line = refused(geojson(made))
    for word in words:
        assert word in line


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("{", "is not JSON"),
        ("[]", "is not GeoJSON"),
        ('{"type": "Topology"}', "unknown GeoJSON type 'Topology'"),
        ('{"type": "FeatureCollection"}', "'features' is not a list"),
        ('{"type": "FeatureCollection", "features": []}', "there is nothing on its layers"),
        ('{"type": "FeatureCollection", "features": [], "crs": {"properties": {"name": '
         '"urn:ogc:def:crs:OGC:1.3:CRS84"}}}', "there is nothing on its layers"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_geojson_is_named(tmp_path, text, word):
    path = tmp_path / "plan.geojson"
    path.write_text(text)
    assert word in refused(path)


def test_wkt_has_a_geometry_a_line(wkt):
    path = wkt(
        "# the hall",
        "",
        "kiosk: POLYGON ((0 0, 4 0, 4 4, 0 4, 0 0), (1 1, 1 2, 2 2, 1 1))",
        "MULTIPOLYGON (((6 0, 7 0, 7 1, 6 0)), ((8 0, 9 0, 9 1, 8 0)))",
        "GEOMETRYCOLLECTION (POLYGON ((0 8, 1 8, 1 9, 0 8)))",
    )
    made = read_geometry(path, SOLID).obstacles
    assert [one.name for one in made] == ["kiosk", "obstacle", "obstacle", "obstacle"]
    assert [one.footprint().area for one in made] == [15.5, 0.5, 0.5, 0.5]


def test_lines_are_walls_with_a_thickness(wkt):
    path = wkt("LINESTRING (0 0, 10 0)", "bend: LINESTRING (0 5, 10 5, 10 9)",
               "loop: LINESTRING (20 0, 24 0, 24 4, 20 4, 20 0)")  # fmt: skip
    straight, bend, loop = read_geometry(path, SOLID, thickness=0.5).obstacles
    assert straight == Wall(name="obstacle", start=(0, 0), end=(10, 0), thickness=0.5)
    assert bend.footprint().area == pytest.approx(0.5 * 14.0)
    assert loop.footprint().area == pytest.approx(4.5**2 - 3.5**2)
    assert len(loop.holes) == 1


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a: POLYGON ((0 0, 2 2, 2 0, 0 2, 0 0))", ["line 2 'a'", "crosses itself at (1, 1)"]),
        ("POLYGON ((0 0, 1 0, 1 2))", ["not closed: it begins at (0, 0) and ends at (1, 2)"]),
        ("POLYGON ((0 0, 1 1, 2 2, 0 0))", ["line 2", "has no area"]),
        ("POLYGON ((0 0, nan 1, 2 2, 0 0))", ["point 2 is (nan, 1)"]),
        ("POLYGON EMPTY", ["POLYGON EMPTY has nothing in it"]),
        ("b: LINESTRING (0 0, 1 1)", ["line 2 'b'", "from (0, 0) to (1, 1)", "thickness"]),
        ("b: POINT (3 4)", ["line 2 'b'", "a POINT at (3, 4) bounds no area"]),
        ("POLYGON Z ((0 0 1, 1 0 1, 1 1 1, 0 0 1))", ["its points have heights"]),
        ("POLYGN ((0 0, 1 0, 1 1, 0 0))", ["is not WKT", "POLYGN"]),
        ("MULTIPOLYGON (((0 0, 4 0, 4 4, 0 4, 0 0)), ((1 1, 6 1, 6 2, 1 2, 1 1)))",
         ["line 2", "crosses itself at"]),
        ("CIRCULARSTRING (0 0, 1 1, 2 0)", ["is not WKT"]),
        ("name:", ["line 2"]),
    ],
)  # fmt: skip
def test_a_line_of_wkt_that_cannot_be_used_is_named(wkt, text, words):
    line = refused(wkt("# first", text))
    for word in words:
        assert word in line


COORDINATES = st.tuples(st.floats(-50, 50), st.floats(-50, 50))


@given(points=st.lists(COORDINATES, min_size=3, max_size=7))
@settings(max_examples=150, deadline=None,
          suppress_health_check=[HealthCheck.function_scoped_fixture])  # fmt: skip
def test_a_polygon_is_read_to_fourteen_digits_or_refused(geojson, wkt, points):
    largest = max(abs(x) for point in points for x in point)
    digits = 14 - math.ceil(math.log10(largest)) if largest > 0.0 else 14
    points = [(round(x, digits), round(y, digits)) for x, y in points]
    ring = [*points, points[0]]
    drawn = shapely.Polygon(ring)
    # Points so near each other that rounding leaves no area between them count as one.
    solid = drawn.is_valid and min(drawn.area, shapely.MultiPoint(ring).convex_hull.area) > 0.0
    text = "POLYGON ((" + ", ".join(f"{x!r} {y!r}" for x, y in ring) + "))"
    for path in (geojson(feature(polygon([list(p) for p in ring]))), wkt(text)):
        if solid:
            (made,) = read_geometry(path, SOLID, unit="m").obstacles
            distinct = [p for k, p in enumerate(points) if k == 0 or p != points[k - 1]]
            assert made.points == tuple(distinct[: -1 if distinct[-1] == distinct[0] else None])
        else:
            refused(path, unit="m")


@pytest.mark.parametrize("bulge", [0.1, 1.0, -1.0, -0.4, 3.0])
def test_points_of_an_arc_lie_on_it(bulge):
    start, end = np.array((1.0, 2.0)), np.array((4.0, 3.0))
    made = np.array(arc(tuple(start), tuple(end), bulge))
    chord = np.linalg.norm(end - start)
    radius = chord * (1.0 + bulge * bulge) / (4.0 * abs(bulge))
    right = np.array([end[1] - start[1], start[0] - end[0]]) / chord
    top = 0.5 * (start + end) + right * 0.5 * bulge * chord
    centre = top - right * math.copysign(radius, bulge)
    assert np.allclose(np.linalg.norm(made - centre, axis=1), radius)
    assert np.allclose(np.linalg.norm(made - top, axis=1).min(), 0.0, atol=0.05 * radius)
    steps = np.linalg.norm(np.diff([start, *made, end], axis=0), axis=1)
    assert np.allclose(steps, steps[0])
    assert steps[0] <= 2.0 * radius * math.sin(math.pi / 128) + 1e-12


def test_walkable_makes_the_rest_of_its_bounds_solid(geojson):
    ell = [[0, 0], [10, 0], [10, 4], [4, 4], [4, 8], [0, 8], [0, 0]]
    tree = feature({"type": "Point", "coordinates": [2, 2]}, radius=0.5, kind="tree")
    made = world_around(read_geometry(geojson(feature(polygon(ell), kind="walkable"), tree)))
    assert (made.low, made.size, made.edges) == ((0.0, 0.0), (10.0, 8.0), ("solid", "solid"))
    assert [one.name for one in made.obstacles] == ["tree", "outside 1"]
    assert made.obstacles[1].footprint().equals(shapely.box(4, 4, 10, 8))


def test_without_walkable_there_is_room_around(geojson):
    shifted = [[x + 100.0, y - 50.0] for x, y in SQUARE]
    taken = read_geometry(geojson(feature(polygon(shifted))), SOLID)
    made = world_around(taken, "open", margin=3.0)
    assert (made.low, made.size, made.edges) == ((97.0, -53.0), (10.0, 10.0), ("open", "open"))
    assert world_around(taken).size == (4.8, 4.8)
    moved = world_around(taken, ("wrap", "solid"), margin=3.0, to_origin=True)
    assert moved.low == (0.0, 0.0)
    assert moved.obstacles[0].footprint().bounds == (3.0, 3.0, 7.0, 7.0)


def test_what_no_box_can_be_made_of_is_refused(geojson):
    square = geojson(feature(polygon([[x + 1.0, y] for x, y in SQUARE]), kind="walkable"))
    taken = read_geometry(square)
    with pytest.raises(InputError, match=r"along x it begins at 1 \(plan.geojson\).*--to-origin"):
        world_around(taken, ("wrap", "solid"))
    with pytest.raises(InputError, match="margin = 2 m cannot be given with a walkable area"):
        world_around(taken, margin=2.0)
    solid = read_geometry(geojson(feature(polygon(SQUARE))), SOLID)
    with pytest.raises(InputError, match="margin = -1 m is not a length >= 0"):
        world_around(solid, margin=-1.0)
    with pytest.raises(InputError, match=r"unknown edge .sold.: did you mean .solid.\?"):
        world_around(solid, "sold")
    with pytest.raises(InputError, match="3 axes"):
        world_around(solid, ("solid", "solid", "open"))


def test_what_is_asked_is_checked(geojson, tmp_path):
    path = geojson(feature(polygon(SQUARE)))
    for scale in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(InputError, match=r"scale = .* metres per unit"):
            read_geometry(path, scale=scale)
    with pytest.raises(InputError, match="thickness = 0 m is not a length > 0"):
        read_geometry(path, thickness=0.0)
    assert "is not a drawing that is read: .geojson, .json, .wkt, .dxf, .svg, .scenario" in refused(
        tmp_path / "a.dwg"
    )
    for ending in ("geojson", "wkt", "dxf"):
        assert "cannot be read: No such file" in refused(tmp_path / f"no.{ending}")
    wall = geojson(
        feature({"type": "LineString", "coordinates": [[0, 0], [1, 0]]}, kind="walkable")
    )
    assert "a walkable area is a polygon" in refused(wall)
