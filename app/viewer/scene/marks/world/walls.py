"""The solid edges of the world's box: a low rim around a flat world, panes of glass in space."""

from __future__ import annotations

from typing import Any

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.solids import border, panes, prism, rims
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.shown import palette, tone

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
            self._nodes = [] if not solid.any() else self._rim() if flat else self._glass()
        return []

    def _rim(self) -> list[Any]:
        stage = self._stage
        assert stage is not None
        half, solid = stage.half[:2], np.array(stage.solid[:2])
        outline = border(-half, half, solid, WIDTH * stage.side)
        height = HEIGHT * stage.side
        return [
            self._scene.add_mesh_simple(
                f"{self._name}/rim",
                *prism(outline, 0.0, height),
                color=tone.single(palette.RIM, 1.45),
                flat_shading=True,
            ),
            self._scene.add_line_segments(
                f"{self._name}/lines",
                rims(outline, height).astype(np.float32),
                tone.single(palette.EDGE),
                thickness=1.1,
                thickness_units="screen",
            ),
        ]

    def _glass(self) -> list[Any]:
        stage = self._stage
        assert stage is not None
        return [
            self._scene.add_mesh_simple(
                f"{self._name}/glass",
                *panes(-stage.half, stage.half, np.array(stage.solid[:3])),
                color=tone.single(palette.RIM),
                opacity=0.10,
                side="double",
                cast_shadow=False,
                receive_shadow=False,
            )
        ]
