"""Drawings made to break a reader: each is refused in one line, within bounds."""

import io
import itertools
import json
import os

import ezdxf
import pytest
from ezdxf import units

from worlds.input_error import InputError
from worlds.readers import read_geometry
from worlds.readers.drawing_contents import LARGEST, MOST_ITEMS

SQUARE = [(0, 0), (4, 0), (4, 4), (0, 4)]


def refused(path, roles=None, **options):
    with pytest.raises(InputError) as refusal:
        read_geometry(path, roles, **options)
    line = str(refusal.value)
    assert "\n" not in line
    assert len(line) < 2500
    return line


def deep(kind, depth):
    return f"{kind} (" * depth + "POLYGON ((0 0, 4 0, 4 4, 0 0))" + ")" * depth


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "there is nothing on its layers"),
        ("# only words\n", "there is nothing on its layers"),
        ("POLYGON EMPTY", "has nothing in it"),
        ("GEOMETRYCOLLECTION (POLYGON EMPTY)", "has nothing in it"),
        (deep("GEOMETRYCOLLECTION", 60), "nested too deep"),
        ("(" * 300_000, "nested too deep"),
        ("POLYGON ((" + "(" * 40, "is not WKT"),
        (" " * 400_000 + "a" + " " * 400_000, "is not WKT"),
        ("a" * 400_000 + ":", "a name, but no geometry"),
        ("POLYGON ((nan nan, nan nan, nan nan, nan nan))", "is not WKT"),
        ("POLYGON ((0 0, nan 0, 4 4, 0 0))", "point 2 is (nan, 0)"),
        ("POLYGON ((0 0, 4 0, 4 inf, 0 0))", "point 3 is (4, inf)"),
        ("POLYGON ((0 0, 1e300 0, 4 4, 0 0))", "which is no place"),
        ("POLYGON ((0 0, 4 4, 4 0, 0 4, 0 0))", "crosses itself at (2, 2)"),
        ("POLYGON ((0 0, 9 0, 9 9, 0 9, 0 0), (1 1, 5 1, 5 5, 1 1), (2 1.5, 6 1.5, 6 4, 2 1.5))",
         "two holes that overlap at (4.25, 2.4375): draw them as one"),
        ("POLYGON ((0 0, 9 0, 9 9, 0 9, 0 0), (20 20, 21 20, 21 21, 20 20))", "is not inside it"),
        ("POINT (1 1)\n" * (MOST_ITEMS + 1), f"more than {MOST_ITEMS} geometries"),
        ("MULTIPOINT (" + ", ".join(["1 1"] * 250_000) + ")", "more than 50000 corners"),
        ("POLYGON ((" + ", ".join(["0 0", "4 0", "4 4"] * 1000) + ", 0 0))", "itself at"),
    ],
)  # fmt: skip
def test_wkt_that_is_hostile_is_refused_in_a_line(tmp_path, text, word):
    path = tmp_path / "plan.wkt"
    path.write_text(text)
    assert word in refused(path)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("[" * 100_000, "nested too deep"),
        ('{"type": "GeometryCollection", "geometries": [' * 200 + "]}" * 200, "nested too deep"),
        (json.dumps({"type": "FeatureCollection", "features": [{}] * (MOST_ITEMS + 1)}),
         f"more than {MOST_ITEMS} features"),
        ('{"type": "Polygon", "coordinates": [[[0, 0], [1e999, 0], [4, 4], [0, 0]]]}',
         "point 2 is (inf, 0)"),
    ],
)  # fmt: skip
def test_geojson_that_is_hostile_is_refused_in_a_line(tmp_path, text, word):
    path = tmp_path / "plan.geojson"
    path.write_text(text)
    assert word in refused(path)


def test_only_files_are_read_and_none_that_is_too_large(tmp_path):
    pipe = tmp_path / "pipe.wkt"
    os.mkfifo(pipe)
    assert "it is not a file" in refused(pipe)
    link = tmp_path / "zero.wkt"
    link.symlink_to("/dev/zero")
    assert "it is not a file" in refused(link)
    for ending in ("wkt", "json", "dxf"):
        large = tmp_path / f"large.{ending}"
        with large.open("wb") as file:
            file.truncate(LARGEST + 1)
        assert f"a drawing has {LARGEST} at most" in refused(large)
    assert "it is not a file" in refused(folder_named(tmp_path / "plan.dxf"))


def folder_named(path):
    path.mkdir()
    return path


@pytest.fixture
def bomb(tmp_path):
    document = ezdxf.new(units=units.M)

    def save():
        path = tmp_path / "bomb.dxf"
        document.saveas(path)
        return path

    document.path = save
    return document


@pytest.mark.parametrize("inner", ["circle", "text", "nothing"])
def test_blocks_that_multiply_are_refused_before_they_do(bomb, inner, monkeypatch):
    blocks = [bomb.blocks.new(f"B{k}") for k in range(9)]
    for outer, within in itertools.pairwise(blocks):
        for _ in range(10):
            outer.add_blockref(within.name, (1, 1))
    if inner == "circle":
        blocks[-1].add_circle((0, 0), 1)
    elif inner == "text":
        blocks[-1].add_text("boom")
    bomb.modelspace().add_blockref("B0", (0, 0))
    path = bomb.path()
    monkeypatch.setattr("worlds.readers.formats.dxf.MOST_ITEMS", 4000)
    line = refused(path, {"obstacle": ["*"]})
    print(f"10^8 entities in {path.stat().st_size} bytes: refused after 4000")
    assert "draws more than 4000 entities" in line


def test_blocks_within_blocks_have_a_depth(bomb):
    for k in range(80):
        bomb.blocks.new(f"B{k}").add_blockref(f"B{k + 1}", (1, 0))
    bomb.blocks.new("B80").add_circle((0, 0), 1)
    bomb.modelspace().add_blockref("B0", (0, 0))
    assert "nested more than 50 deep" in refused(bomb.path(), {"obstacle": ["*"]})


def test_a_block_inserted_a_million_times_at_once_is_refused(bomb):
    bomb.blocks.new("B").add_circle((0, 0), 1)
    many = {"row_count": 1000, "column_count": 1000, "row_spacing": 3, "column_spacing": 3}
    bomb.modelspace().add_blockref("B", (0, 0), dxfattribs=many)
    assert "INSERT handle" in refused(bomb.path(), {"obstacle": ["*"]})


def test_thousands_of_layers_are_told_in_a_few_lines(bomb):
    for k in range(600):
        bomb.modelspace().add_circle((k % 60, k // 60), 0.1, dxfattribs={"layer": f"L{k}"})
    path = bomb.path()
    assert "600 layers have no clear role: 'L0', 'L1'" in refused(path)
    assert "and 580 more" in refused(path)
    line = refused(path, {"obstacle": ["M7"]})
    assert "unknown layer 'M7'" in line
    assert len(read_geometry(path, {"obstacle": ["L1?"], "ignore": ["*"]}).obstacles) == 10


def test_a_tolerance_wider_than_the_drawing_is_refused(bomb):
    for k in range(2000):
        x, y = k % 50, k // 50
        bomb.modelspace().add_line((x, y), (x + 0.5, y), dxfattribs={"layer": "walls"})
    assert "the tolerance of --join is too wide" in refused(bomb.path(), join=100.0)


def test_a_curve_is_drawn_by_a_bounded_number_of_chords(bomb):
    spline = bomb.modelspace().add_spline(dxfattribs={"layer": "walls"})
    spline.set_open_uniform([(0, 0), (1e6, 9e6), (2e6, -9e6), (3e6, 0)])
    assert "chords draw it within 1e-06 m" in refused(bomb.path(), join=1e-6, unit="m")


def test_a_name_cannot_write_to_the_terminal(bomb):
    from app.cli.world import printable

    bomb.modelspace().add_circle((0, 0), 1, dxfattribs={"layer": "a\x1b[2Jb"})
    line = refused(bomb.path())
    assert "\x1b" not in line
    assert printable("a\x1b[2Jb") == "a\\x1b[2Jb"


def test_noise_in_a_dxf_is_refused(tmp_path, bomb):
    bomb.modelspace().add_lwpolyline(SQUARE, close=True, dxfattribs={"layer": "walkable"})
    bomb.modelspace().add_spline([(0, 0, 0), (1, 1, 0), (2, 0, 0)], dxfattribs={"layer": "walls"})
    stream = io.StringIO()
    bomb.write(stream)
    lines = stream.getvalue().splitlines()
    at = lines.index("AcDbPolyline")
    path = tmp_path / "noise.dxf"
    told = []
    for number in range(at, at + 24):
        for noise in ("", "nan", "1e400", "-7", "\x00"):
            path.write_text("\n".join([*lines[:number], noise, *lines[number + 1 :]]))
            try:
                read_geometry(path, join=0.1, thickness=0.1)
            except InputError as refusal:
                told.append(str(refusal))
    print(f"{24 * 5} damaged files, {len(told)} refused")
    assert len(told) > 40
    assert not any("\n" in line for line in told)
