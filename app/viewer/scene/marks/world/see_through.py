"""Obstacles that a browser sees through: those between its camera and the agent that it follows.

Each browser has its own: what it draws itself stands in for what all browsers draw.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from viser import ClientHandle

from app.viewer.scene.draw.drawn_frame import Picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.marks.world.obstacle_marks import PIECES, Piece
from app.viewer.scene.marks.world.view_blockers import Solids, ViewBlockers
from worlds.world import World

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
                        client.scene.add_frame(f"{name}/{one}", show_axes=False, visible=False)
                        for one in PIECES
                    ]
                    self.pieces = tuple(
                        Piece(client.scene, f"{name}/{part}") for part in ("others", "glass")
                    )
                others, glass = self.pieces
                each = list(enumerate(world.obstacles))
                others.draw([one for k, one in each if k not in clear], world, stage)
                glass.draw([one for k, one in each if k in clear], world, stage, GLASSY)

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
        seen = {one.client.client_id: one for one in watched()}
        for number, (client, view) in list(self._views.items()):
            if number not in seen or seen[number].root != view.root:
                view.end(client)
                del self._views[number]
        known, self._solids = self._solids, {}
        for number, one in seen.items():
            world, stage = one.picture.frame.world, one.picture.stage
            if world.obstacles:
                solids = known.get((world, stage)) or Solids(world, stage)
                self._solids[world, stage] = solids
                _, view = self._views.setdefault(number, (one.client, BrowserView(one.root)))
                self._look(one, view, solids, now)

    def _look(self, one: FollowedAgent, view: BrowserView, solids: Solids, now: float) -> None:
        picture = one.picture
        world, stage = picture.frame.world, picture.stage
        if view.drawn is not None and view.drawn[0] is not world:
            view.in_the_way = ViewBlockers()
        wide = WIDE * picture.length * float(picture.size[one.row]) / stage.scale
        eye, at = stage.unplaced(one.eye), stage.unplaced(picture.at[one.row])
        view.draw(one.client, world, stage, view.in_the_way.look(solids, eye, at, wide, now))
