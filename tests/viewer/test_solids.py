"""Meshes of what is solid: closed, as large as they should be, with their holes."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from app.viewer.scene.draw.shapes import Mesh, dashes
from app.viewer.scene.draw.solids import border, join_meshes, panes, prism, rims, uprights

SQUARE = shapely.box(0.0, 0.0, 4.0, 4.0)
FRAME = shapely.difference(SQUARE, shapely.box(1.0, 1.0, 2.0, 3.0))
DISC = shapely.Point(9.0, 1.0).buffer(1.0)


def volume(mesh: Mesh) -> float:
    """What a closed mesh encloses, by the divergence theorem."""
    vertices, faces = mesh
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def is_closed(mesh: Mesh) -> bool:
    """Whether every edge is run through once in each direction."""
    edges = [(face[k], face[(k + 1) % 3]) for face in mesh[1].tolist() for k in range(3)]
    return len(set(edges)) == len(edges) and {edge[::-1] for edge in edges} == set(edges)


@pytest.mark.parametrize(
    "outline",
    [
        SQUARE,
        SQUARE.reverse(),
        FRAME,
        DISC,
        shapely.union_all([FRAME, DISC]),
        shapely.Polygon([(0, 0), (4, 0), (4, 3), (2, 1), (0, 3)]),
    ],
    ids=["square", "clockwise", "frame", "disc", "two", "notched"],
)
def test_a_prism_is_closed_and_holds_its_outlines_area_times_its_height(outline):
    mesh = prism(outline, -0.5, 1.5)
    assert is_closed(mesh)
    assert volume(mesh) == pytest.approx(2.0 * outline.area)
    assert np.unique(mesh[0][:, 2]).tolist() == [-0.5, 1.5]


@given(
    st.lists(
        st.tuples(st.floats(0, 9), st.floats(0, 9), st.floats(0.2, 2.0)), min_size=1, max_size=6
    )
)
@settings(max_examples=60, deadline=None, derandomize=True)
def test_any_union_of_discs_is_closed_and_has_its_volume(discs):
    outline = shapely.union_all([shapely.Point(x, y).buffer(r) for x, y, r in discs])
    mesh = prism(outline, 0.0, 1.0)
    assert is_closed(mesh)
    assert volume(mesh) == pytest.approx(outline.area, rel=1e-9)


def test_there_is_nothing_over_a_hole():
    vertices, faces = prism(FRAME, 0.0, 1.0)
    top = faces[np.all(vertices[faces][:, :, 2] == 1.0, axis=1)]
    middle = vertices[top].mean(axis=1)
    assert not np.any(
        (middle[:, 0] > 1) & (middle[:, 0] < 2) & (middle[:, 1] > 1) & (middle[:, 1] < 3)
    )


def test_nothing_makes_no_mesh():
    vertices, faces = prism(shapely.Polygon(), 0.0, 1.0)
    assert vertices.shape == (0, 3)
    assert faces.shape == (0, 3)
    assert rims(shapely.Polygon(), 1.0).shape == (0, 2, 3)


def test_joined_meshes_keep_their_faces():
    mesh = join_meshes([prism(SQUARE, 0.0, 1.0), prism(DISC, 2.0, 3.0)])
    assert is_closed(mesh)
    assert volume(mesh) == pytest.approx(SQUARE.area + DISC.area)


def test_rims_go_along_all_outlines_and_uprights_stand_on_corners_only():
    lines = rims(FRAME, 2.0)
    assert np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum() == pytest.approx(FRAME.length)
    assert np.all(lines[..., 2] == 2.0)
    assert len(uprights(FRAME, 0.0, 2.0)) == 8
    assert len(uprights(DISC, 0.0, 2.0)) == 0


def test_a_border_runs_outside_the_solid_edges_alone():
    low, high = np.zeros(2), np.array([4.0, 2.0])
    along_y = border(low, high, np.array([False, True]), 0.5)
    assert along_y.area == pytest.approx(2 * 4.0 * 0.5)
    assert not along_y.intersects(shapely.box(0.1, 0.1, 3.9, 1.9))
    around = border(low, high, np.array([True, True]), 0.5)
    assert around.area == pytest.approx(5.0 * 3.0 - 8.0)
    assert len(shapely.get_parts(around)) == 1


def test_panes_stand_on_the_solid_faces_of_a_box():
    low, high = np.array([0.0, 0.0, 0.0]), np.array([3.0, 2.0, 1.0])
    vertices, faces = panes(low, high, np.array([True, False, True]))
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    assert area == pytest.approx(2 * (2.0 * 1.0) + 2 * (3.0 * 2.0))
    assert not len(panes(low, high, np.zeros(3, bool))[1])


def test_dashes_end_where_their_line_ends_and_know_their_leg():
    way = np.array([[0.0, 0.0, 0.0], [10.3, 0.0, 0.0], [10.3, 0.0, 0.0], [10.3, 0.4, 0.0]])
    lines, leg = dashes(way, 1.0, 1.0)
    assert lines[0, 0].tolist() == [0.0, 0.0, 0.0]
    assert lines[leg == 0][-1, 1] == pytest.approx([10.3, 0.0, 0.0])
    assert lines[-1, 1] == pytest.approx([10.3, 0.4, 0.0])
    assert leg.tolist() == [0] * 6 + [2]
    drawn = np.linalg.norm(lines[leg == 0][:, 1] - lines[leg == 0][:, 0], axis=1)
    assert drawn == pytest.approx(np.full(6, 10.3 / 11))
