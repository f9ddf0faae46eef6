"""The room the flock flies in: light, background, floor and the edges of the world's box."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from PIL import Image
from viser import SceneApi

from app.front.viser_internals import show_background
from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.shapes import box_edges, dashes
from app.viewer.scene.draw.solids import border, panes, prism, rims
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.palette import srgb_to_linear

# The solid edges of the world's box: a low rim around a flat world, panes of glass in space.

WIDTH, HEIGHT = 0.010, 0.018
"""Of the rim, as multiples of the longest side."""


class Walls:
    """Built again when the stage changes."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._scene = scene
        self._name = f"{root}/world/walls"
        self._stage: Stage | None = None
        self._nodes: list[Any] = []

    def draw(self, picture: Picture) -> Changes:
        """Bring the walls up to date."""
        if picture.stage != self._stage:
            self._stage = picture.stage
            for node in self._nodes:
                node.remove()
            solid = np.array(picture.stage.solid[: picture.stage.dim])
            flat = picture.stage.dim == 2
            build = self._rim if flat else self._glass
            self._nodes = build(picture.stage) if solid.any() else []
        return []

    def _rim(self, stage: Stage) -> list[Any]:
        half, solid = stage.half[:2], np.array(stage.solid[:2])
        outline = border(-half, half, solid, WIDTH * stage.side)
        height = HEIGHT * stage.side
        return [
            self._scene.add_mesh_simple(
                f"{self._name}/rim",
                *prism(outline, 0.0, height),
                color=palette.node_colour(palette.RIM, 1.45),
                flat_shading=True,
            ),
            self._scene.add_line_segments(
                f"{self._name}/lines",
                rims(outline, height).astype(np.float32),
                palette.node_colour(palette.EDGE),
                thickness=1.1,
                thickness_units="screen",
            ),
        ]

    def _glass(self, stage: Stage) -> list[Any]:
        return [
            self._scene.add_mesh_simple(
                f"{self._name}/glass",
                *panes(-stage.half, stage.half, np.array(stage.solid[:3])),
                color=palette.node_colour(palette.RIM),
                opacity=0.10,
                side="double",
                cast_shadow=False,
                receive_shadow=False,
            )
        ]


CELLS, SECTIONS = 20, 4
"""Lines of the floor along the longest side."""
UNDER = 0.05
"""How much lower than the box the wide floor of an open world lies."""
DEEP = 3.0
"""Depth of the fog from where it begins, as a multiple of the longest side."""
SUN = (-4.0, -5.5, 11.0)
GROUND, BELOW = 60.0, 0.04
"""Side of the ground around a world in space, as a multiple of the longest side, which ends behind
the fog as a horizon; and how much lower than the floor it lies."""


def set_light(scene: SceneApi) -> None:
    """Even light from the sky and one sun that casts shadows; the same on any theme."""
    scene.configure_default_lights(False)
    scene.configure_environment_map(None)
    scene.add_light_hemisphere(
        "/light/sky", sky_color=(255, 255, 255), ground_color=(178, 190, 210), intensity=2.1
    )
    scene.add_light_directional(
        "/light/sun",
        color=(255, 251, 242),
        intensity=2.4,
        cast_shadow=True,
        position=SUN,
    )
    show_background(scene, sky())


def sky() -> bytes:
    """The background as PNG; viser would import all of imageio to make it one."""
    buffer = io.BytesIO()
    Image.fromarray(np.repeat(sky_rows(64)[:, None], 4, axis=1)).save(buffer, "png")
    return buffer.getvalue()


def sky_rows(count: int) -> np.ndarray:
    """The colours of the background from top to bottom, (count, 3) uint8."""
    steps = np.linspace(0.0, 1.0, count)[:, None]
    rows = palette.SKY_HIGH + steps * (palette.SKY_LOW - palette.SKY_HIGH)
    return np.rint(255.0 * rows).astype(np.uint8)


class Fog:
    """Depth in space: full colour up to some distance from the camera, then slowly paler."""

    def __init__(self, scene: SceneApi) -> None:
        self._scene = scene
        self._drawn: tuple[Stage, float] | None = None

    def draw(self, stage: Stage, is_open: bool, flocks: int) -> None:
        """Fog for a stage: farther off in an open world, and where there are two flocks.

        The browser takes its colour for linear light.
        """
        near = (3.5 if is_open else 1.7) + 3.6 * (flocks - 1)
        if (stage, near) == self._drawn:
            return
        self._drawn = stage, near
        side = stage.side
        self._scene.configure_fog(
            near * side,
            (near + DEEP) * side,
            color=srgb_to_linear(palette.FOG),
            enabled=stage.dim == 3,
        )


DASH = 0.012
"""Of an edge that wraps: length of a dash as a multiple of the longest side."""


class WorldBox:
    """Floor and box; rebuilt when the stage changes, moved when the flock leaves its box."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._scene = scene
        self._root = root
        self._stage: Stage | None = None
        self._run: int | None = None
        self._left = False
        self._ground: Any = None
        self._edges: dict[str, Any] = {}

    def draw(self, picture: Picture) -> Changes:
        again = self._left and picture.frame.run != self._run
        self._run = picture.frame.run
        if again or picture.stage != self._stage:
            self._stage, self._left = picture.stage, False
            self._build(picture.stage)
        if not self._left:
            if not has_left_box(picture):
                return []
            self._left = True
            self._open_up(picture.stage)
        under = floor_under(picture)
        if np.array_equal(under, self._floor.position):
            return []
        ground = [] if self._ground is None else [(self._ground, "position", under - [0, 0, BELOW])]
        return [(self._floor, "position", under), *ground]

    @property
    def is_open(self) -> bool:
        """Whether the flock has left its box."""
        return self._left

    def _build(self, stage: Stage) -> None:
        width, depth = 2.0 * stage.half[:2]
        self._lay_floor(stage, float(width), float(depth), fade=100.0)
        closed, opened = edges_by_kind(stage)
        self._draw_edges("edges", closed, palette.EDGE if stage.dim == 2 else palette.EDGE_SPACE)
        self._draw_edges("open", opened, palette.EDGE_LIGHT)
        if self._root == "":
            self._lay_ground(stage)

    def _lay_ground(self, stage: Stage) -> None:
        """Wide ground in space, on which the world stands; a second one stands on the first's."""
        if self._ground is not None:
            self._ground.remove()
            self._ground = None
        if stage.dim == 2:
            return
        self._ground = self._scene.add_grid(
            "/ground",
            width=GROUND * stage.side,
            height=GROUND * stage.side,
            plane="xy",
            cell_size=stage.side,
            cell_thickness=0.0,
            section_size=stage.side,
            section_thickness=1.0,
            section_color=palette.node_colour(palette.GROUND_LINE),
            fade_distance=GROUND * stage.side,
            fade_strength=0.0,
            shadow_opacity=0.30,
            plane_color=tuple(palette.GROUND),
            plane_opacity=1.0,
            position=(0.0, 0.0, stage.floor - BELOW),
        )

    def _open_up(self, stage: Stage) -> None:
        """The world is open: a wide floor, and the box only as a hint of where it began.

        The floor lies lower than a box beside it, which it reaches under.
        """
        self._lay_floor(stage, 8.0 * stage.side, 8.0 * stage.side, fade=4.0)
        self._draw_edges("edges", np.empty((0, 2, 3)), palette.EDGE_LIGHT)
        self._draw_edges("open", box_edges(stage.half), palette.EDGE_LIGHT)

    def _lay_floor(self, stage: Stage, width: float, depth: float, fade: float) -> None:
        self._floor = self._scene.add_grid(
            f"{self._root}/world/floor",
            width=width,
            height=depth,
            plane="xy",
            cell_size=stage.side / CELLS,
            cell_thickness=0.9,
            cell_color=palette.node_colour(palette.CELL),
            section_size=stage.side / SECTIONS,
            section_thickness=1.0,
            section_color=palette.node_colour(palette.SECTION),
            fade_distance=fade * stage.side,
            fade_strength=0.8,
            shadow_opacity=0.30,
            plane_color=tuple(palette.FLOOR),
            plane_opacity=1.0,
            position=(0.0, 0.0, stage.floor - 0.01),
        )

    def _draw_edges(self, name: str, lines: np.ndarray, colour: np.ndarray) -> None:
        if name in self._edges:
            self._edges.pop(name).remove()
        if len(lines):
            self._edges[name] = self._scene.add_line_segments(
                f"{self._root}/world/{name}",
                lines,
                palette.node_colour(colour),
                thickness=1.6,
                thickness_units="screen",
            )


def edges_by_kind(stage: Stage) -> tuple[np.ndarray, np.ndarray]:
    """The edges of the box, (K, 2, 3), and the open ones: solid ones whole, wrapping ones dashed.

    In space an edge is what the closer of its two faces is: solid, wrapping, open in this order.
    """
    closed, opened = [np.empty((0, 2, 3))], [np.empty((0, 2, 3))]
    for ends in box_edges(stage.half):
        faces = [axis for axis in range(stage.dim) if ends[0, axis] == ends[1, axis]]
        if any(stage.solid[axis] for axis in faces):
            closed.append(ends[None])
        elif any(stage.wraps[axis] for axis in faces):
            closed.append(dashes(ends, DASH * stage.side, 0.7 * DASH * stage.side)[0])
        else:
            opened.append(ends[None])
    return np.concatenate(closed), np.concatenate(opened)


def has_left_box(picture: Picture) -> bool:
    """Whether an agent is clearly outside the box along an axis that does not wrap."""
    free = ~np.array(picture.stage.wraps)
    if not free.any() or not len(picture.at):
        return False
    beyond = np.abs(picture.at[:, : picture.stage.dim][:, free])
    return bool(np.any(beyond > 1.02 * picture.stage.half[: picture.stage.dim][free]))


def floor_under(picture: Picture) -> np.ndarray:
    """Centre of the floor: under the flock, in whole sections so that the lines stay put."""
    section = picture.stage.side / SECTIONS
    middle = np.median(picture.at[:, :2], axis=0) if len(picture.at) else np.zeros(2)
    lowest = float(np.min(picture.at[:, 2], initial=picture.stage.floor))
    steps_down = np.ceil(max(picture.stage.floor - lowest, 0.0) / section)
    height = picture.stage.floor - UNDER - section * steps_down
    return np.array([*(section * np.rint(middle / section)), height])
