"""Takes frames of a flock; what is costly is taken as asked for, and not for every frame."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np

from agents.flock import Flock
from agents.inspection import Inspection
from app.viewer.crowd import refuse_too_many_links
from app.viewer.frame import Frame
from app.viewer.ration import Ration


@dataclass(frozen=True)
class Wanted:
    """What the viewer wants to know beside positions and headings."""

    layers: bool = False
    groups: bool = False
    links: bool = False
    row: int | None = None
    """Row of the agent to inspect."""


@dataclass
class Camera:
    """Takes frames of one flock."""

    flock: Flock
    run: int
    wanted: Wanted = Wanted()
    layer: np.ndarray | None = None
    group: np.ndarray | None = None
    links: np.ndarray | None = None
    inspected: Inspection | None = None
    fastest: float = 1e-12
    ration: Ration = field(default_factory=lambda: Ration(period=1 / 15, share=0.15))

    def want(self, wanted: Wanted) -> None:
        """Change what is wanted; it is in the next frame."""
        self.wanted = wanted
        self.ration.renew()

    def take(self) -> Frame:
        """A frame of the flock now; layers, groups and links are as last examined."""
        flock = self.flock
        speed = flock.speed.copy()
        self.fastest = max(self.fastest, float(speed.max(initial=0.0)))
        return Frame(
            run=self.run,
            tick=flock.tick,
            dim=flock.position.shape[1],
            size=np.array(flock.world.size, float),
            wraps=np.array(flock.world.wraps, bool),
            reach=float(flock.reach),
            speed_scale=self.fastest,
            position=flock.position.copy(),
            heading=flock.heading.copy(),
            speed=speed,
            informed=flock.informed.copy(),
            ids=flock.ids.copy(),
            layer=self.layer,
            group=self.group,
            links=self.links,
            inspected=self.inspected,
        )

    def examine(self) -> None:
        """Find what takes a look at the whole flock, if it is wanted and due."""
        if not self.ration.due(time.perf_counter()):
            return
        wanted, flock = self.wanted, self.flock
        with self.ration.measured():
            self.layer = self.group = self.links = None
            if wanted.layers or wanted.groups or wanted.links:
                refuse_too_many_links(flock)
            self.layer = np.array(flock.layers()) if wanted.layers else None
            self.group = np.array(flock.group_labels()) if wanted.groups else None
            self.links = np.array(flock.links()) if wanted.links else None

    def inspect(self) -> None:
        """Look at the wanted agent and at whom it listens to."""
        row, self.inspected = self.wanted.row, None
        if row is None or not 0 <= row < len(self.flock.ids):
            return
        self.inspected = self.flock.inspect(row)
