"""Which obstacles are between a camera and an agent."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely

from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.marks.world.obstacle_marks import drawn_height
from worlds.queries.surface import footprints
from worlds.world import World

LOOSE = 1.5
"""An obstacle that was in the way still is until the line of sight is so much farther from it."""
LASTS = 0.5
"""How long it still counts as in the way after that, s."""


class Solids:
    """The obstacles of a world as they are drawn; places are in the world, upright things standing
    on a flat one too, (3,)."""

    def __init__(self, world: World, stage: Stage) -> None:
        upright, balls = [], []
        for k, obstacle in enumerate(world.obstacles):
            for span, outline in footprints(replace(world, obstacles=(obstacle,))).items():
                low, high = span if stage.dim == 3 else (0.0, drawn_height(world))
                upright.append((k, low, high, outline))
            if stage.dim == 3:
                balls += [(k, *place, radius) for place, radius in obstacle.spheres()]
        self._upright = np.array([one[0] for one in upright], int)
        self._spans = np.array([one[1:3] for one in upright], float).reshape(-1, 2)
        self._outlines = np.array([one[3] for one in upright], object)
        self._balls = np.array(balls, float).reshape(-1, 5)

    def between(self, eye: np.ndarray, at: np.ndarray, wide: float) -> set[int]:
        """The obstacles, by their places in the world, that come within `wide` of the line from an
        eye to something as wide at `at`, but not those behind it."""
        way = at - eye
        length = float(np.linalg.norm(way))
        if length <= wide:
            return set()
        way *= 1.0 - wide / length
        return self._prisms(eye, way, wide) | self._spheres(eye, way, wide)

    def _prisms(self, eye: np.ndarray, way: np.ndarray, wide: float) -> set[int]:
        low, high = self._spans.T
        if way[2] == 0.0:
            inside = (low <= eye[2]) & (eye[2] <= high)
            enter, leave = np.where(inside, 0.0, 1.0), np.where(inside, 1.0, 0.0)
        else:
            ends = (self._spans - eye[2]) / way[2]
            enter, leave = np.maximum(ends.min(axis=1), 0.0), np.minimum(ends.max(axis=1), 1.0)
        met = np.flatnonzero(enter <= leave)
        shares = np.stack([enter[met], leave[met]], axis=1)[..., None]
        lines = shapely.linestrings(eye[:2] + shares * way[:2])
        near = shapely.dwithin(self._outlines[met], lines, wide) if len(met) else met.astype(bool)
        return set(self._upright[met[near]].tolist())

    def _spheres(self, eye: np.ndarray, way: np.ndarray, wide: float) -> set[int]:
        which, centre, radius = self._balls[:, 0], self._balls[:, 1:4], self._balls[:, 4]
        share = np.clip((centre - eye) @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
        away = np.linalg.norm(eye + share[:, None] * way - centre, axis=1)
        return set(which[away <= radius + wide].astype(int).tolist())


class ViewBlockers:
    """What is in one camera's way: at once, and until it has not been for a while."""

    def __init__(self) -> None:
        self._until: dict[int, float] = {}

    def look(
        self, solids: Solids, eye: np.ndarray, at: np.ndarray, wide: float, now: float
    ) -> frozenset[int]:
        """The obstacles that are, at `now` (s)."""
        kept = solids.between(eye, at, LOOSE * wide) & self._until.keys()
        for k in solids.between(eye, at, wide) | kept:
            self._until[k] = now + LASTS
        self._until = {k: until for k, until in self._until.items() if now < until}
        return frozenset(self._until)
