"""Takes frames of a flock; what is costly is taken as asked for, and not for every frame."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from agents.flock import Flock
from agents.inspection import Inspection, shells
from agents.models.declare import Parameters
from agents.observables.of_agents import OF_AGENTS, measured
from agents.snapshot import Snapshot
from agents.state.start import start_box
from app.viewer.measuring.background_worker import BackgroundWorker, WorkThrottle
from app.viewer.measuring.time_series import refuse_too_many_links
from app.viewer.scene.shown.frame import Frame, MissionProgress, cars

SAVED = "saved"
"""The measure of a body that is the share of its induced drag that each agent saves."""


@dataclass(frozen=True)
class FrameRequest:
    """What the viewer wants to know beside positions and headings."""

    layers: bool = False
    groups: bool = False
    measured: str = ""
    """A number of each agent by its name, see `agents.observables.of_agents`."""
    links: bool = False
    points: bool = False
    """Boundary points of obstacles."""
    row: int | None = None
    """Row of the agent to inspect."""
    identity: int | None = None
    """Whose row it is, where agents come and go: it may be another one by now."""
    beside: bool = False
    """Whether that is an agent of the flock beside."""
    others: frozenset[int] = frozenset()
    """Rows of agents that other pages inspect: a few times a second."""
    others_beside: frozenset[int] = frozenset()
    """The same of the flock beside."""

    @property
    def first(self) -> FrameRequest:
        """The same without what other pages inspect."""
        return replace(self, others=frozenset(), others_beside=frozenset())


@dataclass(frozen=True)
class WatchPageRequest:
    """What other pages want to know of a laboratory's run, beside what its own wants."""

    browsers: int = 0
    """How many look at it there."""
    names: frozenset[str] = frozenset()
    """Observables to measure."""
    rows: frozenset[int] = frozenset()
    """Rows of the agents to inspect."""
    rows_beside: frozenset[int] = frozenset()
    """The same of the flock beside."""


@dataclass
class FrameBuilder:
    """Takes frames of one flock."""

    flock: Flock
    run: int
    wanted: FrameRequest = FrameRequest()
    layer: np.ndarray | None = None
    group: np.ndarray | None = None
    measured: np.ndarray | None = None
    links: np.ndarray | None = None
    points: np.ndarray | None = None
    inspected: Inspection | None = None
    others: Mapping[int, Inspection] = field(default_factory=dict)
    examined: np.ndarray = field(default_factory=lambda: np.empty(0, int))
    """The identities of the rows that were last examined."""
    fastest: float = 1e-12
    surveyed: object | None = None
    """The world whose boundary points are at hand."""
    reached: tuple[Parameters, np.ndarray, np.ndarray] | None = None
    """Parameters, shared and own, and how far agents that have them notice others."""
    warm: bool = False
    aside: BackgroundWorker = field(default_factory=BackgroundWorker)
    rate_limit: WorkThrottle = field(
        default_factory=lambda: WorkThrottle(period=1 / 15, share=0.15)
    )
    others_limit: WorkThrottle = field(
        default_factory=lambda: WorkThrottle(period=1 / 4, share=0.1)
    )

    def set_request(self, request: FrameRequest) -> None:
        """Change what is wanted; it is in the next frame."""
        if request.first != self.wanted.first:
            self.rate_limit.renew()
        self.wanted = request

    def build(self) -> Frame:
        """A frame of the flock now; layers, groups and links are as last examined."""
        flock, now = self.flock, self.flock.snapshot()
        active = now.active
        reaches = self.reaches_of(now)
        if now.has_turnover and not np.array_equal(self.examined, now.ids):
            self.layer = self.group = self.links = self.measured = None  # of other rows
        self.fastest = max(self.fastest, float(np.max(now.speed, initial=0.0, where=active)))
        return Frame(
            run=self.run,
            tick=now.tick,
            world=now.world,
            reach=now.reach if reaches is None else float(reaches.max(initial=0.0)),
            reaches=reaches,
            own=now.own,
            individuals=now.individuals,
            speed_scale=self.fastest,
            position=now.position,
            heading=now.heading,
            speed=now.speed,
            informed=now.informed,
            ids=now.ids,
            kept=distance_kept(flock),
            dt=now.dt,
            unit=flock.model.body.unit,
            room=room(flock),
            progress=progress(flock),
            sees_points=flock.model.rule.sees_points,
            points=self.points,
            layer=self.layer,
            group=self.group,
            measured=self.measured,
            links=self.links,
            inspected=self.inspected,
            others=self.others,
            active=active | (now.kind_numbers < 0) if now.can_crash else None,
            kind=now.kind_numbers if now.kinds.kinds else None,
            kinds=now.kinds,
            has_turnover=now.has_turnover,
            crashes=now.crashes if flock.can_crash else None,
            saved=now.signal(SAVED) if SAVED in flock.model.columns else None,
            form=flock.model.rule.form,
            cars=cars(flock),
        )

    def reaches_of(self, now: Snapshot) -> np.ndarray | None:
        """How far each agent notices others, (N,), length; None where all do alike."""
        if not now.differing:
            self.reached = None
            return None
        last = self.reached  # to find it takes a call for each agent
        if (
            last is None
            or last[0] is not self.flock.parameters
            or not np.array_equal(last[1], now.arrays.own)
        ):
            self.reached = last = self.flock.parameters, now.arrays.own, now.reaches
        return last[2]

    def examine(self, at_once: bool = False) -> None:
        """Find what takes a look at the whole flock, if it is wanted and due, or `at_once`."""
        self.survey()
        if not (at_once or self.rate_limit.is_due(time.perf_counter())):
            return
        request, flock = self.wanted, self.flock
        with self.rate_limit.measure_duration():
            self.layer = self.group = self.links = self.measured = None
            if request.layers or request.groups or request.links or request.measured in OF_AGENTS:
                refuse_too_many_links(flock)
            now = flock.snapshot(copy=False)
            if now.has_turnover:
                self.examined = now.ids.copy()
            self.layer = now.layers() if request.layers else None
            self.group = now.group_labels() if request.groups else None
            self.links = now.links() if request.links else None
            self.measured = measured(flock, request.measured) if request.measured else None

    def survey(self) -> None:
        """Take the boundary points of a world that is new."""
        if not self.wanted.points:
            self.points = self.surveyed = None
        elif self.surveyed is not self.flock.world:
            self.surveyed = self.flock.world
            surroundings = self.flock.engine.surroundings
            self.points = np.column_stack([surroundings.point_x, surroundings.point_y])

    def inspect(self) -> None:
        """Look at the wanted agent and at whom it listens to."""
        row, self.inspected = self.wanted.row, None
        if self.wanted.identity is not None:
            rows = np.flatnonzero(self.flock.ids == self.wanted.identity)
            row = int(rows[0]) if len(rows) else None
        if row is None or not 0 <= row < len(self.flock.ids) or not self.is_warm():
            return
        self.inspected = self.flock.inspect(row)

    def inspect_others(self, at_once: bool = False) -> None:
        """Look at the agents that other pages inspect, if it is due, or `at_once`."""
        rows = [row for row in self.wanted.others if 0 <= row < len(self.flock.ids)]
        if not rows:
            self.others = {}
        elif (at_once or self.others_limit.is_due(time.perf_counter())) and self.is_warm():
            with self.others_limit.measure_duration():
                self.others = {row: self.flock.inspect(row) for row in rows}

    def is_warm(self) -> bool:
        """Whether an agent can be inspected at once; what that takes is compiled aside."""
        if not self.warm:
            if self.aside.idle:
                self.aside.begin(self.flock.warm)
            self.warm = self.aside.finished() is not None
        return self.warm


def distance_kept(flock: Flock) -> float:
    """Radius of the innermost zone of a flock's rule, length; infinite where it has none.

    Where agents differ in it that of the centre: all are drawn of one size by it.
    """
    inner = shells(flock)[:1]
    return inner[0].radius if inner else float("inf")


def progress(flock: Flock) -> MissionProgress:
    """How the flock's mission stands."""
    mission = flock.world.mission
    if mission is None:
        return MissionProgress()
    goal = None if mission.goal is None else np.array(flock.goal_at([flock.tick])[0], float)
    legs = flock.arrays.leg[flock.informed] if mission.path is not None else np.empty(0)
    return MissionProgress(goal, int(legs.min()) if len(legs) else 0)


def room(flock: Flock) -> tuple[np.ndarray, np.ndarray] | None:
    """The corners of the region in which the flock's mission starts."""
    mission = flock.world.mission
    if mission is None or mission.start is None:
        return None
    low, size = start_box(mission.start, flock.options.count)
    return low, low + size
