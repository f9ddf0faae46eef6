"""The inspected agent: a ring round it, lines to those it listens to, and how far it senses.

Where its rule has zones, `zones.ZoneMarks` draws these instead of the lines and the reach.
"""

from __future__ import annotations

import numpy as np
from viser import LabelHandle, SceneApi

from agents.inspection import Inspection
from app.viewer.scene.draw.drawn_frame import Changes, Picture, shares
from app.viewer.scene.draw.line_segments import add_lines, segments, split_at_seams
from app.viewer.scene.draw.shapes import circle, dashes, great_circles, ring
from app.viewer.scene.marks.mission_marks import ABOVE, floor_places
from app.viewer.scene.marks.obstacle_marks import drawn_height, rim_places
from app.viewer.scene.shown import palette

# Why the inspected agent moves as it does: forces as arrows, what it perceives and heads for.

LONGEST, LENGTHS = 0.085, 3.5
"""Length of the strongest force's arrow: so many longest sides, or agents, whichever is less."""
WEAKEST = 0.02
"""Forces weaker than this share of the strongest have no arrow."""
SHAFT = 0.026
"""Radius of an arrow's shaft as a multiple of the strongest force's length."""


class ReasonMarks:
    """Arrows, dots and words that follow `Frame.inspected`."""

    def __init__(self, scene: SceneApi, root: str = "", still: str | None = None) -> None:
        """`still`: what the places are below, where `root` is moved about with the agent."""
        self._scene = scene
        name = f"{root}/inspected"
        self._still = f"{root if still is None else still}/inspected"
        nothing = np.zeros((1, 2, 3), dtype=np.float32)
        self._arrows = scene.add_arrows(
            f"{name}/forces", nothing, np.zeros((1, 3), dtype=np.uint8), visible=False
        )
        self._seen = scene.add_point_cloud(
            f"{self._still}/points",
            nothing[0],
            palette.node_colour(palette.POINT),
            point_shape="circle",
            point_shading="flat",
            precision="float32",
            visible=False,
        )
        self._aim = add_lines(scene, f"{self._still}/aim", thickness=2.0)
        self._words: dict[str, LabelHandle] = {}
        self._dots = scene.add_point_cloud(
            f"{self._still}/places",
            nothing[0],
            palette.node_colour(palette.SELECTED),
            point_shape="circle",
            point_shading="flat",
            precision="float32",
            visible=False,
        )

    def draw(self, picture: Picture) -> Changes:
        """Draw what is known of the inspected agent."""
        row, inspection = picture.inspected, picture.frame.inspected
        if row is None or inspection is None:
            nodes = (self._arrows, self._seen, self._aim, self._dots, *self._words.values())
            return [(node, "visible", False) for node in nodes]
        return [
            *self._draw_forces(picture, row, inspection),
            *self._draw_boundary_points(picture, inspection),
            *self._draw_places(picture, row, inspection),
        ]

    def _draw_forces(self, picture: Picture, row: int, inspection: Inspection) -> Changes:
        ends, colour = arrows(inspection.forces)
        if not len(ends):
            return [(self._arrows, "visible", False)]
        longest = min(LONGEST * picture.stage.side, LENGTHS * picture.length)
        at = picture.at[row]
        if picture.stage.dim == 2:
            at = at + np.array([0.0, 0.0, 0.35 * picture.length])
        points = np.stack([np.broadcast_to(at, ends.shape), at + longest * ends], axis=1)
        return [
            (self._arrows, "points", points.astype(np.float32)),
            (self._arrows, "colors", palette.lit_bytes(colour)),
            (self._arrows, "shaft_radius", SHAFT * longest),
            (self._arrows, "head_radius", 2.6 * SHAFT * longest),
            (self._arrows, "head_length", 7.0 * SHAFT * longest),
            (self._arrows, "visible", True),
        ]

    def _draw_boundary_points(self, picture: Picture, inspection: Inspection) -> Changes:
        if not len(inspection.points):
            return [(self._seen, "visible", False)]
        stage, world = picture.stage, picture.frame.world
        spacing = world.boundary_spacing * stage.scale
        return [
            (self._seen, "points", rim_places(picture, inspection.points, drawn_height(world))),
            (self._seen, "point_size", min(0.0028 * stage.side, 0.35 * spacing)),
            (self._seen, "visible", True),
        ]

    def _draw_places(self, picture: Picture, row: int, inspection: Inspection) -> Changes:
        places = remembered_places(inspection)
        for place in places.keys() - self._words.keys():
            self._words[place] = self._scene.add_label(
                f"{self._still}/words/{place}",
                place,
                anchor="bottom-center",
                font_screen_scale=0.85,
                visible=False,
            )
        changes: Changes = [
            (label, "visible", place in places) for place, label in self._words.items()
        ]
        if not places:
            return [*changes, (self._aim, "visible", False), (self._dots, "visible", False)]
        side = picture.stage.side
        lift = np.array([0.0, 0.0, picture.length])
        shown_places = {
            place: floor_places(picture, at[None])[0] + lift for place, at in places.items()
        }
        aim = shown_places[inspection.places[-1]]
        aim[2] = drawn_height(picture.frame.world) * picture.stage.scale + ABOVE
        for place, at in shown_places.items():
            changes.append(
                (self._words[place], "position", at + np.array([0.0, 0.012 * side, 0.0]))
            )
        dash = 0.006 * side
        lines, _ = dashes(np.array([picture.at[row], aim]), dash, dash)
        return [
            *changes,
            *segments(self._aim, lines, palette.node_colour(palette.SELECTED)),
            (self._dots, "points", np.array([*shown_places.values()], np.float32)),
            (self._dots, "point_size", 0.004 * side),
            (self._dots, "visible", True),
        ]


def arrows(forces: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Forces as shares of the strongest, (K, 3), and their colours, (K, 3); weak ones left out."""
    if not forces:
        return np.empty((0, 3)), np.empty((0, 3))
    vectors = np.array([*forces.values()], float)
    length = np.linalg.norm(vectors, axis=1)
    strongest = float(length.max())
    if not (np.isfinite(strongest) and strongest > 0.0):
        return np.empty((0, 3)), np.empty((0, 3))
    ends = np.zeros((len(vectors), 3))
    ends[:, : vectors.shape[1]] = vectors / strongest
    is_strong = length >= WEAKEST * strongest
    return ends[is_strong], force_colours(len(vectors))[is_strong]


def force_colours(count: int) -> np.ndarray:
    """Colours (count, 3) of an agent's forces, in order."""
    return palette.FORCES[np.arange(count) % len(palette.FORCES)]


def remembered_places(inspection: Inspection) -> dict[str, np.ndarray]:
    """The places (2,) that an agent has in mind; those that it does not know yet are left out."""
    places: dict[str, np.ndarray] = {}
    for place in inspection.places if inspection.minds else ():
        at = np.array([inspection.signals[f"{place}_x"], inspection.signals[f"{place}_y"]])
        is_new = at.any() and not any(np.array_equal(at, other) for other in places.values())
        if is_new or place in (inspection.places[0], inspection.places[-1]):
            places[place] = at
    return places


_CLASSES = ((0.0, 0.34, 1.2), (0.34, 0.67, 2.2), (0.67, 1.01, 3.6))
"""Lines by share of the largest weight: from, below, pixels."""


class InspectionMarks:
    """Marks that follow `Frame.inspected`."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._ring = scene.add_mesh_simple(
            f"{root}/inspected/ring",
            *ring(0.90),
            color=palette.node_colour(palette.SELECTED, palette.LIGHT),
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
            color=palette.node_colour(palette.PLAIN, palette.LIGHT),
            opacity=0.10,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )
        self._ball = scene.add_icosphere(
            f"{root}/inspected/ball",
            radius=1.0,
            color=palette.node_colour(palette.PLAIN, palette.LIGHT),
            opacity=0.08,
            subdivisions=5,
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )

    def draw(self, picture: Picture) -> Changes:
        row, inspection = picture.inspected, picture.frame.inspected
        zoned = picture.look.zones and inspection is not None and len(inspection.shells) > 0
        changes = self._draw_ring(picture, row)
        changes += self._draw_neighbours(picture, None if zoned else row)
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

    def _draw_neighbours(self, picture: Picture, row: int | None) -> Changes:
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
            colour = picture.mix_with_backdrop(palette.SELECTED, 0.45 - 0.35 * least)
            changes += segments(lines, points, palette.node_colour(colour))
        return changes

    def _draw_reach(self, picture: Picture, row: int | None) -> Changes:
        reach, reaches = picture.frame.reach, picture.frame.reaches
        if row is not None and reaches is not None:
            reach = reaches[row]
        radius = float(reach) * picture.stage.scale
        if row is None or not np.isfinite(radius) or radius <= 0.0:
            return [(node, "visible", False) for node in (self._rim, self._disc, self._ball)]
        centre = picture.at[row]
        flat = picture.stage.dim == 2
        if flat:
            centre = np.array([centre[0], centre[1], 0.012])
        rim = radius * (circle() if flat else great_circles())
        changes = segments(self._rim, rim, palette.node_colour(palette.PLAIN))
        changes.append((self._rim, "position", centre))
        for node, is_shown in ((self._disc, flat), (self._ball, not flat)):
            changes += [(node, "visible", is_shown), (node, "position", centre)]
            changes.append((node, "scale", radius))
        return changes
