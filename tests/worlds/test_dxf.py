"""DXF drawings: closed outlines, arcs, blocks, units, and what is refused with layer and place."""

import math

import ezdxf
import numpy as np
import pytest
import shapely
from ezdxf import units

from worlds import plug_ins
from worlds.input_error import InputError
from worlds.obstacles import Disc, Polygon, Wall
from worlds.readers import read_geometry

SQUARE = [(0, 0), (4, 0), (4, 4), (0, 4)]
SOLID = {"obstacle": ["*"]}


@pytest.fixture
def drawing(tmp_path):
    class Drawing:
        path = tmp_path / "plan.dxf"
        document = ezdxf.new(units=units.M)
        space = document.modelspace()

        def read(self, roles=SOLID, **options):
            self.document.saveas(self.path)
            return read_geometry(self.path, roles, **options)

        def refused(self, roles=SOLID, **options):
            with pytest.raises(InputError) as refusal:
                self.read(roles, **options)
            line = str(refusal.value)
            assert "plan.dxf" in line
            assert "\n" not in line
            return line

    return Drawing()


def refusal_of(drawing, **options):
    with pytest.raises(InputError) as refusal:
        drawing.read(**options)
    return refusal.value


def area(drawing, **options):
    return sum(one.footprint().area for one in drawing.read(**options).obstacles)


def test_closed_polylines_and_circles_on_their_layers(drawing):
    drawing.space.add_lwpolyline(SQUARE, close=True, dxfattribs={"layer": "BLOCKS"})
    drawing.space.add_circle((9, 2), 1.5, dxfattribs={"layer": "PILLARS"})
    drawing.space.add_polyline2d(SQUARE, close=True, dxfattribs={"layer": "OLD"})
    square, pillar, old = drawing.read().obstacles
    assert square == Polygon(name="BLOCKS", points=tuple(SQUARE))
    assert pillar == Disc(name="PILLARS", centre=(9, 2), radius=1.5)
    assert old.points == square.points
    (only,) = drawing.read({"obstacle": ["pillars"], "ignore": ["OLD", "b*"]}).obstacles
    assert only == pillar


def test_a_polyline_that_ends_where_it_begins_is_closed(drawing):
    drawing.space.add_lwpolyline([*SQUARE, SQUARE[0]])
    assert area(drawing) == 16.0


@pytest.mark.parametrize(
    ("unit", "metres"), [(units.MM, 0.001), (units.CM, 0.01), (units.FT, 0.3048), (units.M, 1.0)]
)
def test_lengths_are_metres(drawing, unit, metres):
    drawing.document.units = unit
    drawing.space.add_circle((2 / metres, 3 / metres), 1.5 / metres)
    (disc,) = drawing.read().obstacles
    assert (disc.centre, disc.radius) == ((2.0, 3.0), 1.5)
    (other,) = drawing.read(scale=5.0 * metres).obstacles
    assert other.radius == 7.5


def test_a_drawing_without_a_unit_needs_a_scale(drawing):
    drawing.document.units = 0
    drawing.space.add_circle((2, 3), 1.0)
    assert "does not say its unit ($INSUNITS): give --unit" in drawing.refused()
    assert drawing.read(scale=0.5).obstacles[0].radius == 0.5
    assert drawing.read(unit="ft").obstacles[0].radius == 0.3048
    assert "unknown unit 'feet'" in str(refusal_of(drawing, unit="feet"))
    assert "say the same thing" in str(refusal_of(drawing, unit="ft", scale=1.0))


def test_bulges_are_arcs_within_the_stated_tolerance(drawing):
    drawing.space.add_lwpolyline([(0, 0, 1.0), (4, 0, 1.0)], format="xyb", close=True)
    (disc,) = drawing.read().obstacles
    points = np.array(disc.points)
    assert np.allclose(np.hypot(points[:, 0] - 2, points[:, 1]), 2.0)
    assert len(points) == 128
    inner = disc.footprint().exterior.distance(shapely.Point(2, 0))
    assert 0.0 < 2.0 - inner < 0.00031 * 2.0


def test_an_ellipse_and_a_filled_quad(drawing):
    drawing.space.add_ellipse((0, 0), (3, 0), 0.5)
    drawing.space.add_solid([(10, 0), (12, 0), (10, 1), (12, 1)])
    ellipse, quad = drawing.read().obstacles
    assert ellipse.footprint().area == pytest.approx(math.pi * 3 * 1.5, rel=1e-3)
    assert quad.footprint().equals(shapely.box(10, 0, 12, 1))


def test_a_hatch_has_its_holes(drawing):
    hatch = drawing.space.add_hatch(dxfattribs={"layer": "FILL"})
    hatch.paths.add_polyline_path(SQUARE, is_closed=True)
    hatch.paths.add_polyline_path([(1, 1), (3, 1), (3, 3), (1, 3)], is_closed=True, flags=16)
    edges = hatch.paths.add_edge_path()
    edges.add_arc((10, 0), 1.0, 0, 360)
    ring, disc = drawing.read().obstacles
    assert ring.footprint().area == 16.0 - 4.0
    assert disc.footprint().area == pytest.approx(math.pi, rel=2e-3)
    assert disc.footprint().centroid.coords[0] == pytest.approx((10.0, 0.0), abs=1e-6)


def test_blocks_are_opened_to_any_depth(drawing):
    pillar = drawing.document.blocks.new("PILLAR")
    pillar.add_circle((0, 0), 0.5)
    pair = drawing.document.blocks.new("PAIR")
    pair.add_blockref("PILLAR", (0, 0))
    pair.add_blockref("PILLAR", (3, 0), dxfattribs={"layer": "RED"})
    drawing.space.add_blockref("PAIR", (10, 5), dxfattribs={"layer": "COLUMNS", "rotation": 90})
    one, other = drawing.read().obstacles
    assert (one.name, other.name) == ("COLUMNS", "RED")
    assert one.centre == pytest.approx((10, 5))
    assert other.centre == pytest.approx((10, 8))


def test_a_block_within_itself_is_refused(drawing):
    block = drawing.document.blocks.new("SNAKE")
    block.add_blockref("SNAKE", (1, 0))
    drawing.space.add_blockref("SNAKE", (0, 0))
    line = drawing.refused()
    assert "INSERT in block 'SNAKE', inserted by handle" in line
    assert "this kind is not read" in line


def test_a_mirrored_plane_is_seen_as_it_is_drawn(drawing):
    drawing.space.add_lwpolyline(
        [(0, 0, 0), (4, 0, 1.0), (4, 4, 0), (0, 4, 0)],
        format="xyb",
        close=True,
        dxfattribs={"extrusion": (0, 0, -1)},
    )
    (made,) = drawing.read().obstacles
    assert made.footprint().bounds == pytest.approx((-6, 0, 0, 4), abs=1e-3)


def test_open_lines_are_refused_or_walls(drawing):
    line = drawing.space.add_line((1, 2), (5, 2), dxfattribs={"layer": "WALLS"})
    text = drawing.refused()
    assert f"layer 'WALLS', LINE handle {line.dxf.handle}" in text
    assert "an open line from (1, 2) to (5, 2) bounds no area" in text
    drawing.space.add_lwpolyline([(0, 5), (6, 5), (6, 9)])
    drawing.space.add_arc((20, 0), 2.0, 0, 180)
    wall, bend, arch = drawing.read(thickness=0.2).obstacles
    assert wall == Wall(name="WALLS", start=(1, 2), end=(5, 2), thickness=0.2)
    assert bend.footprint().area == pytest.approx(0.2 * 10)
    assert arch.footprint().area == pytest.approx(0.2 * math.pi * 2.0, rel=1e-3)
    assert arch.footprint().bounds[3] == pytest.approx(2.1, abs=1e-3)


def test_layers_that_are_not_wanted_are_not_judged(drawing):
    drawing.space.add_line((0, 0), (1, 1), dxfattribs={"layer": "AXES"})
    drawing.space.add_lwpolyline(SQUARE, close=True, dxfattribs={"layer": "WALLS"})
    drawing.space.add_lwpolyline(
        [(-9, -9), (9, -9), (9, 9), (-9, 9)], close=True, dxfattribs={"layer": "Floor"}
    )
    roles = {"obstacle": ["WALLS"], "walkable": ["floor"]}
    made = drawing.read(roles | {"ignore": ["AXES"]})
    assert [one.name for one in made.obstacles] == ["WALLS"]
    assert made.walkable.area == 18.0**2
    assert "unknown layer 'WAL': did you mean 'WALLS'?" in drawing.refused({"obstacle": ["WAL"]})


def test_texts_are_left_out_with_a_note(drawing):
    drawing.space.add_text("Hall", dxfattribs={"layer": "NAMES"})
    drawing.space.add_text("Door", dxfattribs={"layer": "NAMES"})
    drawing.space.add_circle((0, 0), 1)
    assert drawing.read().changes == ("2 TEXT on layer 'NAMES' left out",)


@pytest.mark.parametrize(
    ("draw", "words"),
    [
        (lambda s: s.add_lwpolyline([(0, 0), (2, 2), (2, 0), (0, 2)], close=True),
         ["layer '0', LWPOLYLINE handle", "crosses itself at (1, 1)"]),
        (lambda s: s.add_lwpolyline([(0, 0), (2, 2)], close=True), ["has 2 points"]),
        (lambda s: s.add_lwpolyline([(0, 0), (2, 2), (4, 4)], close=True), ["has no area"]),
        (lambda s: s.add_circle((1, 2), 0), ["CIRCLE", "radius = 0 at (1, 2)"]),
        (lambda s: s.add_spline([(0, 0), (1, 1), (2, 0)]), ["SPLINE", "no straight lines draw"]),
        (lambda s: s.add_helix(1, 1, 1), ["HELIX", "this kind is not read"]),
        (lambda s: s.add_3dface([(0, 0, 0), (1, 0, 0), (1, 0, 2), (0, 0, 2)]),
         ["3DFACE", "does not lie flat"]),
        (lambda s: s.add_circle((1, 2), 1, dxfattribs={"extrusion": (1, 0, 0)}),
         ["tilted plane", "(1, 0, 0)"]),
        (lambda s: s.add_blockref("LOST", (1, 2)), ["INSERT handle", "this kind is not read"]),
        (lambda s: s.add_hatch(), ["HATCH", "no boundary"]),
        (lambda s: s.add_ellipse((0, 0), (3, 0), 0.5, 0, math.pi), ["an open line from (3, 0)"]),
        (lambda s: s.add_polymesh((3, 3)), ["a mesh is not an outline"]),
    ],
)  # fmt: skip
def test_an_entity_that_cannot_be_used_is_named(drawing, draw, words):
    draw(drawing.space)
    line = drawing.refused()
    for word in words:
        assert word in line


def test_a_file_that_is_no_dxf_is_named(tmp_path):
    path = tmp_path / "plan.dxf"
    path.write_text("a poem\nwithout lines\n")
    with pytest.raises(InputError, match=r"plan\.dxf.* is not (a )?DXF"):
        read_geometry(path)
    path.write_bytes(b"\x00\xff" * 40)
    with pytest.raises(InputError, match=r"plan\.dxf.* is not (a )?DXF"):
        read_geometry(path)


def test_a_damaged_entity_is_named(drawing):
    drawing.space.add_ellipse((0, 0), (3.25, 0), 0.5)
    drawing.document.saveas(drawing.path)
    drawing.path.write_text(drawing.path.read_text().replace("3.25", "0.0"))
    with pytest.raises(InputError, match=r"ELLIPSE handle \w+: it is damaged: .*null vector"):
        read_geometry(drawing.path, SOLID)


def test_without_the_extra_one_line_says_which_it_needs(drawing, monkeypatch):
    drawing.document.saveas(drawing.path)
    monkeypatch.setattr(plug_ins, "find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"needs the package ezdxf.*install the extra maps"):
        read_geometry(drawing.path, SOLID)
