"""Maps of other programs: each held against a reading of its file that is written apart.

The readings here go letter by letter, or pixel by pixel, as the formats' documents say, and ask of
the middle of every cell whether it is solid.
"""

import json
import math
import random
import warnings
import zipfile

import numpy as np
import pytest
import shapely
from PIL import Image

from worlds.input_error import InputError
from worlds.readers import read_geometry, world_and_notes
from worlds.readers.drawing_contents import LARGEST

YAML = """image: {image}
resolution: 0.05
origin: [-1.5, 2.0, {yaw}]
negate: {negate}
occupied_thresh: 0.65
free_thresh: 0.196
mode: {mode}
"""


def refused(path, words):
    with pytest.raises(InputError) as refusal:
        read_geometry(path)
    line = str(refusal.value)
    assert words in line
    assert "\n" not in line
    assert path.name in line


def solid(geometry, layer, place):
    """Whether a place is inside of what a layer has made."""
    return any(
        one.footprint().contains(shapely.Point(place))
        for one in geometry.obstacles
        if one.name == layer
    )


def meaning(colours, alpha, mode, negate):
    """What a pixel says, as the node of Nav2 has it: "occupied", "free" or "unknown"."""
    held = [*colours, alpha] if mode == "trinary" and alpha is not None else colours
    shade = sum(held) / len(held) / 255.0
    if mode == "raw":
        percent = round(shade * 255.0)
        if percent > 100:
            return "unknown"
        occ = percent / 100.0
    else:
        occ = shade if negate else 1.0 - shade
    if mode == "scale" and alpha is not None and alpha < 255:
        return "unknown"
    return "occupied" if occ > 0.65 else "free" if occ < 0.196 else "unknown"


@pytest.mark.parametrize("negate", [0, 1])
@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
@pytest.mark.parametrize("kind", ["pgm", "grey.png", "rgb.png", "rgba.png", "palette.png"])
def test_a_map_of_ros_is_what_its_pixels_say(tmp_path, kind, mode, negate):
    chance = random.Random(kind + mode + str(negate))
    width, height = 7, 5
    values = [0, 12, 60, 89, 100, 101, 205, 206, 230, 254, 255]
    pixels = [[chance.choice(values) for _ in range(width)] for _ in range(height)]
    alphas = [[chance.choice([0, 128, 255, 255]) for _ in range(width)] for _ in range(height)]
    name = f"map.{kind}"
    if kind == "pgm":
        flat = bytes(value for row in pixels for value in row)
        (tmp_path / name).write_bytes(b"P5\n# CREATOR: map_saver\n7 5\n255\n" + flat)
    else:
        image = Image.fromarray(np.array(pixels, np.uint8))
        if kind == "rgba.png":
            image = image.convert("RGBA")
            image.putalpha(Image.fromarray(np.array(alphas, np.uint8)))
        elif kind != "grey.png":
            image = image.convert("RGB")
            image = image.quantize(64) if kind == "palette.png" else image
        image.save(tmp_path / name)
    path = tmp_path / "map.yaml"
    path.write_text(YAML.format(image=name, yaw=0.3, negate=negate, mode=mode))
    seen = Image.open(tmp_path / name).convert("RGB")
    told = [
        [
            meaning(seen.getpixel((x, y)), alphas[y][x] if kind == "rgba.png" else None, mode,
                    negate)
            for x in range(width)
        ]
        for y in range(height)
    ]  # fmt: skip
    if all(cell == "unknown" for row in told for cell in row):
        refused(path, "is unknown")
        return
    taken = read_geometry(path)
    for y, row in enumerate(told):
        for x, cell in enumerate(row):
            u, v = 0.05 * (x + 0.5), 0.05 * (height - y - 0.5)
            place = (-1.5 + u * math.cos(0.3) - v * math.sin(0.3),
                     2.0 + u * math.sin(0.3) + v * math.cos(0.3))  # fmt: skip
            for layer in ("occupied", "unknown"):
                assert solid(taken, layer, place) == (cell == layer), (x, y, cell)
            assert cell == "unknown" or taken.walkable.contains(shapely.Point(place))
    for layer in ("occupied", "unknown"):
        count = sum(row.count(layer) for row in told)
        area = sum(one.footprint().area for one in taken.obstacles if one.name == layer)
        assert area == pytest.approx(count * 0.05**2)


def small_map(folder, **changes):
    """A map of 4 x 3 cells with one wall, as a YAML file."""
    pixels = np.full((3, 4), 254, np.uint8)
    pixels[:, 2] = 0
    Image.fromarray(pixels).save(folder / "m.pgm")
    values = {"image": "m.pgm", "resolution": 1.0, "origin": "[0, 0, 0]", **changes}
    path = folder / "m.yaml"
    path.write_text("".join(f"{key}: {value}\n" for key, value in values.items() if value != ""))
    return path


def test_both_files_may_come_in_one(tmp_path):
    path = small_map(tmp_path)
    packed = tmp_path / "m.zip"
    with zipfile.ZipFile(packed, "w") as archive:
        archive.write(path, "maps/m.yaml")
        archive.write(tmp_path / "m.pgm", "maps/m.pgm")
    plain, zipped = read_geometry(path), read_geometry(packed)
    assert plain.obstacles == zipped.obstacles
    assert plain.obstacles[0].footprint().equals(shapely.box(2, 0, 3, 3))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"image": ""}, "it has no image"),
        ({"image": "other.pgm"}, "other.pgm' cannot be read: No such file"),
        ({"image": "m.yaml"}, "it is no PGM and no PNG image"),
        ({"image": "[1]"}, "image = [1] is no name of a file"),
        ({"resolution": 0}, "resolution = 0 is not a length > 0"),
        ({"resolution": ".nan"}, "resolution = nan is not a number"),
        ({"resolution": "wide"}, "resolution = 'wide' is not a number"),
        ({"origin": "[0, 0]"}, "origin = [0, 0] is not [x, y, yaw]"),
        ({"origin": "{" * 3000}, "is not YAML"),
        ({"mode": "binary"}, "unknown mode 'binary'"),
        ({"free_thresh": 0.9}, "free_thresh = 0.9 and occupied_thresh = 0.65 are not"),
        ({"note": "x" * 100_001}, "too many for a map"),
    ],
)
def test_a_map_of_ros_that_cannot_be_used_is_told(tmp_path, changes, words):
    refused(small_map(tmp_path, **changes), words)


def test_aliases_that_multiply_are_refused_before_a_message_writes_them(tmp_path):
    more = {f"a{k}": f"&a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, 9)}
    path = small_map(tmp_path, **{"a0": "&a0 [x]"} | more, origin="*a8")
    refused(path, "it has aliases (*name), which no map of ROS needs")


def test_maps_that_are_hostile_are_refused_before_they_take_memory(tmp_path):
    path = small_map(tmp_path)
    for side, words in (
        (90000, "exceeds limit"),
        (12000, "12000 x 12000 cells are too many"),
        (6000, "6000 x 6000 cells are too many, at most 25000000"),
    ):
        (tmp_path / "m.pgm").write_bytes(f"P5\n{side} {side}\n255\n".encode())
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            refused(path, words)
    (tmp_path / "m.pgm").write_bytes(b"P5\n4 3\n255\n")
    refused(path, "cannot be read")
    noise = np.random.default_rng(1).integers(0, 2, (1500, 1500), np.uint8) * 254
    Image.fromarray(noise).save(tmp_path / "m.pgm")
    refused(path, "at most 200000 are read")
    packed = tmp_path / "bomb.zip"
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(path, "m.yaml")
        archive.writestr("m.pgm", bytes(LARGEST + 2))
    refused(packed, f"it has more than {LARGEST} bytes")
    packed.write_bytes(b"PK\x03\x04 nothing")
    refused(packed, "is not a ZIP file")
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("a.txt", "")
    refused(packed, "holds 0 YAML files")


def test_a_map_of_movingai_is_what_its_letters_say(tmp_path):
    chance = random.Random(7)
    rows = ["".join(chance.choice("..G@OTSW") for _ in range(9)) for _ in range(6)]
    path = tmp_path / "arena.map"
    path.write_text("type octile\nheight 6\nwidth 9\nmap\n" + "\n".join(rows) + "\n")
    taken = read_geometry(path)
    assert taken.walkable.equals(shapely.box(0, 0, 9, 6))
    for y, row in enumerate(rows):
        for x, letter in enumerate(row):
            inside = any(
                one.footprint().contains(shapely.Point(x + 0.5, 5.5 - y)) for one in taken.obstacles
            )
            assert inside == (letter in "@OTW"), (x, y, letter)
    area = sum(one.footprint().area for one in taken.obstacles)
    assert area == sum(letter in "@OTW" for row in rows for letter in row)
    world, _ = world_and_notes(taken)
    assert (world.low, world.size) == ((0.0, 0.0), (9.0, 6.0))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "begins with type, height, width and map"),
        ("type octile\nheight 1\nmap\n.\n", "no width"),
        ("type octile\nheight 2\nwidth 1\nmap\n.\n", "height = 2, but there are 1 rows"),
        ("type octile\nheight 1\nwidth 2\nmap\n.\n", "line 5: 1 cells, but width = 2"),
        ("type octile\nheight 1\nwidth 2\nmap\n.x\n", "line 5: cell 2 is 'x'"),
        ("type octile\nheight 1\nwidth 2\nmap\n.\u20ac\n", "letters that are none of"),
        ("type octile\nheight -1\nwidth 2\nmap\n", "height = '-1' is not a number of cells"),
        ("type octile\nheight 99999999\nwidth 99999999\nmap\n", "cells are too many"),
        ("type octile\nheight 0\nwidth 2\nmap\n", "holds nothing"),
    ],
)
def test_a_map_of_movingai_that_cannot_be_used_is_told(tmp_path, text, words):
    path = tmp_path / "arena.map"
    path.write_text(text, encoding="utf-8")
    refused(path, words)


def rectangle(x, y, width, height):
    return {"type": "RECTANGLE", "x": x, "y": y, "width": width, "height": height}


def scenario(folder, **changes):
    """A scenario with what Vadere writes into one."""
    topography = {
        "attributes": {
            "bounds": {"x": 0.0, "y": 0.0, "width": 40.0, "height": 30.0},
            "boundingBoxWidth": 0.5,
            "bounded": True,
            "referenceCoordinateSystem": None,
        },
        "obstacles": [
            {"id": 1, "shape": {"type": "POLYGON", "points": [{"x": 16.0, "y": 13.0},
                                {"x": 22.0, "y": 13.0}, {"x": 22.0, "y": 16.0}]}},
            {"id": -1, "shape": {"type": "CIRCLE", "center": {"x": 5.0, "y": 5.0}, "radius": 1.5}},
            {"id": 3, "shape": rectangle(30.0, 20.0, 2.0, 3.0)},
        ],
        "measurementAreas": [{"id": 4, "shape": rectangle(1.0, 1.0, 2.0, 2.0)}],
        "stairs": [],
        "targets": [{"id": 5, "absorbing": True, "shape": rectangle(37.0, 12.0, 2.0, 6.0)}],
        "sources": [{"id": 6, "shape": rectangle(2.0, 12.0, 2.0, 6.0)}],
        "teleporter": None,
        **changes,
    }  # fmt: skip
    path = folder / "station.scenario"
    path.write_text(json.dumps({"name": "station", "scenario": {"topography": topography}}))
    return path


def test_a_scenario_of_vadere_is_a_world_with_its_mission(tmp_path):
    taken = read_geometry(scenario(tmp_path))
    assert taken.walkable.equals(shapely.box(0.5, 0.5, 39.5, 29.5))
    triangle, disc, block = taken.obstacles
    assert (triangle.name, triangle.footprint().area) == ("obstacle 1", 9.0)
    assert (disc.name, disc.centre, disc.radius) == ("obstacles", (5.0, 5.0), 1.5)
    assert block.footprint().equals(shapely.box(30, 20, 32, 23))
    world, _ = world_and_notes(taken)
    assert (world.mission.start.low, world.mission.start.high) == ((2.0, 12.0), (4.0, 18.0))
    assert world.mission.goal.route == ((38.0, 15.0),)


def test_an_open_topography_has_no_rim(tmp_path):
    bounds = {"x": -5.0, "y": 2.0, "width": 10.0, "height": 8.0}
    attributes = {"bounds": bounds, "boundingBoxWidth": 0.5, "bounded": False}
    taken = read_geometry(scenario(tmp_path, attributes=attributes, obstacles=[]))
    assert taken.walkable.equals(shapely.box(-5, 2, 5, 10))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"attributes": None}, "no topography with attributes"),
        ({"attributes": {}}, "bounds: None is no rectangle"),
        ({"obstacles": [{"id": 1}]}, "obstacles 1: it has no shape"),
        ({"obstacles": [{"id": 1, "shape": {"type": "BLOB"}}]}, "unknown shape 'BLOB'"),
        ({"obstacles": [{"id": 8, "shape": {"type": "POLYGON", "points": [{"x": 1}]}}]},
         "obstacles 1 (id 8): y = None is not a number"),
        ({"obstacles": [{"id": 8, "shape": rectangle(0, 0, -1, 2)}]}, "-1 x 2 at (0, 0)"),
        ({"obstacles": [{"shape": {"type": "CIRCLE", "center": [1, 2], "radius": 1}}]},
         "[1, 2] is no point with x and y"),
        ({"obstacles": [{"id": 2, "shape": rectangle(0, 0, 10**400, 2)}]}, "too many digits"),
    ],
)  # fmt: skip
def test_a_scenario_that_cannot_be_used_is_told(tmp_path, changes, words):
    refused(scenario(tmp_path, **changes), words)


def test_what_is_no_scenario_is_told(tmp_path):
    path = tmp_path / "a.scenario"
    for text, words in (
        ("{", "is not JSON"),
        ("[]", "no topography"),
        ("[" * 100_000, "nested too deep"),
        ('{"scenario": {"topography": 3}}', "no topography"),
    ):
        path.write_text(text)
        refused(path, words)
