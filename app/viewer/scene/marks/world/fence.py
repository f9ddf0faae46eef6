"""The fence of a capture area: where real cars are made to stop, some way inside its edge."""

from __future__ import annotations

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.line_segments import add_lines, segments
from app.viewer.scene.draw.shapes import box_edges, dashes
from app.viewer.scene.shown import palette, tone

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
        drawn = (picture.stage, None if corners is None else tuple(np.concatenate(corners)))
        if drawn == self._drawn:
            return []
        self._drawn = drawn
        if corners is None:
            return [(self._lines, "visible", False)]
        low, high = (picture.stage.shown(corner) for corner in corners)
        edges = box_edges(0.5 * (high - low)) + 0.5 * (low + high)
        edges[..., 2] = ABOVE
        dash = DASH * picture.stage.side
        lines = np.concatenate([dashes(edge, dash, dash)[0] for edge in edges])
        return segments(self._lines, lines, tone.single(palette.FENCE))


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
