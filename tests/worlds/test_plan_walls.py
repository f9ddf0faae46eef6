"""Closed lines of walls: walls of a thickness, or a question, and never a block in silence."""

import itertools

import ezdxf
import pytest
import shapely
from ezdxf import units

from worlds.input_error import InputError
from worlds.obstacles import Ring
from worlds.readers import read_geometry, world_around
from worlds.readers.drawing_contents import PlanQuestion
from worlds.readers.roles import role_from_name

HALL = [(0, 0), (24, 0), (24, 7), (0, 7)]
ALONG = 24.2 * 7.2 - 23.8 * 6.8
"""Area of a wall 0.2 m thick along HALL, m²."""


@pytest.fixture
def drawing(tmp_path):
    class Drawing:
        path = tmp_path / "house.dxf"
        document = ezdxf.new(units=units.M)
        space = document.modelspace()

        def outline(self, points, layer="A-WALL", close=True):
            made = self.space.add_lwpolyline(points, close=close, dxfattribs={"layer": layer})
            return made.dxf.handle

        def lines(self, points, layer="A-WALL"):
            for a, b in itertools.pairwise([*points, points[0]]):
                self.space.add_line(a, b, dxfattribs={"layer": layer})

        def read(self, roles=None, **options):
            self.document.saveas(self.path)
            return read_geometry(self.path, roles, **options)

        def asked(self, roles=None, **options):
            with pytest.raises(PlanQuestion) as question:
                self.read(roles, **options)
            assert "\n" not in str(question.value)
            return question.value

    return Drawing()


@pytest.mark.parametrize("name", ["wall", "A-WALL", "Walls 2", "fence", "barriers"])
def test_names_of_walls_say_so(name):
    assert role_from_name(name)[0] == "wall"


def test_a_closed_polyline_is_a_wall_of_its_thickness(drawing):
    drawing.outline(HALL)
    drawing.outline([(8, 0), (8, 5)], close=False)
    taken = drawing.read(thickness=0.2)
    around, inner = taken.obstacles
    assert around.footprint().area == pytest.approx(ALONG)
    assert not around.footprint().covers(shapely.Point(12, 3.5))
    assert inner.footprint().area == pytest.approx(1.0)
    assert taken.changes == ("layer 'A-WALL': 1 closed line is a wall 0.2 m thick, and not solid",)
    assert world_around(taken, margin=1.0).obstacles == taken.obstacles


def test_lines_that_join_closes_are_walls(drawing):
    drawing.lines(HALL)
    (around,) = drawing.read(join=0.01, thickness=0.2).obstacles
    assert around.footprint().area == pytest.approx(ALONG)
    question = drawing.asked(join=0.01)
    assert "would be a solid block of 24 x 7 m" in str(question)


def test_an_outline_that_holds_all_else_is_a_question(drawing):
    handle = drawing.outline(HALL)
    drawing.outline([(2, 2), (2.5, 2), (2.5, 2.5)])
    question = drawing.asked()
    assert f"LWPOLYLINE handle {handle}: it holds all else on layer 'A-WALL'" in str(question)
    assert "--solid A-WALL if that is so, or --wall A-WALL --thickness 0.2" in str(question)
    solid, walls = question.choices
    assert drawing.read(**solid.options).obstacles[0].footprint().area == 168.0
    made = drawing.read(**walls.options, thickness=0.2).obstacles
    assert made[0].footprint().area == pytest.approx(ALONG)
    assert walls.thickness


def test_other_layers_are_asked_too_unless_they_are_named(drawing):
    drawing.outline(HALL, "building")
    drawing.outline([(2, 2), (2.5, 2), (2.5, 2.5)], "building")
    assert "holds all else on layer 'building'" in str(drawing.asked(thickness=0.2))
    assert len(drawing.read({"obstacle": ["building"]}, thickness=0.2).obstacles) == 2


def test_several_rooms_are_asked_about_and_thin_outlines_are_not(drawing):
    drawing.outline([(0, 0), (4, 0), (4, 3), (0, 3)])
    drawing.outline([(6, 0), (10, 0), (10, 3), (6, 3)])
    assert "too wide for the outline of a wall" in str(drawing.asked())
    drawing.document.modelspace().delete_all_entities()
    drawing.outline([(0, 0), (4, 0), (4, 0.3), (0, 0.3)])
    drawing.outline([(6, 0), (6.3, 0), (6.3, 3), (6, 3)])
    areas = [one.footprint().area for one in drawing.read().obstacles]
    assert areas == pytest.approx([1.2, 0.9])


def test_fills_stay_solid_and_circles_become_rings(drawing):
    drawing.space.add_circle((30, 3), 2.0, dxfattribs={"layer": "A-WALL"})
    hatch = drawing.space.add_hatch(dxfattribs={"layer": "A-WALL"})
    hatch.paths.add_polyline_path([(0, 0), (2, 0), (2, 2), (0, 2)], is_closed=True)
    by_kind = {one.shape: one for one in drawing.read(thickness=0.2).obstacles}
    assert by_kind["ring"] == Ring(name="A-WALL", centre=(30, 3), radius=2.1, width=0.2)
    assert by_kind["polygon"].footprint().area == 4.0
    named = drawing.read({"wall": ["A-WALL"]}, thickness=0.2).obstacles
    assert min(one.footprint().area for one in named) == pytest.approx(2.2**2 - 1.8**2)


def test_a_crossing_that_join_makes_is_told_with_all_its_pieces(drawing):
    drawing.lines([(0, 0), (4, 4), (4, 0), (0, 4)], "pillars")
    handles = [one.dxf.handle for one in drawing.space]
    with pytest.raises(InputError) as refusal:
        drawing.read(join=0.01)
    line = str(refusal.value)
    assert "crosses itself at (2, 2)" in line
    assert all(f"LINE handle {handle}" in line for handle in handles)
    assert "give a smaller --join" in line


def test_a_hatch_that_is_open_by_rounding_is_closed(drawing):
    hatch = drawing.space.add_hatch(dxfattribs={"layer": "pillars"})
    edges = hatch.paths.add_edge_path()
    corners = [(0, 0), (4, 0), (4, 4), (0, 4), (1e-13, 0)]
    for a, b in itertools.pairwise(corners):
        edges.add_line(a, b)
    (made,) = drawing.read().obstacles
    assert made.footprint().area == pytest.approx(16.0)
    edges.edges[-1].end = ezdxf.math.Vec2(1e-7, 0)
    (made,) = drawing.read().obstacles
    assert made.footprint().area == pytest.approx(16.0)
