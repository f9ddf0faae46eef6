"""The field of view of the inspected agent and the zones of its rule, as translucent shells.

In space a zone is the dome that closes it, cut off where the agent sees no more; in the plane it
is a ring sector. What lies outside of the field of view is grey.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from viser import SceneApi

from agents.inspection import UNSEEN, Inspection
from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.line_segments import add_lines, segments, split_at_seams
from app.viewer.scene.draw.shapes import Mesh
from app.viewer.scene.shown import palette

# Shapes of what an agent notices, about its nose on +x and of radius 1.

AROUND, ALONG = 64, 40
"""Facets of a dome round the nose, and from the nose to the back of a whole one."""


def dome(half: float, start: float = 0.0) -> Mesh:
    """The part of the sphere from `start` to `half` (rad, up to pi) off the nose, facing out."""
    rows = max(2, int(np.ceil(ALONG * (half - start) / np.pi)) + 1)
    off = np.linspace(start, half, rows)[None, :, None]
    turn = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)[:, None, None]
    across = np.concatenate([0.0 * turn, np.cos(turn), np.sin(turn)], axis=2)
    vertices = np.cos(off) * np.array([1.0, 0.0, 0.0]) + np.sin(off) * across
    return vertices.reshape(-1, 3), _strips(AROUND, rows)


def cone(half: float) -> Mesh:
    """The side of the cone from the middle to the sphere's circle at `half` (rad) off the nose."""
    turn = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    rim = np.column_stack(
        [
            np.full(AROUND, np.cos(half)),
            np.sin(half) * np.cos(turn),
            np.sin(half) * np.sin(turn),
        ]
    )
    index = np.arange(AROUND)
    faces = np.column_stack([np.zeros(AROUND, int), 1 + (index + 1) % AROUND, 1 + index])
    return np.concatenate([np.zeros((1, 3)), rim]), faces


def sector(inner: float, start: float, half: float) -> Mesh:
    """A flat ring from radius `inner` to 1, between `start` and `half` (rad) off the nose on both
    sides, facing up."""
    count = max(2, int(np.ceil(96 * (half - start) / np.pi)) + 1)
    off = np.linspace(start, half, count)
    vertices: list[np.ndarray] = []
    faces: list[np.ndarray] = []
    for side in (1, -1):
        spoke = np.column_stack([np.cos(off), side * np.sin(off), np.zeros(count)])
        first = 2 * len(vertices) * count
        here, outer = first + np.arange(count - 1), first + count + np.arange(count - 1)
        quads = [
            np.column_stack([here, outer, outer + 1]),
            np.column_stack([here, outer + 1, here + 1]),
        ]
        faces += [quad[:, ::side] for quad in quads]
        vertices.append(np.concatenate([inner * spoke, spoke]))
    return np.concatenate(vertices), np.concatenate(faces)


def arc(half: float) -> np.ndarray:
    """The arc from -half to +half (rad) off the nose in the plane z = 0, segments (K, 2, 3)."""
    count = max(2, int(np.ceil(128 * half / np.pi)))
    off = np.linspace(-half, half, count + 1)
    points = np.column_stack([np.cos(off), np.sin(off), np.zeros(count + 1)])
    return np.stack([points[:-1], points[1:]], axis=1)


def arcs(half: float) -> np.ndarray:
    """Two arcs across the nose, level and upright, and the circle where they end, (K, 2, 3)."""
    level = arc(half)
    lines = [level, level[..., [0, 2, 1]]]
    if half < np.pi:
        turn = np.linspace(0.0, 2.0 * np.pi, AROUND + 1)
        rim = np.column_stack(
            [
                np.full(AROUND + 1, np.cos(half)),
                np.sin(half) * np.cos(turn),
                np.sin(half) * np.sin(turn),
            ]
        )
        lines.append(np.stack([rim[:-1], rim[1:]], axis=1))
    return np.concatenate(lines)


def spokes(half: float, flat: bool) -> np.ndarray:
    """Lines from the middle to the edge of what is seen, (K, 2, 3): two, in space four."""
    c, s = np.cos(half), np.sin(half)
    ends = [[c, s, 0.0], [c, -s, 0.0]] + ([] if flat else [[c, 0.0, s], [c, 0.0, -s]])
    return np.stack([np.zeros((len(ends), 3)), np.array(ends)], axis=1)


def _strips(around: int, rows: int) -> np.ndarray:
    """Triangles over a grid of vertices (around, rows), closed along its first axis."""
    i, j = (part.ravel() for part in np.meshgrid(range(around), range(rows - 1), indexing="ij"))
    corner, neighbour = i * rows + j, ((i + 1) % around) * rows + j
    return np.concatenate(
        [
            np.column_stack([corner, corner + 1, neighbour + 1]),
            np.column_stack([corner, neighbour + 1, neighbour]),
        ]
    )


OPACITY = {2: (0.34, 0.26, 0.17), 3: (0.26, 0.19, 0.10)}
"""Of the zones from the inside out, by dimension; that of what is not seen is BLIND."""
BLIND = {2: 0.14, 3: 0.10}
LOW = 0.012
"""Height above a flat floor."""


class ZoneMarks:
    """Rebuilt when radii or the field of view change; else only moved."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._scene = scene
        self._name = f"{root}/inspected/zones"
        self._built: tuple[Any, ...] | None = None
        self._nodes: list[Any] = []
        self._edges = add_lines(scene, f"{self._name}/edges", 1.8, many_coloured=True)
        self._noticed = add_lines(
            scene, f"{root}/inspected/noticed", thickness=1.3, many_coloured=True
        )

    def draw(self, picture: Picture) -> Changes:
        row, inspection = picture.inspected, picture.frame.inspected
        if row is None or inspection is None or not inspection.shells or not picture.look.zones:
            nodes = (*self._nodes, self._edges, self._noticed)
            return [(node, "visible", False) for node in nodes]
        at = picture.at[row]
        if picture.stage.dim == 2:
            at = np.array([at[0], at[1], LOW])
        changes: Changes = []
        key = (inspection.shells, inspection.view, picture.stage)
        if key != self._built:
            self._built = key
            changes += self._build(picture, inspection)
        for node in (*self._nodes, self._edges):
            changes += [
                (node, "position", at),
                (node, "wxyz", picture.wxyz[row]),
                (node, "visible", True),
            ]
        return changes + self._draw_counted(picture, row, inspection)

    def _build(self, picture: Picture, inspection: Inspection) -> Changes:
        """Make the shells anew, the inner ones first: so they are drawn first too."""
        for node in self._nodes:
            node.remove()
        self._nodes = []
        flat, scale = picture.stage.dim == 2, picture.stage.scale
        half = np.deg2rad(0.5 * min(inspection.view, 360.0))
        colours = palette.zone_colours(np.arange(len(inspection.shells)))
        inner, lines, line_colours = 0.0, [], []
        for index, (shell, colour) in enumerate(zip(inspection.shells, colours, strict=True)):
            if shell.radius <= inner:
                continue
            angle = np.pi if shell.all_round else half
            mesh = sector(inner / shell.radius, 0.0, angle) if flat else dome(angle)
            opacity = OPACITY[picture.stage.dim][min(index, 2)]
            self._add(mesh, shell.radius * scale, colour, opacity)
            points = shell.radius * scale * (arc(angle) if flat else arcs(angle))
            lines.append(points)
            line_colours.append(np.broadcast_to(palette.unlit_bytes(colour), points.shape))
            inner = shell.radius
        if half < np.pi and inner > 0.0:
            self._draw_view_edge(inspection, flat, half, inner * scale)
            points = inner * scale * spokes(half, flat)
            lines.append(points)
            line_colours.append(np.broadcast_to(palette.unlit_bytes(palette.BLIND), points.shape))
        empty = np.empty((0, 2, 3))
        return segments(
            self._edges, np.concatenate([empty, *lines]), np.concatenate([empty, *line_colours])
        )

    def _draw_view_edge(
        self, inspection: Inspection, flat: bool, half: float, radius: float
    ) -> None:
        """The side of the cone that is seen, or of the blind one behind, which is closed."""
        if flat:
            inner = max(
                (shell.radius for shell in inspection.shells if shell.all_round), default=0.0
            )
            outer = max(shell.radius for shell in inspection.shells)
            self._add(sector(inner / outer, half, np.pi), radius, palette.BLIND, BLIND[2])
            return
        self._add(cone(half), radius, palette.BLIND, BLIND[3])
        if half > 0.5 * np.pi:
            self._add(dome(np.pi, half), radius, palette.BLIND, BLIND[3])

    def _add(self, mesh: Mesh, radius: float, colour: np.ndarray, opacity: float) -> None:
        vertices, faces = mesh
        # Translucent things are drawn by how far the middles of their boxes are away: with two
        # corners that no facet uses all these are the agent's place, and the order is as made.
        vertices = np.concatenate([vertices, [[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]])
        self._nodes.append(
            self._scene.add_mesh_simple(
                f"{self._name}/{len(self._nodes)}",
                radius * vertices,
                faces,
                color=palette.node_colour(colour, palette.LIGHT),
                opacity=opacity,
                side="double",
                visible=False,
                cast_shadow=False,
                receive_shadow=False,
            )
        )

    def _draw_counted(self, picture: Picture, row: int, inspection: Inspection) -> Changes:
        """Lines to those that count now, in the colours of their zones."""
        is_heard = (inspection.zone != UNSEEN) & (inspection.weights > 0.0)
        end = picture.at[inspection.neighbours[is_heard]]
        start = np.broadcast_to(picture.at[row], end.shape)
        zones = inspection.zone[is_heard]
        points, colours = [np.empty((0, 2, 3))], [np.empty((0, 2, 3), np.uint8)]
        for zone in np.unique(zones):
            mine = zones == zone
            lines = split_at_seams(start[mine], end[mine], picture.stage.period)
            colour = picture.mix_with_backdrop(palette.ZONES[zone % len(palette.ZONES)], 0.25)
            points.append(lines)
            colours.append(np.broadcast_to(palette.unlit_bytes(colour), lines.shape))
        return segments(self._noticed, np.concatenate(points), np.concatenate(colours))
