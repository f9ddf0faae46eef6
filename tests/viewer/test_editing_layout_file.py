"""Layout files from browsers: a world, or one line of why not, and never half of one."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.viewer.editing.layout_file import (
    LARGEST,
    MOST_CORNERS,
    layout_from_browser,
    layout_of,
    plain_name,
)
from app.viewer.lab.panels.plan_questions import add_answer
from worlds.input_error import InputError
from worlds.mission import Goal, Mission
from worlds.obstacles import Disc
from worlds.readers.drawing_contents import PlanQuestion
from worlds.world import World

WORLD = World(
    "mine",
    (20.0, 10.0),
    ("solid", "wrap"),
    low=(-3.0, 0.0),
    obstacles=(Disc(centre=(5.0, 5.0), radius=1.0),),
    mission=Mission(goal=Goal(route=((9.0, 9.0),))),
)
SQUARE = {"type": "Polygon", "coordinates": [[[1, 1], [3, 1], [3, 3], [1, 3], [1, 1]]]}


def test_a_saved_layout_comes_back_exactly():
    assert layout_of("mine.toml", WORLD.to_toml().encode()) == WORLD


def test_a_layout_with_the_name_of_a_built_in_one_gets_another():
    assert layout_of("wrap.toml", WORLD.to_toml().encode()).name == "wrap-file"


def test_drawings_are_read_with_solid_edges_around_them():
    feature = {"type": "Feature", "properties": {}, "geometry": SQUARE}
    world = layout_of("rooms.GeoJSON", json.dumps(feature).encode())
    assert (world.name, world.edges, len(world.obstacles)) == ("rooms", ("solid", "solid"), 0)
    assert (world.low, world.size) == ((1.0, 1.0), (2.0, 2.0))
    text = b"# a room\nPOLYGON ((1 1, 3 1, 3 3, 1 3, 1 1))\nwall: POLYGON ((1 1, 2 1, 1 2, 1 1))\n"
    room = layout_of("rooms.wkt", text)
    assert (room.low, room.size) == ((1.0, 1.0), (2.0, 2.0))
    assert room.obstacles[0].footprint().area == pytest.approx(0.5)


HOUSE = b"A-WALL: POLYGON ((0 0, 24 0, 24 7, 0 7, 0 0))\nA-WALL: POLYGON ((2 2, 3 2, 3 3, 2 2))\n"


def test_what_a_drawing_leaves_open_is_asked_and_answered():
    with pytest.raises(PlanQuestion) as question:
        layout_from_browser("../house.wkt", HOUSE)
    assert str(question.value).startswith("house.wkt, line 1 'A-WALL': it holds all else")
    solid, walls = question.value.choices
    block = layout_from_browser("house.wkt", HOUSE, add_answer({}, solid, None))
    assert block.obstacles[0].footprint().area == 168.0
    room = layout_from_browser("house.wkt", HOUSE, add_answer({}, walls, 0.2))
    assert room.obstacles[0].footprint().area == pytest.approx(24.2 * 7.2 - 23.8 * 6.8)


def test_maps_come_as_one_file():
    text = b"type octile\nheight 2\nwidth 3\nmap\n.@.\n...\n"
    world = layout_from_browser("arena.map", text)
    assert (world.size, len(world.obstacles)) == ((3.0, 2.0), 1)
    with pytest.raises(InputError, match=r"lab.yaml is one half of a map of ROS: open a ZIP file"):
        layout_of("lab.yaml", b"image: lab.pgm\n")


def discs(count: int) -> bytes:
    one = '[[obstacle]]\nshape = "disc"\ncentre = [5.0, 5.0]\nradius = 1.0\n'
    return ("size = 10.0\n" + count * one).encode()


def polygon(points: str, first: str = "size = 10.0\n") -> bytes:
    return f'{first}[[obstacle]]\nshape = "polygon"\nname = "hall"\npoints = {points}\n'.encode()


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.exe", b"", "unknown kind of layout file '.exe'"),
        ("toml", b"", "unknown kind of layout file 'toml'"),
        ("a.toml", b" " * (LARGEST + 1), "a layout file has 5000000 at most"),
        ("a.toml", b"", "a.toml has no size"),
        ("a.toml", b"size = ", "a.toml is not TOML"),
        ("a.toml", b"\xff\xfe", "a.toml is not TOML"),
        ("a.toml", b"a = " + 100_000 * b"[", "a.toml"),
        ("a.toml", b"size = 10.0\ncolour = 1\n", "unknown key 'colour'"),
        ("a.toml", b"size = -1.0\n", "size"),
        ("a.toml", b"size = 10.0\nobstacle = 3\n", "obstacle"),
        ("a.toml", discs(501), "501 obstacles: the laboratory takes 500 at most"),
        ("a.toml", polygon("[[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]]"), "'hall' crosses"),
        ("a.toml", polygon("[[0.0, 0.0], [4.0, 4.0]]"), "'hall'"),
        ("a.toml", polygon("[[0.0, 0.0], [1e7, 0.0], [0.0, 1e7]]"), "'hall' is too far away"),
        (
            "a.toml",
            polygon("[[0, 0], [4, 0], [0, 4.0]]", "size = 10.0\nboundary_spacing = 1e-9\n"),
            "boundary_spacing = 1e-09 makes",
        ),
        ("a.toml", WORLD.to_toml().replace("[[9.0, 9.0]]", "[[5.0, 5.0]]").encode(), "inside"),
        ("a.geojson", b"{", "a.geojson"),
        ("a.json", b"[" * 200_000, "a.json"),
        ("a.wkt", b"POLYGON ((1 1, 2", "a.wkt"),
        ("a.dxf", b"0\nSECTION\n", "a.dxf"),
        ("a.svg", b"<svg", "a.svg is not SVG"),
        ("a.map", b"type", "a.map is not a map of MovingAI"),
        ("a.scenario", b"{}", "a.scenario is not a scenario of Vadere"),
        ("a.zip", b"PK", "a.zip is not a ZIP file"),
        ("../../etc/a.geojson", b"null", "a.geojson"),
    ],
)  # fmt: skip
def test_what_cannot_be_a_world_is_refused_in_one_line_without_a_path(name, content, words):
    with pytest.raises(InputError) as refused:
        layout_of(name, content)
    told = str(refused.value)
    assert words in told
    assert "\n" not in told
    assert "/" not in told
    assert len(told) < 500


def test_too_many_corners_are_refused():
    angles = np.linspace(0.0, 2.0 * np.pi, MOST_CORNERS + 10)[:-1]
    ring = np.column_stack([np.cos(angles), np.sin(angles)]).tolist()
    ring.append(ring[0])
    drawing = {"type": "Polygon", "coordinates": [ring]}
    with pytest.raises(InputError, match="more than 50000 corners"):
        layout_of("a.geojson", json.dumps(drawing).encode())


@settings(max_examples=60, deadline=None)
@given(
    ending=st.sampled_from(
        [".toml", ".geojson", ".wkt", ".dxf", ".svg", ".map", ".scenario", ".zip"]
    ),
    content=st.one_of(st.binary(max_size=60), st.text(max_size=60).map(str.encode)),
)
def test_nonsense_is_refused_and_nothing_else_happens(ending, content):
    with pytest.raises(InputError) as refused:
        layout_of("nonsense" + ending, content)
    assert len(str(refused.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("name", "plain"),
    [
        ("C:\\maps\\hall.dxf", "hall.dxf"),
        ("/etc/passwd", "passwd"),
        ("..", "layout"),
        ("a\nb<script>.toml", "a_b_script_.toml"),
        ("x" * 300 + ".toml", "x" * 75 + ".toml"),
    ],
)
def test_a_files_name_is_only_a_name(name, plain):
    assert plain_name(name) == plain
