"""Lines between neighbours."""

from __future__ import annotations

import numpy as np
from viser import BatchedMeshHandle, SceneApi

from app.viewer.scene.draw.attitude import (
    ahead_directions,
    left_directions,
    quantise_attitudes,
    rounded_places,
)
from app.viewer.scene.draw.drawn_frame import DIMMED, FEW_LEADERS, Changes, Picture
from app.viewer.scene.draw.line_segments import add_lines, segments, split_at_seams
from app.viewer.scene.draw.shapes import Mesh, ball, circle, ring, torus
from app.viewer.scene.marks.mission_marks import floor_places
from app.viewer.scene.shown import palette

# Where agents have crashed: a ring and a cross, and in space a line down; they fade with time.

MOST_CRASHES = 80
"""Only so many of the latest crashes are marked."""
FADES = 100
"""Time in which a mark fades, ticks; a pale one stays."""
PALEST = 0.72
"""Share of the backdrop in the colour of a mark that has faded."""
DROP = 0.68
"""The same of the line down from a new one, which vanishes."""
RADIUS, RADIUS_CAR = 0.55, 0.95
"""Of the ring, as a multiple of an agent's length, and of a car's."""


class CrashMarks:
    """Marks at the places, drawn of the latest crashes."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._lines = add_lines(scene, f"{root}/flock/crashes", thickness=1.5, many_coloured=True)

    def draw(self, picture: Picture) -> Changes:
        crashes = picture.frame.crashes
        if crashes is None or not len(crashes):
            return [(self._lines, "visible", False)]
        at = floor_places(picture, crashes.place[-MOST_CRASHES:])
        age = np.clip((picture.frame.tick - crashes.tick[-MOST_CRASHES:]) / FADES, 0.0, 1.0)
        radius = RADIUS_CAR if picture.as_cars else RADIUS
        sign = radius * picture.length * crossed_ring()
        lines = [(at[:, None, None, :] + sign).reshape(-1, 2, 3)]
        colours = [np.repeat(faded_colours(picture, PALEST * age), len(sign), axis=0)]
        if picture.stage.dim == 3:
            fresh = age < 1.0
            foot = at.copy()
            foot[:, 2] = picture.stage.floor
            lines.append(np.stack([at, foot], axis=1)[fresh])
            colours.append(faded_colours(picture, DROP + (1.0 - DROP) * age[fresh]))
        ends = np.repeat(np.concatenate(colours)[:, None], 2, axis=1)
        return segments(self._lines, np.concatenate(lines), ends)


def faded_colours(picture: Picture, share: np.ndarray) -> np.ndarray:
    """The colour of a mark with shares (M,) of the backdrop, bytes (M, 3)."""
    return palette.unlit_bytes(picture.mix_with_backdrop(palette.CRASH, share[:, None]))


def crossed_ring() -> np.ndarray:
    """A level ring of radius 1 with a cross in it, as line segments (K, 2, 3)."""
    half = 0.5 * np.sqrt(0.5)
    cross = half * np.array([[[-1.0, -1, 0], [1, 1, 0]], [[-1, 1, 0], [1, -1, 0]]])
    return np.concatenate([circle(20), cross])


# What sets the information agents apart: a golden ring, and in space a bubble around them.


class Halos:
    """A flat ring is crisp from above but vanishes edge-on; a torus and a bubble do not."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._flat = _add(scene, f"{root}/flock/halos/flat", ring(0.86), 1.5, opacity=None)
        self._round = _add(scene, f"{root}/flock/halos/round", torus(), palette.LIGHT, opacity=None)
        self._bubble = _add(scene, f"{root}/flock/halos/bubble", ball(), 1.0, opacity=0.22)

    def draw(self, picture: Picture) -> Changes:
        rows = np.flatnonzero(picture.frame.informed)
        worn = 0 < len(rows) <= FEW_LEADERS
        flat = picture.stage.dim == 2
        changes: Changes = []
        for halo, is_shown in (
            (self._flat, flat),
            (self._round, not flat),
            (self._bubble, not flat),
        ):
            if worn and is_shown:
                changes += _around(picture, rows, halo)
            changes.append((halo, "visible", worn and is_shown))
        return changes


def _around(picture: Picture, rows: np.ndarray, halo: BatchedMeshHandle) -> Changes:
    radius = 0.85 * picture.length * picture.size[rows]
    return [
        (halo, "batched_positions", rounded_places(picture.at[rows], picture.length)),
        (halo, "batched_wxyzs", quantise_attitudes(picture.wxyz[rows])),
        (halo, "batched_scales", radius.astype(np.float32)),
    ]


def _add(
    scene: SceneApi, name: str, mesh: Mesh, light: float, opacity: float | None
) -> BatchedMeshHandle:
    return scene.add_batched_meshes_simple(
        name,
        *mesh,
        batched_wxyzs=np.array([[1.0, 0.0, 0.0, 0.0]]),
        batched_positions=np.zeros((1, 3)),
        batched_scales=np.ones(1),
        batched_colors=palette.lit_bytes(palette.HALO, light),
        opacity=opacity,
        side="double" if opacity is None else "front",
        lod="off",
        cast_shadow=False,
        receive_shadow=False,
        visible=False,
    )


# Who is not seen just now: the outline of a dart where it was seen last.

OUTLINE = np.array([[0.60, 0.0], [-0.40, 0.36], [-0.13, 0.0], [-0.40, -0.36]])
"""Nose, left wing tip, notch and right wing tip: how far ahead and to the left, of one of length
1."""
THICK = 1.6
"""Width of an outline, pixels."""


class HollowMarks:
    """Outlines of individuals of tracks that are in a gap, or over which a model is drawn."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._lines = add_lines(scene, f"{root}/flock/hollow", THICK, many_coloured=True)

    def draw(self, picture: Picture) -> Changes:
        outlined = picture.frame.outlined
        rows = np.empty(0, int) if outlined is None else np.flatnonzero(outlined)
        if not len(rows):
            return [(self._lines, "visible", False)]
        wxyz = picture.wxyz[rows]
        size = (picture.length * picture.size[rows])[:, None, None]
        ahead, left = ahead_directions(wxyz)[:, None], left_directions(wxyz)[:, None]
        points = picture.at[rows][:, None] + size * (
            OUTLINE[None, :, :1] * ahead + OUTLINE[None, :, 1:] * left
        )
        lines = np.stack([points, np.roll(points, -1, axis=1)], axis=2).reshape(-1, 2, 3)
        colours = np.repeat(palette.unlit_bytes(picture.colour[rows]), len(OUTLINE), axis=0)
        return segments(self._lines, lines, np.repeat(colours[:, None], 2, axis=1))


MOST_LINKS = 12_000


class Links:
    """Thin lines; of very many pairs a fair and steady sample is drawn."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._lines = add_lines(scene, f"{root}/flock/links", thickness=1.0)

    def draw(self, picture: Picture) -> Changes:
        pairs = picture.frame.links
        if not picture.look.links or pairs is None or not len(pairs):
            return [(self._lines, "visible", False)]
        pairs = sample(pairs[np.all(pairs < len(picture.at), axis=1)], MOST_LINKS)
        at = picture.at
        points = split_at_seams(at[pairs[:, 0]], at[pairs[:, 1]], picture.stage.period)
        faint = 0.55 if picture.frame.inspected is not None else 0.25 * (len(pairs) > 2_000)
        colour = picture.mix_with_backdrop(palette.LINK, min(faint, DIMMED))
        return segments(self._lines, points, palette.node_colour(colour))


def sample(pairs: np.ndarray, most: int) -> np.ndarray:
    """About `most` of the pairs (M, 2), chosen by the pair itself: a kept one stays, no flicker."""
    if len(pairs) <= most:
        return pairs
    low, high = np.sort(pairs.astype(np.uint64), axis=1).T
    mixed = (low * np.uint64(0x9E3779B97F4A7C15)) ^ (high * np.uint64(0xC2B2AE3D27D4EB4F))
    mixed = (mixed ^ (mixed >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9)
    return pairs[(mixed >> np.uint64(44)) < np.uint64(2**20 * most // len(pairs))]
