"""The zones of the inspected agent: shapes, what is drawn of them, colours, and the card."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from agents.inspection import Inspection, Shell
from agents.state.agent_rows import Crashes
from app.viewer.lab.panels.inspector import folds, head
from app.viewer.scene.draw.drawn_frame import picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.marks.inspection_marks import InspectionMarks
from app.viewer.scene.marks.zone_marks import ZoneMarks, arc, arcs, cone, dome, sector, spokes
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.colouring import MOST_SAVED
from app.viewer.scene.shown.drawing_style import DrawingStyle, agent_colours, legend
from app.viewer.scene.shown.frame import Frame
from app.viewer.scene.shown.palette import srgb_to_linear
from tests.viewer.test_scene_worlds import Stand, draw
from worlds.world import World

SHELLS = (
    Shell("repulsion", 1.0, True),
    Shell("orientation", 3.0, False),
    Shell("attraction", 6.0, False),
)
HALVES = [0.3, 0.25 * np.pi, 0.5 * np.pi, 2.4, np.pi]


def frame(dim: int = 3, view: float = 270.0, shells=SHELLS) -> Frame:
    """Agent 0 is looked at; 1 to 3 are in its zones, 4 is unseen, 5 is far away."""
    middle = np.full(dim, 10.0)
    axis = np.eye(dim)[0]
    away = np.array([0.0, -0.5, 2.0, 5.0, -4.0, 9.0])
    heading = np.tile(axis, (6, 1))
    seen = Inspection(
        1, 0, np.arange(1, 5), away[1:5, None] * axis, np.array([1.0, 0.0, 0.0, 0.0]), {},
        zone=np.array([0, 1, 2, -1]), shells=shells, view=view,
    )  # fmt: skip
    return Frame(
        run=1,
        tick=0,
        world=World("sky", (20.0,) * dim, ("wrap",) * dim),
        reach=6.0,
        speed_scale=1.0,
        position=middle + away[:, None] * axis,
        heading=heading,
        speed=np.ones(6),
        informed=np.zeros(6, bool),
        ids=np.arange(1, 7),
        inspected=seen,
    )


def shown(one: Frame, look: DrawingStyle | None = None):
    return picture(one, look or DrawingStyle(), Stage.of(one))


def area(mesh) -> float:
    vertices, faces = mesh
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


@pytest.mark.parametrize("half", HALVES)
def test_domes_and_cones_have_their_areas(half):
    assert area(dome(half)) == pytest.approx(2.0 * np.pi * (1.0 - np.cos(half)), rel=0.01)
    assert area(cone(half)) == pytest.approx(np.pi * np.sin(half), rel=0.01, abs=1e-9)
    rest = area(dome(np.pi, half)) if half < np.pi else 0.0
    assert area(dome(half)) + rest == pytest.approx(4.0 * np.pi, rel=0.01)
    vertices, faces = dome(half)
    assert np.linalg.norm(vertices, axis=1) == pytest.approx(1.0)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    assert np.all(np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) > -1e-12)


@pytest.mark.parametrize("half", HALVES)
@pytest.mark.parametrize("inner", [0.0, 0.4])
def test_sectors_have_their_areas_and_face_up(half, inner):
    vertices, faces = sector(inner, 0.0, half)
    assert area((vertices, faces)) == pytest.approx(half * (1.0 - inner**2), rel=0.01)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    assert np.all(np.cross(b - a, c - a)[:, 2] > -1e-12)
    behind = sector(0.0, half, np.pi) if half < np.pi else (np.zeros((3, 3)), np.zeros((0, 3), int))
    assert area(behind) == pytest.approx(np.pi - half, rel=0.01, abs=1e-9)


@pytest.mark.parametrize("half", HALVES)
def test_arcs_and_spokes_end_at_the_edge_of_what_is_seen(half):
    for lines in (arc(half), arcs(half)):
        assert np.linalg.norm(lines, axis=2) == pytest.approx(1.0)
        off = np.arccos(np.clip(lines[..., 0], -1.0, 1.0))
        assert off.max() == pytest.approx(half, abs=1e-6)
    for flat, count in ((True, 2), (False, 4)):
        made = spokes(half, flat)
        assert made.shape == (count, 2, 3)
        assert np.array_equal(made[:, 0], np.zeros((count, 3)))
        assert made[:, 1, 0] == pytest.approx(np.cos(half))


def radius(node) -> float:
    vertices, faces = node.given
    assert vertices.min(axis=0) + vertices.max(axis=0) == pytest.approx(np.zeros(3))
    return float(np.linalg.norm(vertices[faces.ravel()], axis=1).max())


@pytest.mark.parametrize("dim", [2, 3])
def test_the_shells_are_about_the_agent_as_wide_as_the_zones(dim):
    scene = Stand()
    marks = ZoneMarks(scene)
    made = shown(frame(dim))
    draw(marks, made)
    meshes = [
        node for node in scene.sent if node.name.startswith("/inspected/zones/") and node.given
    ]
    meshes = [node for node in meshes if "edges" not in node.name]
    scale = made.stage.scale
    outer = 2 if dim == 3 else 1
    wanted = [1.0 * scale, 3.0 * scale, 6.0 * scale] + outer * [6.0 * scale]
    assert [radius(node) for node in meshes] == pytest.approx(wanted)
    for node in meshes:
        assert node.visible
        assert node.position[:2] == pytest.approx(made.at[0, :2])
        assert np.array_equal(node.wxyz, made.wxyz[0])
    sent = len(scene.sent)
    draw(marks, shown(replace(frame(dim), tick=1)))
    assert len(scene.sent) == sent
    draw(marks, shown(frame(dim, view=90.0)))
    assert not any(node.there for node in meshes)
    draw(marks, shown(frame(dim), DrawingStyle(zones=False)))
    assert not any(node.visible for node in scene.sent if node.there)


def test_who_sees_all_round_has_no_blind_cone_and_no_zone_is_empty():
    scene = Stand()
    marks = ZoneMarks(scene)
    narrow = (Shell("repulsion", 2.0, False), Shell("orientation", 2.0, False), SHELLS[2])
    made = shown(frame(view=360.0, shells=narrow))
    draw(marks, made)
    radii = [radius(node) for node in scene.sent if node.name[-1].isdigit()]
    assert radii == pytest.approx([2.0 * made.stage.scale, 6.0 * made.stage.scale])


def test_lines_go_to_those_that_count_in_the_colour_of_their_zone():
    scene = Stand()
    draw(ZoneMarks(scene), shown(frame()))
    lines = scene.there("/inspected/noticed").points
    made = shown(frame())
    assert lines == pytest.approx(made.at[None, [0, 1]], abs=1e-5)
    marks = InspectionMarks(other := Stand())
    draw(marks, made)
    assert {node.name for node in other.sent if node.visible} == {"/inspected/ring"}
    draw(marks, shown(frame(), DrawingStyle(zones=False)))
    assert other.there("/inspected/ball").visible


@pytest.mark.parametrize("dim", [2, 3])
def test_neighbours_wear_the_colours_of_their_zones_and_the_blind_ones_grey(dim):
    one = frame(dim)
    made = shown(one)
    wanted = [*palette.ZONES[:3], palette.BLIND]
    assert made.colour[1:5] == pytest.approx(np.array(wanted))
    plain = agent_colours(one, DrawingStyle())
    assert made.colour[0] == pytest.approx(plain[0])
    kept = shown(one, DrawingStyle(zones=False)).colour
    assert kept[1:5] == pytest.approx(plain[1:5])


def test_zones_differ_in_lightness_as_well_as_in_hue():
    light = srgb_to_linear(np.array([*palette.ZONES[:3], palette.BLIND])) @ [0.2126, 0.7152, 0.0722]
    assert light[1] > 2.0 * light[0]
    assert light[1] > 2.0 * light[2]
    assert min(np.linalg.norm(palette.BLIND - zone) for zone in palette.ZONES) > 0.25


def test_the_card_counts_the_neighbours_in_each_zone():
    told = folds(frame(), frame().inspected)
    label, words = told["zones"]
    assert label == "Zones: 3 noticed"
    for name, extent, count in (
        ("repulsion", "0 – 1 length", 1),
        ("orientation", "1 – 3 length", 1),
        ("attraction", "3 – 6 length", 1),
        ("not noticed", "", 1),
    ):
        assert f"{name}</td><td>{extent}</td><td>{count}</td>" in words
    assert "sees 270°" in words
    assert told["heard"][0] == "Listens to 1 agent"
    assert told["heard"][1].count("100 %") == 1
    assert "and 0 more" not in told["heard"][1]


def test_the_card_of_a_crashed_agent_says_when_and_against_what():
    one = frame()
    flying = np.array([False, True, True, True, True, True])
    crash = Crashes(np.array([7]), np.array([1]), np.array([0]), one.position[:1], np.array([2]))
    lying = replace(one, active=flying, crashes=crash)
    assert "tick 7, an obstacle or a wall" in head(lying, one.inspected)
    assert not {"zones", "forces", "heard"} & set(folds(lying, one.inspected))


def test_saving_is_teal_paying_is_orange_and_neither_is_grey():
    saved = np.array([-2.0, -MOST_SAVED, -0.2, 0.0, 0.2, MOST_SAVED, 2.0, np.nan])
    colours = palette.saving_colours(saved, MOST_SAVED)
    assert colours[0] == pytest.approx(colours[1])
    assert colours[5] == pytest.approx(colours[6])
    assert colours[7] == pytest.approx(palette.UNKNOWN)
    assert np.ptp(colours[3]) < 0.02
    warm = colours[:, 0] - colours[:, 2]
    assert warm[1] > warm[2] > warm[3] > warm[4] > warm[5]


def test_energy_saved_is_said_to_be_unknown_where_it_is_not_measured():
    look = DrawingStyle(colour="energy saved")
    one = frame()
    assert agent_colours(one, look) == pytest.approx(np.tile(palette.UNKNOWN, (6, 1)))
    assert [words for words, _ in legend(look, one)] == ["not measured in this model"]
    saved = np.array([0.3, 0.0, -0.3, np.nan, 0.1, 0.6])
    known = replace(one, saved=saved, active=np.arange(6) != 2)
    colours = agent_colours(known, look)
    assert colours[0] == pytest.approx(palette.saving_colours(saved, MOST_SAVED)[0])
    assert colours[2] == pytest.approx(palette.CRASHED)
    entries = dict(legend(look, known))
    assert list(entries)[-2:] == ["unknown", "crashed"]
    assert entries["0"] == palette.css(colours[1])
