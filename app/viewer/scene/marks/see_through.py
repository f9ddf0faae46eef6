"""Obstacles that a browser sees through: those between its camera and the agent that it follows.

Each browser has its own: what it draws itself stands in for what all browsers draw.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import shapely
from viser import ClientHandle

from app.viewer.scene.draw.drawn_frame import Picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.marks.obstacle_marks import PIECES, Piece, drawn_height
from worlds.queries.outlines import footprints
from worlds.world import World

# Which obstacles are between a camera and an agent.

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
        self._upright = np.array([solid[0] for solid in upright], int)
        self._spans = np.array([solid[1:3] for solid in upright], float).reshape(-1, 2)
        self._outlines = np.array([solid[3] for solid in upright], object)
        self._balls = np.array(balls, float).reshape(-1, 5)

    def blocking(self, eye: np.ndarray, at: np.ndarray, wide: float) -> set[int]:
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

    def find_blockers(
        self, solids: Solids, eye: np.ndarray, at: np.ndarray, wide: float, now: float
    ) -> frozenset[int]:
        """The obstacles that are, at `now` (s)."""
        hidden = solids.blocking(eye, at, LOOSE * wide) & self._until.keys()
        for k in solids.blocking(eye, at, wide) | hidden:
            self._until[k] = now + LASTS
        self._until = {k: until for k, until in self._until.items() if now < until}
        return frozenset(self._until)


EVERY = 0.2
"""Seconds between two looks."""
WIDE = 0.5
"""Half the width of what is to be seen of an agent, as a multiple of its length."""
GLASSY = 0.22
"""Opacity of what is in the way."""


class FollowedAgent(NamedTuple):
    """An agent that a browser's camera follows."""

    client: ClientHandle
    picture: Picture
    row: int
    eye: np.ndarray
    """Where the camera is on the display of this picture, (3,)."""
    root: str
    """What the nodes of its room are below."""


@dataclass
class BrowserView:
    """What one browser draws itself."""

    root: str
    drawn: tuple[World, Stage, frozenset[int]] | None = None
    in_the_way: ViewBlockers = field(default_factory=ViewBlockers)
    pieces: tuple[Piece, ...] = ()
    hidden: list[Any] = field(default_factory=list)

    def draw(self, client: ClientHandle, world: World, stage: Stage, clear: frozenset[int]) -> None:
        """Draw these obstacles of a world as of glass."""
        if not clear:
            self.end(client)
        elif self.drawn != (world, stage, clear):
            self.drawn = world, stage, clear
            name = f"{self.root}/world/obstacles"
            with client.atomic():
                if not self.pieces:
                    self.hidden = [
                        client.scene.add_frame(f"{name}/{piece}", show_axes=False, visible=False)
                        for piece in PIECES
                    ]
                    self.pieces = tuple(
                        Piece(client.scene, f"{name}/{part}") for part in ("others", "glass")
                    )
                others, glass = self.pieces
                each = list(enumerate(world.obstacles))
                others.draw([obstacle for k, obstacle in each if k not in clear], world, stage)
                glass.draw([obstacle for k, obstacle in each if k in clear], world, stage, GLASSY)

    def end(self, client: ClientHandle) -> None:
        """Draw nothing; what all browsers draw is there again."""
        with client.atomic():
            for node in (*self.pieces, *self.hidden):
                node.remove()
        self.drawn, self.pieces, self.hidden = None, (), []


class SeeThrough:
    """Looks a few times a second; costs nothing while nobody follows an agent."""

    def __init__(self) -> None:
        self._views: dict[int, tuple[ClientHandle, BrowserView]] = {}
        self._solids: dict[tuple[World, Stage], Solids] = {}
        self._due = 0.0

    def look(self, watched: Callable[[], list[FollowedAgent]]) -> None:
        """Let browsers see what they follow; who they are is asked only when it is time."""
        now = time.monotonic()
        if now < self._due:
            return
        self._due = now + EVERY
        by_client = {followed.client.client_id: followed for followed in watched()}
        for number, (client, view) in list(self._views.items()):
            if number not in by_client or by_client[number].root != view.root:
                view.end(client)
                del self._views[number]
        solids_by_world, self._solids = self._solids, {}
        for number, followed in by_client.items():
            world, stage = followed.picture.frame.world, followed.picture.stage
            if world.obstacles:
                solids = solids_by_world.get((world, stage)) or Solids(world, stage)
                self._solids[world, stage] = solids
                _, view = self._views.setdefault(
                    number, (followed.client, BrowserView(followed.root))
                )
                self._look(followed, view, solids, now)

    def _look(self, followed: FollowedAgent, view: BrowserView, solids: Solids, now: float) -> None:
        picture = followed.picture
        world, stage = picture.frame.world, picture.stage
        if view.drawn is not None and view.drawn[0] is not world:
            view.in_the_way = ViewBlockers()
        wide = WIDE * picture.length * float(picture.size[followed.row]) / stage.scale
        eye, at = stage.place_in_world(followed.eye), stage.place_in_world(picture.at[followed.row])
        view.draw(
            followed.client, world, stage, view.in_the_way.find_blockers(solids, eye, at, wide, now)
        )
