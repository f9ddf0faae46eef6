"""The boundary points of what is solid, as small dots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.shapes import ball
from app.viewer.scene.draw.solids import join_meshes, prism, rims, uprights
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.shown import palette
from worlds.queries.outlines import footprints
from worlds.world import World

# The obstacles of a world: upright solids with a fine line along their edges, and spheres.

TALLEST = 0.05
"""Height of what stands in a flat world as a multiple of its longest side, at most: from above,
what is taller would lean over the agents beside it."""
LIGHT = 1.45
"""Light on a surface turned up to the sun, as a multiple of its own colour."""
BALL = ball(96, 48)
REST, ONE = "rest", "one"
PIECES = tuple(f"{piece}/{part}" for piece in (REST, ONE) for part in ("solid", "edges", "spheres"))
"""All that may be drawn of obstacles, by the end of its name."""


class Obstacles:
    """Sent once; when the world changes, only what is different is sent again.

    An obstacle that was changed or added last is a node of its own, so that one that is dragged
    about is sent alone.
    """

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._world: World | None = None
        self._stage: Stage | None = None
        self._rest = Piece(scene, f"{root}/world/obstacles/{REST}")
        self._one = Piece(scene, f"{root}/world/obstacles/{ONE}")
        self._apart: int | None = None
        """Which obstacle is a node of its own."""

    def draw(self, picture: Picture) -> Changes:
        """Bring the nodes up to date; nothing in them has to change from frame to frame."""
        world, stage = picture.frame.world, picture.stage
        if world is self._world and stage == self._stage:
            return []
        before = self._world if stage == self._stage else None
        self._world, self._stage = world, stage
        if before is not None and before.obstacles == world.obstacles:
            if before.height == world.height:
                return []
            before = None
        changed_index = None if before is None else find_changed(before.obstacles, world.obstacles)
        if changed_index is None or changed_index != self._apart:
            rest = [each for k, each in enumerate(world.obstacles) if k != changed_index]
            self._rest.draw(rest, world, stage)
        self._one.draw(
            [] if changed_index is None else [world.obstacles[changed_index]], world, stage
        )
        self._apart = changed_index
        return []


class Piece:
    """Some of the obstacles, drawn as one."""

    def __init__(self, scene: SceneApi, name: str) -> None:
        self._scene = scene
        self._name = name
        self._nodes: list[Any] = []

    def remove(self) -> None:
        """Draw none."""
        for node in self._nodes:
            node.remove()
        self._nodes = []

    def draw(
        self,
        obstacles: Sequence[Any],
        world: World,
        stage: Stage,
        opacity: float | None = None,
    ) -> None:
        """Draw these obstacles of a world instead of those before."""
        self.remove()
        spheres = [sphere for each in obstacles for sphere in each.spheres()]
        if spheres and stage.dim == 3:
            self._add_spheres(spheres, stage, opacity)
        solids = footprints(replace(world, obstacles=tuple(obstacles)))
        if solids:
            self._add_prisms(solids, world, stage, opacity)

    def _add_prisms(self, solids: dict, world: World, stage: Stage, opacity: float | None) -> None:
        """Those that stand upright: one mesh, and the lines along their edges."""
        meshes, lines = [], []
        for (bottom, top), outline in solids.items():
            low, high = (bottom, top) if stage.dim == 3 else (0.0, drawn_height(world))
            meshes.append(prism(outline, low, high))
            lines += [rims(outline, high), uprights(outline, low, high)]
            if stage.dim == 3:
                lines.append(rims(outline, low))
        vertices, faces = join_meshes(meshes)
        self._nodes += [
            self._scene.add_mesh_simple(
                f"{self._name}/solid",
                stage.place_on_display(vertices).astype(np.float32),
                faces.astype(np.uint32),
                color=palette.node_colour(palette.SOLID, LIGHT),
                opacity=opacity,
                flat_shading=True,
            ),
            self._scene.add_line_segments(
                f"{self._name}/edges",
                stage.place_on_display(np.concatenate(lines)).astype(np.float32),
                palette.node_colour(palette.SOLID_EDGE),
                thickness=1.3,
                thickness_units="screen",
            ),
        ]

    def _add_spheres(self, spheres: list, stage: Stage, opacity: float | None) -> None:
        centre = stage.to_display(np.array([place for place, _ in spheres]))
        radius = stage.scale * np.array([radius for _, radius in spheres])
        self._nodes.append(
            self._scene.add_batched_meshes_simple(
                f"{self._name}/spheres",
                *BALL,
                batched_wxyzs=np.tile([1.0, 0.0, 0.0, 0.0], (len(spheres), 1)),
                batched_positions=centre.astype(np.float32),
                batched_scales=radius.astype(np.float32),
                batched_colors=palette.lit_bytes(palette.SOLID, LIGHT),
                opacity=opacity,
                lod="off",
            )
        )


def drawn_height(world: World) -> float:
    """How tall the obstacles of a flat world are drawn, length."""
    return min(world.height, TALLEST * max(world.size))


def find_changed(before: Sequence[Any], now: Sequence[Any]) -> int | None:
    """Which obstacle alone is different now, or has been added at the end; None if it is not one.

    >>> find_changed("abc", "axc"), find_changed("ab", "abc"), find_changed("abc", "ab")
    (1, 2, None)
    """
    if len(now) not in (len(before), len(before) + 1):
        return None
    differ = [k for k, (old, new) in enumerate(zip(before, now, strict=False)) if old != new]
    added = [len(before)] if len(now) > len(before) else []
    return (differ + added)[0] if len(differ + added) == 1 else None


DIAMETER = 0.0024
"""Of a dot, as a multiple of the longest side; less where they would run into each other."""


class BoundaryPointMarks:
    """Sent when they are switched on or the world changes."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._dots = scene.add_point_cloud(
            f"{root}/world/points",
            np.zeros((1, 3), dtype=np.float32),
            palette.node_colour(palette.POINT),
            point_shape="circle",
            point_shading="flat",
            precision="float32",
            visible=False,
        )
        self._drawn: np.ndarray | None = None

    def draw(self, picture: Picture) -> Changes:
        """Draw the points, on top of the obstacles' rims."""
        points = picture.frame.points if picture.look.points else None
        if points is self._drawn:
            return []
        self._drawn = points
        if points is None or not len(points):
            return [(self._dots, "visible", False)]
        stage, world = picture.stage, picture.frame.world
        size = min(DIAMETER * stage.side, 0.3 * world.boundary_spacing * stage.scale)
        return [
            (self._dots, "points", rim_places(picture, points, drawn_height(world))),
            (self._dots, "point_size", size),
            (self._dots, "visible", True),
        ]


def rim_places(picture: Picture, points: np.ndarray, height: float) -> np.ndarray:
    """Boundary points (M, 2) on the display, just above what stands `height` tall; (M, 3)."""
    placed = picture.stage.to_display(points)
    placed[:, 2] = height * picture.stage.scale + 0.01
    return placed.astype(np.float32)
