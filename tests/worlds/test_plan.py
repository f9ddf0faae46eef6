"""A plan means what it says: a lone polygon is ground, and every layer has a role."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from worlds.input_error import InputError
from worlds.layout import world_from_layout
from worlds.queries.clearance import clearance
from worlds.readers import open_drawing, read_geometry, world_around
from worlds.readers.roles import assign_roles, role_from_name

OFFICE = (
    "GEOMETRYCOLLECTION (POLYGON ((0 4, 2.75 4, 3.75 3, 4.75 4, 10 4, 10 0, 7 0, 6 1, 5 0, 0 0, "
    "0 4), (8 2, 8 3, 9 3, 9 2, 8 2)))"
)
TWO = "POLYGON ((0 0, 4 0, 4 4, 0 4, 0 0))\nPOLYGON ((6 0, 9 0, 9 4, 6 4, 6 0))"
CONVERTED = (
    "GEOMETRYCOLLECTION (GEOMETRYCOLLECTION (POLYGON ((0 0, 20 0, 20 9, 0 9, 0 0), (8 2, 8 4, 9 4,"
    " 9 2, 8 2))), GEOMETRYCOLLECTION (POLYGON ((18 4, 20 4, 20 6, 18 6, 18 4))),"
    " GEOMETRYCOLLECTION (POLYGON ((1 1, 4 1, 4 8, 1 8, 1 1))),"
    " GEOMETRYCOLLECTION EMPTY, GEOMETRYCOLLECTION (LINESTRING (3 5, 10 7, 19 5)))"
)


@pytest.fixture
def plan(tmp_path):
    def write(text):
        path = tmp_path / "plan.wkt"
        path.write_text(text)
        return path

    return write


def free(world):
    box = shapely.box(*world.low, *(np.array(world.low) + world.size))
    return box.difference(shapely.union_all([one.footprint() for one in world.obstacles]))


def refused(path, roles=None, **options):
    with pytest.raises(InputError) as refusal:
        read_geometry(path, roles, **options)
    return str(refusal.value)


@pytest.mark.parametrize(
    "text",
    [
        OFFICE,
        OFFICE.removeprefix("GEOMETRYCOLLECTION (")[:-1],
        "GEOMETRYCOLLECTION (GEOMETRYCOLLECTION (MULTIPOLYGON (((0 0, 5 0, 0 4, 0 0)))))",
        "# a hall\n\nPOLYGON ((0 0, 8 0,\n 8 4, 0 4,\n 0 0),\n (1 1, 2 1, 2 2, 1 1))",
    ],
)
def test_a_lone_polygon_is_ground_and_its_holes_are_solid(plan, text):
    drawn = shapely.from_wkt(" ".join(text.splitlines()[text.startswith("#") :]))
    world = world_around(read_geometry(plan(text)))
    assert (*world.low, *world.size) == tuple(drawn.bounds)
    ground = shapely.union_all(list(shapely.get_parts(drawn)))
    assert free(world).symmetric_difference(ground).area == pytest.approx(0.0, abs=1e-12)
    holes = [one.name for one in world.obstacles if one.name.startswith("hole")]
    assert len(holes) == (1 if "(8 2" in text or "(1 1" in text else 0)


def test_several_polygons_may_be_rooms_or_blocks_and_are_asked_about(plan):
    path = plan(TWO)
    line = refused(path)
    assert "no clear role (2 polygons may be rooms or blocks)" in line
    assert "give --walkable unnamed or --solid unnamed" in line
    rooms = world_around(read_geometry(path, {"walkable": ["unnamed"]}))
    assert free(rooms).area == pytest.approx(16.0 + 12.0)
    blocks = world_around(read_geometry(path, {"obstacle": ["*"]}), margin=1.0)
    assert free(blocks).area == pytest.approx(11.0 * 6.0 - 28.0)
    assert "no clear role" in refused(plan(f"MULTIPOLYGON ({TWO_IN_ONE})"))


TWO_IN_ONE = "((0 0, 4 0, 4 4, 0 0)), ((6 0, 9 0, 9 4, 6 0))"


def test_beside_a_walkable_area_or_solids_the_unnamed_has_a_role(plan):
    beside = read_geometry(plan("walkable: POLYGON ((0 0, 9 0, 9 9, 0 0))\n" + TWO.split("\n")[0]))
    assert [row.role for row in beside.layers] == ["walkable", "obstacle"]
    around = "POLYGON ((0 0, 9 0, 9 9, 0 9, 0 0))\npillar: POLYGON ((1 1, 2 1, 2 2, 1 1))"
    assert free(world_around(read_geometry(plan(around)))).area == pytest.approx(81.0 - 0.5)
    apart = "POLYGON ((0 0, 3 0, 3 3, 0 0))\npillar: POLYGON ((7 1, 9 1, 9 2, 7 1))"
    assert "no clear role" in refused(plan(apart))


def test_an_island_in_a_walkable_area_is_not_swallowed(plan):
    inner = "POLYGON ((1 1, 2 1, 2 2, 1 1))"
    line = refused(plan("POLYGON ((0 0, 9 0, 9 9, 0 0))\n" + inner), {"walkable": ["*"]})
    assert "line 2: its outline at (1, 1) lies inside another walkable one" in line


def test_what_jupedsim_converts_has_ground_exit_start_and_path(plan):
    world = world_around(read_geometry(plan(CONVERTED)))
    assert free(world).area == pytest.approx(180.0 - 2.0)
    assert (world.mission.start.low, world.mission.start.high) == ((1.0, 1.0), (4.0, 8.0))
    assert world.mission.goal.route == ((19.0, 5.0),)
    assert world.mission.path.waypoints == ((3.0, 5.0), (10.0, 7.0), (19.0, 5.0))
    moved = world_around(read_geometry(plan(CONVERTED.replace("20 9", "21 9"))), to_origin=True)
    assert moved.mission == world.mission
    layout = world.to_layout()
    assert world_from_layout(layout, "plan") == world


def test_a_named_layer_without_a_clear_role_is_never_built_in(plan):
    path = plan("walkable: POLYGON ((0 0, 9 0, 9 9, 0 0))\nstage: POLYGON ((4 1, 5 1, 5 2, 4 1))")
    line = refused(path)
    assert "layer 'stage': no clear role (its name does not say)" in line
    assert "--ignore stage" in line
    assert read_geometry(path, {"ignore": ["stage"]}).obstacles == ()
    assert [one.name for one in read_geometry(path, {"obstacle": ["st*"]}).obstacles] == ["stage"]


@pytest.mark.parametrize(
    ("name", "role"),
    [
        ("jps-walkablearea", "walkable"), ("WalkableArea-2", "walkable"), ("jps-exits", "goal"),
        ("Exit_north", "goal"), ("jps-distributions", "start"), ("startzone", "start"),
        ("jps-obstacles", "obstacle"), ("A-WALL", "wall"), ("Walls", "wall"),
        ("pillars 2", "obstacle"), ("jps-journeys", "path"), ("jps-waypoints", "path"),
        ("jps-parameters", "ignore"), ("Defpoints", "ignore"), ("A-ANNO-DIMS", "ignore"),
        ("0", None), ("stage", None), ("not walkable", None), ("wall-start", None),
        ("wallpaper", None), ("pathology", None), ("", None),
    ],
)  # fmt: skip
def test_a_role_is_guessed_from_words(name, role):
    assert role_from_name(name)[0] == role


def test_the_rest_is_what_has_no_role_otherwise(plan):
    path = plan("walkable: POLYGON ((0 0, 9 0, 9 9, 0 0))\na: POLYGON ((4 1, 5 1, 5 2, 4 1))\n"
                "exit: POLYGON ((8 1, 9 1, 9 2, 8 1))")  # fmt: skip
    rows = assign_roles(open_drawing(path), {"ignore": ["*"]})
    assert [(row.layer, row.role) for row in rows] == [
        ("walkable", "walkable"), ("a", "ignore"), ("exit", "goal")
    ]  # fmt: skip
    assert "the rest has one role" in refused(path, {"ignore": ["*"], "obstacle": ["*"]})


@pytest.mark.parametrize(
    ("goal", "told"),
    [
        ("exit: POLYGON ((8 1, 9 1, 9 2, 8 2, 8 1))", ((8.5, 1.5),)),
        ("exit: LINESTRING (8 1, 8 3)", ((8.0, 2.0),)),
        ("exit: POINT (7.5 2)", ((7.5, 2.0),)),
        ("exit: POINT (1 8)", "all of it is solid or outside"),
        ("exit: POINT (8 1)\nexit: POINT (7 1)", "it holds 2 goals, and a mission has one"),
        ("start: POLYGON ((5 1, 8 1, 8 4, 5 1))", "not one box along the axes"),
        ("start: LINESTRING (5 1, 8 1)", "it holds no area"),
        ("path: LINESTRING (3 1, 8 1)\npath: LINESTRING (3 1, 8 1)", "a mission is one line"),
        ("path: LINESTRING (3 1, 1 8)", "(1, 8) is solid or outside"),
    ],
)
def test_a_mission_is_made_of_what_can_be_one_and_the_rest_is_named(plan, goal, told):
    from worlds.readers import world_and_notes

    text = "walkable: POLYGON ((0 0, 9 0, 9 9, 0 0))\n" + goal
    world, (note,) = world_and_notes(read_geometry(plan(text)))
    if isinstance(told, tuple):
        assert world.mission.goal.route == told
        assert "is the goal of the mission" in note
    else:
        assert world.mission is None
        assert told in note
        assert "is not used" in note


def test_a_start_is_used_where_only_its_box_is_free(plan):
    room = "walkable: POLYGON ((0 0, 9 0, 9 9, 0 0))\nstart: POLYGON ((0 0, 4 0, 4 4, 0 0))"
    assert world_around(read_geometry(plan(room))).mission.start.high == (4.0, 4.0)


@pytest.mark.parametrize(
    ("side", "words"),
    [(676.4, ["676.4 m wide (a unit is 1 m unless said)", "--unit cm (6.764 m)"]),
     (0.02, ["0.02 m wide", "--unit m if that is so"])],
)  # fmt: skip
def test_a_plan_of_doubtful_size_is_questioned(plan, side, words):
    path = plan(f"POLYGON ((0 0, {side} 0, {side} {side / 2}, 0 0))")
    line = refused(path)
    for word in words:
        assert word in line
    assert world_around(read_geometry(path, unit="m")).size == (side, side / 2)
    assert world_around(read_geometry(path, scale=1.0)).size == (side, side / 2)


def test_sizes_have_no_rounding_errors(plan):
    text = "POLYGON ((-9.399999999999977 0, 10.6 0.1, 10.6 10.000000000000002, -9.4 0.3, " \
           "-9.399999999999977 0))"  # fmt: skip
    world = world_around(read_geometry(plan(text)))
    assert (world.low, world.size) == ((-9.4, 0.0), (20.0, 10.0))
    mm = read_geometry(plan("POLYGON ((0.1 0, 20000.3 0, 20000.3 9000.7, 0.1 0))"), unit="mm")
    assert world_around(mm).size == (20.0002, 9.0007)
    assert "e-" not in world_around(mm).to_toml()


def test_all_problems_of_a_file_are_told_at_once(plan):
    bow = "POLYGON ((0 0, 2 2, 2 0, 0 2, 0 0))"
    text = f"wall: {bow}\npillar: POINT (3 4)\nstage: {bow}\nwall: POLYGON ((0 0, 1 0, 1 2))"
    with pytest.raises(InputError) as refusal:
        read_geometry(plan(text))
    told = refusal.value.lines
    assert len(told) == 4
    for line, word in zip(told, ("'stage'", "crosses itself", "not closed", "(3, 4)"), strict=True):
        assert word in line


@st.composite
def rooms(draw):
    """A star-shaped polygon around (0, 0), with up to three holes in it."""
    count = draw(st.integers(3, 12))
    radius = draw(st.lists(st.floats(6.0, 20.0), min_size=count, max_size=count))
    turn = draw(st.floats(0.0, 6.0))
    angles = turn + 2.0 * math.pi * np.arange(count) / count
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    outline = shapely.Polygon(np.array(radius)[:, None] * directions)
    place = st.tuples(st.floats(-8.0, 8.0), st.floats(-8.0, 8.0))
    for x, y in draw(st.lists(place, max_size=3)):
        hole = shapely.box(x, y, x + draw(st.floats(0.1, 3.0)), y + draw(st.floats(0.1, 3.0)))
        taken = outline.difference(hole)
        inside = outline.exterior.distance(hole) > 0.01 and outline.contains(hole.centroid)
        outline = taken if inside and taken.geom_type == "Polygon" else outline
    return outline


@given(room=rooms(), seed=st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_a_place_is_free_where_the_polygon_holds_it(tmp_path_factory, room, seed):
    path = tmp_path_factory.mktemp("room") / "room.wkt"
    path.write_text(shapely.to_wkt(room, rounding_precision=-1))
    world = world_around(read_geometry(path))
    assert free(world).area == pytest.approx(room.area, rel=1e-9)
    place = np.random.default_rng(seed).uniform(-22.0, 22.0, (400, 2))
    clear = clearance(world, place)
    held = shapely.contains_xy(room, *place.T)
    far = shapely.distance(room.boundary, shapely.points(place)) > 1e-6
    assert (held == (clear > 0.0))[far].all()
    assert 0 < held.sum() < len(place)
