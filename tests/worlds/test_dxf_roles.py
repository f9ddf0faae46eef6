"""DXF drawings: layers that are hidden, lines that are joined, curves drawn by chords."""

import itertools
import math

import ezdxf
import pytest
from ezdxf import units

from worlds.input_error import InputError
from worlds.readers import read_geometry, world_around

HALL = [(0, 0), (20, 0), (20, 9), (0, 9)]


@pytest.fixture
def drawing(tmp_path):
    class Drawing:
        path = tmp_path / "plan.dxf"
        document = ezdxf.new(units=units.M)
        space = document.modelspace()

        def outline(self, points, layer, close=True):
            self.space.add_lwpolyline(points, close=close, dxfattribs={"layer": layer})

        def lines(self, points, layer):
            for a, b in itertools.pairwise(points):
                self.space.add_line(a, b, dxfattribs={"layer": layer})

        def read(self, roles=None, **options):
            self.document.saveas(self.path)
            return read_geometry(self.path, roles, **options)

        def refused(self, roles=None, **options):
            with pytest.raises(InputError) as refusal:
                self.read(roles, **options)
            return getattr(refusal.value, "lines", (str(refusal.value),))

    return Drawing()


def test_layers_of_jupedsim_are_what_their_names_say(drawing):
    drawing.outline(HALL, "jps-walkablearea")
    drawing.outline([(8, 2), (9, 2), (9, 4), (8, 4)], "jps-obstacles")
    drawing.outline([(18, 4), (20, 4), (20, 6), (18, 6)], "jps-exits")
    drawing.outline([(1, 1), (4, 1), (4, 8), (1, 8)], "jps-distributions")
    drawing.space.add_circle((10, 7), 0.8, dxfattribs={"layer": "jps-waypoints"})
    drawing.space.add_mtext("v0 = 1.2", dxfattribs={"layer": "jps-parameters"})
    taken = drawing.read()
    assert [(row.layer, row.entities, row.role) for row in taken.layers] == [
        ("jps-walkablearea", "1 LWPOLYLINE", "walkable"),
        ("jps-obstacles", "1 LWPOLYLINE", "obstacle"),
        ("jps-exits", "1 LWPOLYLINE", "goal"),
        ("jps-distributions", "1 LWPOLYLINE", "start"),
        ("jps-waypoints", "1 CIRCLE", "path"),
        ("jps-parameters", "1 MTEXT", "ignore"),
    ]
    world = world_around(taken)
    assert [one.name for one in world.obstacles] == ["jps-obstacles"]
    assert world.mission.goal.route == ((19.0, 5.0),)
    assert (world.mission.start.low, world.mission.start.high) == ((1.0, 1.0), (4.0, 8.0))
    assert (world.mission.path.waypoints, world.mission.path.switch) == (((10.0, 7.0),), 0.8)


def test_what_has_no_clear_role_is_refused_by_name(drawing):
    drawing.outline(HALL, "Floor")
    drawing.outline([(8, 2), (9, 2), (9, 4)], "stage")
    (line,) = drawing.refused({"walkable": ["floor"]})
    assert "layer 'stage': no clear role" in line
    (line,) = drawing.refused()
    assert "2 layers have no clear role: 'Floor', 'stage'" in line
    assert drawing.read({"walkable": ["floor"], "ignore": ["*"]}).obstacles == ()


def test_hidden_layers_are_ignored_unless_named(drawing):
    drawing.outline(HALL, "walkable")
    drawing.outline([(8, 2), (9, 2), (9, 4)], "walls")
    drawing.outline([(11, 2), (12, 2), (12, 4)], "pillars")
    drawing.document.layers.add("walls").freeze()
    drawing.document.layers.add("pillars").off()
    taken = drawing.read()
    assert taken.obstacles == ()
    assert [row.why for row in taken.layers if row.role == "ignore"] == ["it is frozen",
                                                                          "it is off"]  # fmt: skip
    (made,) = drawing.read({"obstacle": ["Walls"]}).obstacles
    assert made.name == "walls"


def test_lines_that_meet_end_to_end_are_joined_when_asked(drawing):
    gap = 0.004
    drawing.lines([*HALL[:3], (20, 9)][:3], "walkable")
    drawing.space.add_line((0, 9), (20, 9 + gap), dxfattribs={"layer": "walkable"})
    drawing.space.add_lwpolyline([(0, 9), (0, 0)], dxfattribs={"layer": "walkable"})
    (line,) = drawing.refused()
    assert "4 open lines bound no area" in line
    assert "--join" in line
    taken = drawing.read(join=0.01)
    assert taken.walkable.area == pytest.approx(180.0, abs=0.1)
    assert len(taken.changes) == 4
    assert sum("over a gap of 0.004 m" in one for one in taken.changes) == 1
    assert all("layer 'walkable', L" in one and "joined with L" in one for one in taken.changes)
    (line,) = drawing.refused(join=0.001)
    assert "an open line" in line


def test_a_joint_that_is_a_parting_of_ways_is_not_joined(drawing):
    drawing.lines([(0, 0), (5, 0), (5, 5), (0, 0)], "walls")
    drawing.lines([(0, 0), (-3, 0)], "walls")
    lines = drawing.refused(join=0.01)
    assert len(lines) == 2
    taken = drawing.read(join=0.01, thickness=0.1)
    assert len(taken.obstacles) == 2
    assert any("3 ends meet at (0, 0): not joined" in one for one in taken.changes)


def test_lines_that_cannot_be_used_are_left_out_when_asked(drawing):
    drawing.outline(HALL, "walkable")
    drawing.lines([(3, 3), (3.5, 3)], "walkable")
    drawing.space.add_line((1, 1), (1, 1), dxfattribs={"layer": "walkable"})
    (line,) = drawing.refused()
    assert "from (3, 3) to (3.5, 3)" in line
    taken = drawing.read(drop_lines=True)
    assert taken.walkable.area == 180.0
    stray, dropped = taken.changes
    assert "LINE handle" in stray
    assert "a single point at (1, 1)" in stray
    assert "left out, an open line from (3, 3) to (3.5, 3)" in dropped


def test_splines_are_drawn_by_chords_when_asked(drawing):
    turns = [k * math.pi / 8 for k in range(16)]
    around = [(4 * math.cos(turn), 4 * math.sin(turn), 0) for turn in turns]
    drawing.space.add_spline([*around, around[0]], dxfattribs={"layer": "pillars"})
    (line,) = drawing.refused()
    assert "SPLINE handle" in line
    assert "--join 0.01" in line
    rough, fine = (drawing.read(join=within) for within in (0.1, 0.001))
    assert len(rough.obstacles[0].points) < len(fine.obstacles[0].points) < 500
    assert "drawn by" in fine.changes[0]
    inner = rough.obstacles[0].footprint()
    assert inner.hausdorff_distance(fine.obstacles[0].footprint()) < 0.11


def test_a_flat_face_is_an_area(drawing):
    drawing.space.add_3dface([(0, 0, 1), (4, 0, 1), (4, 3, 1), (0, 3, 1)],
                             dxfattribs={"layer": "walls"})  # fmt: skip
    assert drawing.read().obstacles[0].footprint().area == 12.0


def test_a_drawing_in_the_wrong_unit_is_questioned(drawing):
    drawing.document.units = units.MM
    drawing.outline(HALL, "walkable")
    (line,) = drawing.refused()
    assert "0.02 m wide ($INSUNITS says mm): give --unit mm if that is so" in line
    assert "--unit m (20 m)" in line
    assert drawing.read(unit="m").walkable.area == 180.0
    assert drawing.read(unit="mm").walkable.area == pytest.approx(180e-6)
