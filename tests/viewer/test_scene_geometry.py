"""Attitudes, shapes, the stage and the seams of the scene."""

from itertools import combinations

import numpy as np
import pytest
from PIL import Image, ImageDraw

from app.viewer.scene.draw.attitude import attitude, nose
from app.viewer.scene.draw.line_segments import jumps, nearest_image, split_at_seams
from app.viewer.scene.draw.shapes import (
    ball,
    box_edges,
    dart,
    dart_length,
    great_circles,
    ring,
    torus,
)
from app.viewer.scene.draw.stage import DISPLAY_SIDE, Stage

FLAT = Stage(2, (20.0, 8.0), (True, False))
SPACE = Stage(3, (3.0, 6.0, 12.0), (True, True, True))


def rotated(wxyz: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """q v q*, written out: an oracle apart from the code under test."""
    w, u = float(wxyz[0]), np.asarray(wxyz[1:], dtype=float)
    return vector + 2.0 * np.cross(u, np.cross(u, vector) + w * vector)


@pytest.mark.parametrize("dim", [2, 3])
def test_attitude_turns_the_nose_onto_the_heading(dim):
    heading = np.random.default_rng(dim).standard_normal((200, dim))
    heading /= np.linalg.norm(heading, axis=1)[:, None]
    wxyz = attitude(heading)
    assert np.linalg.norm(wxyz, axis=1) == pytest.approx(1.0, abs=1e-6)
    tip = dart()[0][0]
    for q, h in zip(wxyz, heading, strict=True):
        expected = np.zeros(3)
        expected[:dim] = h
        assert rotated(q, tip / np.linalg.norm(tip)) == pytest.approx(expected, abs=1e-6)
        assert nose(q) == pytest.approx(expected, abs=1e-6)


def test_attitude_keeps_the_wings_level():
    heading = np.random.default_rng(5).standard_normal((200, 3))
    heading /= np.linalg.norm(heading, axis=1)[:, None]
    for q in attitude(heading):
        assert rotated(q, np.array([0.0, 1.0, 0.0]))[2] == pytest.approx(0.0, abs=1e-6)
        assert rotated(q, np.array([0.0, 0.0, 1.0]))[2] >= -1e-6


def test_attitude_of_straight_up_and_down():
    up, down = attitude(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]))
    assert nose(up) == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)
    assert nose(down) == pytest.approx([0.0, 0.0, -1.0], abs=1e-6)


def test_a_dart_of_eight_pixels_shows_its_heading():
    nose_, left, right, ridge, _ = dart()[0]
    outline = np.array([nose_, left, ridge, right])[:, :2]
    fine, wide = 8, 12
    seen = []
    for heading in np.arange(16) * np.pi / 8.0:
        turn = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
        drawn = Image.new("L", (fine * wide, fine * wide))
        corners = fine * (8.0 * outline @ turn + wide / 2.0)
        ImageDraw.Draw(drawn).polygon([tuple(corner) for corner in corners], fill=255)
        seen.append(np.asarray(drawn.resize((wide, wide), Image.Resampling.BOX), float))
    for one, other in combinations(range(16), 2):
        differ = np.abs(seen[one] - seen[other]).sum() / (seen[one].sum() + seen[other].sum())
        assert differ > (0.42 if other - one == 8 else 0.2)


@pytest.mark.parametrize("mesh", [dart(), torus(), ball()])
def test_closed_shapes_face_outwards(mesh):
    vertices, faces = mesh
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
    assert volume > 0.0
    edges = {(f[k], f[(k + 1) % 3]) for f in faces.tolist() for k in range(3)}
    torn = [edge for edge in edges if edge[::-1] not in edges]
    poles = {edge for edge in torn if np.allclose(vertices[edge[0]], vertices[edge[1]])}
    assert set(torn) <= poles


def test_ring_has_its_radii_and_faces_up():
    vertices, faces = ring(0.8)
    radius = np.unique(np.round(np.linalg.norm(vertices, axis=1), 9))
    assert radius.tolist() == [0.8, 1.0]
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    assert np.all(np.cross(b - a, c - a)[:, 2] > 0.0)


def test_great_circles_lie_on_the_unit_sphere():
    assert np.linalg.norm(great_circles(), axis=-1) == pytest.approx(1.0)


def test_box_edges_are_four_in_the_plane_and_twelve_in_space():
    assert box_edges(np.array([5.0, 2.0, 0.0])).shape == (4, 2, 3)
    edges = box_edges(np.array([1.0, 2.0, 3.0]))
    lengths = np.sort(np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1))
    assert lengths.tolist() == [2.0] * 4 + [4.0] * 4 + [6.0] * 4


def test_darts_shrink_with_their_number_and_never_vanish():
    half = np.array([5.0, 5.0, 0.0])
    lengths = [dart_length(count, half) for count in (0, 1, 20, 500, 5_000, 20_000)]
    assert lengths == sorted(lengths, reverse=True)
    assert lengths[0] == lengths[2] == pytest.approx(0.44)
    assert lengths[4] == pytest.approx(0.85 * np.sqrt(100 / 5_000))
    assert dart_length(8_000, np.full(3, 5.0)) == pytest.approx(0.45 * 0.5)


@pytest.mark.parametrize("stage", [FLAT, SPACE])
def test_stage_puts_the_longest_side_on_its_length_and_comes_back(stage):
    size = np.array(stage.size)
    assert stage.to_display(0.5 * size).tolist() == [0.0, 0.0, 0.0]
    assert 2.0 * stage.half.max() == DISPLAY_SIDE[stage.dim]
    assert stage.to_display(size) == pytest.approx(stage.half)
    assert stage.to_display(np.zeros(stage.dim)) == pytest.approx(-stage.half)
    position = np.random.default_rng(1).random((50, stage.dim)) * size
    assert stage.world(stage.to_display(position)) == pytest.approx(position)
    if stage.dim == 2:
        assert np.all(stage.to_display(position)[:, 2] == 0.0)


def test_stage_period_is_finite_only_where_the_world_wraps():
    assert FLAT.period.tolist() == [10.0, np.inf, np.inf]
    assert SPACE.period == pytest.approx([2.0, 4.0, 8.0])


def test_nearest_image_is_never_farther_than_half_a_period():
    period = np.array([10.0, 4.0, np.inf])
    step = np.random.default_rng(2).uniform(-1, 1, (500, 3)) * np.array([9.9, 3.9, 50.0])
    near = nearest_image(step, period)
    assert np.all(np.abs(near[:, :2]) <= 0.5 * period[:2])
    assert np.array_equal(near[:, 2], step[:, 2])
    turns = (step - near)[:, :2] / period[:2]
    assert turns == pytest.approx(np.rint(turns), abs=1e-12)


def test_a_line_within_the_box_stays_whole():
    start, end = np.array([[0.0, 0.0, 0.0]]), np.array([[1.0, 2.0, 0.0]])
    assert split_at_seams(start, end, FLAT.period).tolist() == [[[0, 0, 0], [1, 2, 0]]]


def test_a_line_through_the_seam_becomes_two_that_meet_there():
    start, end = np.array([[4.0, 1.0, 0.0]]), np.array([[-4.0, 2.0, 0.0]])
    first, second = split_at_seams(start, end, FLAT.period)
    assert first == pytest.approx(np.array([[4.0, 1.0, 0.0], [5.0, 1.5, 0.0]]))
    assert second == pytest.approx(np.array([[-4.0, 2.0, 0.0], [-5.0, 1.5, 0.0]]))


def test_no_line_leaves_the_box_or_is_longer_than_the_short_way_round():
    rng = np.random.default_rng(3)
    start, end = (rng.uniform(-1, 1, (400, 3)) * SPACE.half for _ in range(2))
    lines = split_at_seams(start, end, SPACE.period)
    assert np.all(np.abs(lines) <= SPACE.half + 1e-9)
    assert np.all(np.abs(lines[:, 1] - lines[:, 0]) <= 0.5 * SPACE.period + 1e-9)


def test_jumps_are_moves_of_more_than_half_a_period():
    before = np.array([[4.9, 0.0, 0.0], [4.9, 3.0, 0.0], [0.0, 3.9, 0.0]])
    after = np.array([[-4.9, 0.0, 0.0], [4.7, 3.0, 0.0], [0.0, -3.9, 0.0]])
    assert jumps(before, after, FLAT.period).tolist() == [True, False, False]
