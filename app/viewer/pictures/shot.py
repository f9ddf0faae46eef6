"""A flock at a tick as the page draws it: the same colours and sizes, without a page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.inspection import shells
from agents.models.model import Model
from agents.observables.of_agents import measurable, measured
from agents.observables.of_flocks import SAVED
from agents.snapshot import Snapshot
from agents.state.start import start_box
from app.viewer.scene.draw.drawn_frame import Picture, picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.shown.colouring import COLOURINGS, MEASURED
from app.viewer.scene.shown.drawing_style import DrawingStyle, default_style, legend
from app.viewer.scene.shown.frame import Frame, MissionProgress, cars
from worlds.input_error import InputError, unknown
from worlds.world import World


@dataclass(frozen=True)
class WatchedFlock:
    """What a page knows of the flock that it shows: all that a picture says of it."""

    model: Model
    all_parameters: Mapping[str, Any]
    """By name; distributions where agents differ."""
    seed: int | None
    frame: Frame

    @property
    def world(self) -> World:
        """Where it lives."""
        return self.frame.world

    @property
    def position(self) -> np.ndarray:
        """(N, dim), length."""
        return self.frame.position

    @property
    def heading(self) -> np.ndarray:
        """(N, dim), unit vectors."""
        return self.frame.heading

    @property
    def ids(self) -> np.ndarray:
        """(N,) int: identities."""
        return self.frame.ids

    @property
    def informed(self) -> np.ndarray:
        """(N,) bool: information agents."""
        return self.frame.informed

    @property
    def tick(self) -> int:
        """Ticks done."""
        return self.frame.tick

    @property
    def elapsed(self) -> float:
        """Time since the start."""
        return self.frame.tick * self.frame.dt


@dataclass(frozen=True)
class Shot:
    """A flock at a tick with the picture that is made of it."""

    now: Snapshot | WatchedFlock
    made: Picture

    @property
    def position(self) -> np.ndarray:
        """(N, dim), length."""
        return self.now.position

    @property
    def length(self) -> np.ndarray:
        """Of each agent as it is drawn, (N,), length."""
        return self.made.length * self.made.size / self.made.stage.scale

    @property
    def entries(self) -> list[tuple[str, str]]:
        """What the colours mean, but for those that a wheel explains: words and CSS colours."""
        look = DrawingStyle() if self.made.shows_density else self.made.look
        return legend(look, self.made.frame)

    def row_of(self, identity: int) -> int:
        """The row of the agent with an identity. Raises InputError if there is none."""
        found = np.flatnonzero(self.now.ids == identity)
        if not len(found):
            raise InputError(f"agent {identity} is not there at tick {self.now.tick}")
        return int(found[0])


def look_of(now: Snapshot, colour: str | None) -> DrawingStyle:
    """How it is drawn, coloured by a name of `colourings`; None: as suits it. Raises InputError."""
    if colour is None:
        has_kinds = bool(now.kinds.kinds)
        if now.informed.any() and not has_kinds:
            return DrawingStyle(colour="layer")
        return default_style(now.model, len(now.ids), now.dt, has_kinds).look
    if colour in COLOURINGS and colour != MEASURED:
        return DrawingStyle(colour=colour)
    if colour not in colourings(now):
        raise unknown("colour", colour, colourings(now))
    return DrawingStyle(colour=MEASURED, measured=colour)


def colourings(now: Snapshot) -> tuple[str, ...]:
    """What the agents of a flock may be coloured by."""
    return (
        *(name for name in COLOURINGS if name != MEASURED),
        *measurable(now.model.columns, now.differing),
    )


def shot(now: Snapshot, look: DrawingStyle, fastest: float = 0.0) -> Shot:
    """A snapshot, taken with signals, as it is drawn; `fastest` has full colour by speed."""
    frame = frame_of(now, look, fastest)
    return Shot(now, picture(frame, look, Stage.of(frame)))


def frame_of(now: Snapshot, look: DrawingStyle, fastest: float) -> Frame:
    """What the page's drawing needs of a snapshot."""
    by_number = look.colour == MEASURED
    labels = COLOURINGS[look.colour].labels
    inner = shells(now)[:1]
    anyone: Any = now  # a snapshot answers as a flock does
    offered = measurable(now.model.columns, now.differing)
    known = by_number and look.measured in offered
    return Frame(
        run=0,
        tick=now.tick,
        world=now.world,
        reach=now.reach,
        speed_scale=max(fastest, float(np.max(now.speed, initial=1e-12, where=now.active))),
        position=now.position,
        heading=now.heading,
        speed=now.speed,
        informed=now.informed,
        ids=now.ids,
        kept=inner[0].radius if inner else float("inf"),
        dt=now.dt,
        unit=now.model.body.unit,
        room=room(now),
        progress=progress(now),
        layer=now.layers() if labels == "layer" else None,
        group=now.group_labels() if labels == "group" else None,
        measured=measured(now, look.measured) if known else None,
        active=now.active | (now.kind_numbers < 0) if now.can_crash else None,
        kind=now.kind_numbers if now.kinds.kinds else None,
        kinds=now.kinds,
        has_turnover=now.has_turnover,
        crashes=now.crashes if now.can_crash else None,
        saved=now.signal(SAVED) if SAVED in now.model.columns else None,
        seen=now.seen,
        hollow=now.hollow,
        usual=now.usual,
        apart=now.apart,
        length_unit="m" if now.seen is None else now.model.in_units("length"),
        form=now.model.rule.form,
        cars=cars(anyone),
    )


def room(now: Snapshot) -> tuple[np.ndarray, np.ndarray] | None:
    """The corners of the region in which the flock's mission starts."""
    mission = now.world.mission
    if mission is None or mission.start is None:
        return None
    low, size = start_box(mission.start, len(now.ids))
    return low, low + size


def progress(now: Snapshot) -> MissionProgress:
    """Where the goal is."""
    mission = now.world.mission
    if mission is None or mission.goal is None:
        return MissionProgress()
    return MissionProgress(np.array(now.goal_at([now.tick])[0], float))
