"""Rings around real cars that are seen late or no more."""

from __future__ import annotations

from viser import SceneApi

from app.viewer.scene.draw import palette, tone
from app.viewer.scene.draw.lines import add_lines, segments
from app.viewer.scene.draw.picture import Changes, Picture
from app.viewer.scene.draw.shapes import circle
from app.viewer.scene.marks.world.mission import on_floor
from app.viewer.scene.shown.live import LATE, LOST

RADIUS = 0.8
"""Of a ring, as a multiple of a car's length."""

COLOURS = {state: tone.single(palette.STATES[state]) for state in (LATE, LOST)}


class LiveRings:
    """A ring of the colour of its state on each car that is late or lost."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._rings = {
            LATE: add_lines(scene, f"{root}/flock/late", thickness=2.6),
            LOST: add_lines(scene, f"{root}/flock/lost", thickness=3.2),
        }

    def draw(self, picture: Picture) -> Changes:
        """Draw the rings."""
        live, changes = picture.live, Changes()
        for state, lines in self._rings.items():
            if live is None:
                changes.append((lines, "visible", False))
                continue
            at = on_floor(picture, picture.frame.position[live.are(state)])
            rings = at[:, None, None, :] + RADIUS * picture.length * circle(40)
            changes += segments(lines, rings.reshape(-1, 2, 3), COLOURS[state])
        return changes
