"""The inspected agent: a ring round it, lines to those it listens to, and how far it senses.

Where its rule has zones, `zones.ZoneMarks` draws these instead of the lines and the reach.
"""

from __future__ import annotations

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture, shares
from app.viewer.scene.draw.line_segments import add_lines, segments
from app.viewer.scene.draw.seam import split_at_seams
from app.viewer.scene.draw.shapes import circle, great_circles, ring
from app.viewer.scene.shown import palette, tone

_CLASSES = ((0.0, 0.34, 1.2), (0.34, 0.67, 2.2), (0.67, 1.01, 3.6))
"""Lines by share of the largest weight: from, below, pixels."""


class InspectionMarks:
    """Marks that follow `Frame.inspected`."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._ring = scene.add_mesh_simple(
            f"{root}/inspected/ring",
            *ring(0.90),
            color=tone.single(palette.SELECTED, tone.LIGHT),
            side="double",
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )
        self._heard = [
            add_lines(scene, f"{root}/inspected/heard/{number}", thickness)
            for number, (_, _, thickness) in enumerate(_CLASSES)
        ]
        self._rim = add_lines(scene, f"{root}/inspected/rim", thickness=1.4)
        self._disc = scene.add_mesh_simple(
            f"{root}/inspected/disc",
            *ring(0.0, corners=128),
            color=tone.single(palette.PLAIN, tone.LIGHT),
            opacity=0.10,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )
        self._ball = scene.add_icosphere(
            f"{root}/inspected/ball",
            radius=1.0,
            color=tone.single(palette.PLAIN, tone.LIGHT),
            opacity=0.08,
            subdivisions=5,
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )

    def draw(self, picture: Picture) -> Changes:
        row, seen = picture.inspected, picture.frame.inspected
        zoned = picture.look.zones and seen is not None and len(seen.shells) > 0
        changes = self._draw_ring(picture, row)
        changes += self._draw_heard(picture, None if zoned else row)
        centre = None if zoned else row
        if row is None and picture.look.reach:
            centre = picture.leader
        return changes + self._draw_reach(picture, centre)

    def _draw_ring(self, picture: Picture, row: int | None) -> Changes:
        if row is None:
            return [(self._ring, "visible", False)]
        return [
            (self._ring, "position", picture.at[row]),
            (self._ring, "wxyz", picture.wxyz[row]),
            (self._ring, "scale", 0.8 * picture.length * float(picture.size[row])),
            (self._ring, "visible", True),
        ]

    def _draw_heard(self, picture: Picture, row: int | None) -> Changes:
        inspected = picture.frame.inspected
        if row is None or inspected is None or not len(inspected.neighbours):
            return [(lines, "visible", False) for lines in self._heard]
        weight = shares(inspected.weights)
        end = picture.at[inspected.neighbours]
        start = np.broadcast_to(picture.at[row], end.shape)
        changes: Changes = []
        for lines, (least, below, _) in zip(self._heard, _CLASSES, strict=True):
            mine = (weight >= least) & (weight < below)
            points = split_at_seams(start[mine], end[mine], picture.stage.period)
            colour = picture.mixed(palette.SELECTED, 0.45 - 0.35 * least)
            changes += segments(lines, points, tone.single(colour))
        return changes

    def _draw_reach(self, picture: Picture, row: int | None) -> Changes:
        radius = float(picture.frame.reach) * picture.stage.scale
        if row is None or not np.isfinite(radius) or radius <= 0.0:
            return [(node, "visible", False) for node in (self._rim, self._disc, self._ball)]
        centre = picture.at[row]
        flat = picture.stage.dim == 2
        if flat:
            centre = np.array([centre[0], centre[1], 0.012])
        rim = radius * (circle() if flat else great_circles())
        changes = segments(self._rim, rim, tone.single(palette.PLAIN))
        changes.append((self._rim, "position", centre))
        for node, shown in ((self._disc, flat), (self._ball, not flat)):
            changes += [(node, "visible", shown), (node, "position", centre)]
            changes.append((node, "scale", radius))
        return changes
