"""Words beside agents: the information agent's name, and identities if asked for."""

from __future__ import annotations

import numpy as np
from viser import LabelHandle, SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.marks.flock.placing import box, uncrowded
from app.viewer.scene.shown.drawing_style import NUMBERED_UP_TO

SMALL = 0.75
"""Size of a number."""


class Labels:
    """A label for the first information agent and a pool of labels for identities."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._scene = scene
        self._root = root
        self._leader = scene.add_label(
            f"{root}/flock/leader",
            "information UAV",
            anchor="bottom-center",
            font_screen_scale=1.1,
            visible=False,
        )
        self._pool: list[LabelHandle] = []
        self._written = np.empty(0, int)
        """Identities whose numbers are written."""

    def draw(self, picture: Picture) -> Changes:
        changes: Changes = [(self._leader, "visible", picture.leader is not None)]
        if picture.leader is not None:
            changes.append((self._leader, "position", self._beside(picture, picture.leader)))
            changes.append((self._leader, "anchor", anchor(picture, picture.leader)))
            informed = int(np.count_nonzero(picture.frame.informed))
            what = "information car" if picture.as_cars else "information UAV"
            words = what if informed == 1 else f"{what} (1 of {informed})"
            changes.append((self._leader, "text", words))
        return changes + self._draw_identities(picture)

    def _draw_identities(self, picture: Picture) -> Changes:
        count = len(picture.at)
        asked = picture.look.labels and picture.live is None
        wanted = min(count, NUMBERED_UP_TO) if asked else 0
        if asked and count > NUMBERED_UP_TO and picture.frame.inspected is not None:
            rows = picture.frame.inspected.neighbours[:NUMBERED_UP_TO]
        else:
            rows = np.arange(wanted)
        while len(self._pool) < len(rows):
            self._pool.append(self._new(len(self._pool)))
        written = self._uncrowded(picture, rows)
        changes: Changes = []
        for label, row, seen in zip(self._pool, rows, written, strict=False):
            changes.append((label, "text", name(picture, int(row))))
            changes.append((label, "position", self._beside(picture, int(row))))
            changes.append((label, "anchor", anchor(picture, int(row))))
            changes.append((label, "visible", bool(seen) and row != picture.leader))
        return changes + [(label, "visible", False) for label in self._pool[len(rows) :]]

    def _uncrowded(self, picture: Picture, rows: np.ndarray) -> np.ndarray:
        """Which of the numbers of these rows are written: in a flat world none upon another."""
        if picture.stage.dim == 3 or not len(rows):
            return np.ones(len(rows), bool)
        ids = picture.frame.ids[rows]
        texts = [name(picture, int(row)) for row in rows]
        size = SMALL * picture.stage.side * np.array([box(text) for text in texts])
        written = uncrowded(picture.at[rows, :2], size, np.isin(ids, self._written))
        self._written = ids[written]
        return written

    def _new(self, number: int) -> LabelHandle:
        return self._scene.add_label(
            f"{self._root}/flock/identities/{number}",
            "",
            anchor="bottom-center",
            font_screen_scale=SMALL,
            visible=False,
        )

    @staticmethod
    def _beside(picture: Picture, row: int) -> np.ndarray:
        """A place clear of the agent and its halo: above it on the screen, or below."""
        clear = 1.05 * picture.length * float(picture.size[row])
        if picture.stage.dim == 3:
            return picture.at[row] + np.array([0.0, 0.0, clear])
        below = anchor(picture, row).startswith("top")
        return picture.at[row] + np.array([0.0, -clear if below else clear, 0.0])


def name(picture: Picture, row: int) -> str:
    """What is written beside an agent: its number, and of a car that hunts the others also that."""
    number, cars = str(picture.frame.ids[row]), picture.frame.cars
    return f"{number} predator" if cars is not None and cars.predator[row] else number


def anchor(picture: Picture, row: int) -> str:
    """Which point of the words is fixed: chosen so that they stay within a flat world's picture.

    Agents that have left the box of an open world have theirs above them, as in space.
    """
    if picture.stage.dim == 3:
        return "bottom-center"
    across, along = picture.at[row, :2] / picture.stage.half[:2]
    upright = "top" if 0.87 < along < 1.02 else "bottom"
    sideways = "right" if 0.85 < across < 1.02 else "left" if -1.02 < across < -0.85 else "center"
    return f"{upright}-{sideways}"
