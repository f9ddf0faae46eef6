"""The capture area of a room with real cars: its edge, its size, and what lies beyond the fence."""

from __future__ import annotations

from typing import Any

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.line_segments import add_lines, segments
from app.viewer.scene.draw.shapes import Mesh, box_edges, dashes
from app.viewer.scene.shown import palette

# The fence of a capture area: where real cars are made to stop, some way inside its edge.

INSIDE = 0.5
"""Distance of the fence from the edge of the area, m, where no laboratory has its own."""
ABOVE, DASH = 0.014, 0.009
"""Height of the line on the display, and its dashes as a multiple of the longest side."""


class Fence:
    """A dashed rectangle."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._lines = add_lines(scene, f"{root}/world/fence", thickness=2.0)
        self._drawn: object = None

    def draw(self, picture: Picture) -> Changes:
        """Draw it where there is one."""
        corners = fence(picture)
        key = (picture.stage, None if corners is None else tuple(np.concatenate(corners)))
        if key == self._drawn:
            return []
        self._drawn = key
        if corners is None:
            return [(self._lines, "visible", False)]
        low, high = (picture.stage.to_display(corner) for corner in corners)
        edges = box_edges(0.5 * (high - low)) + 0.5 * (low + high)
        edges[..., 2] = ABOVE
        dash = DASH * picture.stage.side
        lines = np.concatenate([dashes(edge, dash, dash)[0] for edge in edges])
        return segments(self._lines, lines, palette.node_colour(palette.FENCE))


def fence(picture: Picture) -> tuple[np.ndarray, np.ndarray] | None:
    """Corners (2,) of the fence: that of an open world of cars which has room for one, or None."""
    frame, live = picture.frame, picture.live
    is_open = set(frame.world.edges) == {"open"}
    if not (picture.as_cars and picture.look.fence and is_open):
        return None
    if live is None:
        inside, room = INSIDE, bool(min(frame.size) > 4.0 * INSIDE)
    else:
        inside, room = live.fence, live.fence > 0.0
    return (frame.low + inside, frame.low + frame.size - inside) if room else None


THICK = {"safe": 2.2, "armed": 3.2, "emergency": 5.0}
"""Width of the edge, pixels, by what the laboratory may do."""
TINT, TINTED = 0.5 * ABOVE, 0.08
"""Height and opacity of the floor's tint beyond the fence."""
AWAY = 0.012
"""Distance of the caption from the edge, as a multiple of the longest side."""


class CaptureArea:
    """Drawn again when the room, its fence or what the laboratory may do changes."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._scene = scene
        self._name = f"{root}/world/area"
        self._edge = add_lines(scene, f"{self._name}/edge", thickness=THICK["safe"])
        self._caption = scene.add_label(
            f"{self._name}/size", "", anchor="top-right", font_screen_scale=0.95, visible=False
        )
        self._tint: Any = None
        self._drawn: object = None

    def draw(self, picture: Picture) -> Changes:
        """Draw it, if there are real cars."""
        live, stage, within = picture.live, picture.stage, fence(picture)
        arm, inside = (None, 0.0) if live is None else (live.arm, live.fence)
        key = stage, arm, inside, within is None
        if key == self._drawn:
            return []
        self._drawn = key
        if self._tint is not None:
            self._tint.remove()
            self._tint = None
        if arm is None:
            return [(self._edge, "visible", False), (self._caption, "visible", False)]
        if within is not None:
            self._lay(picture, *within, arm == "emergency")
        edges = box_edges(stage.half)
        edges[..., 2] = ABOVE
        corner = stage.half * [1.0, -1.0, 0.0] - [0.0, AWAY * stage.side, 0.0]
        return [
            *segments(self._edge, edges, palette.node_colour(palette.ARMS[arm])),
            (self._edge, "thickness", THICK[arm]),
            (self._caption, "text", size(stage.size)),
            (self._caption, "position", corner),
            (self._caption, "visible", True),
        ]

    def _lay(self, picture: Picture, low: np.ndarray, high: np.ndarray, stopped: bool) -> None:
        """The tint between the edge and the fence."""
        stage = picture.stage
        self._tint = self._scene.add_mesh_simple(
            f"{self._name}/beyond",
            *frame_mesh(
                stage.half[:2], stage.to_display(low)[:2], stage.to_display(high)[:2], TINT
            ),
            color=palette.node_colour(palette.ARMS["emergency"] if stopped else palette.FENCE),
            opacity=TINTED,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )


def size(sides: tuple[float, ...]) -> str:
    """Sides (m) in words.

    >>> size((6.1, 6.71))
    '6.10 × 6.71 m'
    """
    return " × ".join(f"{side:.2f}" for side in sides) + " m"


def frame_mesh(half: np.ndarray, low: np.ndarray, high: np.ndarray, height: float) -> Mesh:
    """What of a rectangle about the origin, of half sides (2,), is outside another one from `low`
    to `high`, (2,): a flat mesh at a height, facing up."""
    outer = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * half
    inner = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    corners = np.column_stack([np.concatenate([outer, inner]), np.full(8, height)])
    faces = []
    for corner in range(4):
        after = (corner + 1) % 4
        faces += [(corner, after, 4 + after), (corner, 4 + after, 4 + corner)]
    return corners, np.array(faces)
