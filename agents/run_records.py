"""Follow a flock while it runs: how a mission went, and observables as series over a run."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from agents.flock import Flock
from agents.observables.catalogue import OBSERVABLES
from agents.observables.following import (
    keep_following,
    least_clearances,
    nearest_pairs,
    settling_tick,
    spread_bound,
)
from agents.observables.observable import SERIES
from agents.option import whole_number
from worlds.input_error import InputError, unknown

if TYPE_CHECKING:
    from agents.flock import Flock

CHUNK = 500
"""Ticks that are run and measured at a time."""
SINCE = 50
"""Tick from which an agent has to follow: Liu et al. 2021, section 3.2, as read."""


@dataclass(frozen=True)
class MissionRecord:
    """How a mission went."""

    position: np.ndarray
    """Positions at every kept tick from 0 on, (K, N, dim)."""
    every: int
    """Ticks between two kept ones."""
    ticks: int
    """Ticks that it lasted."""
    arrived: bool
    """Whether the information agents came to the end of their path."""
    informed: np.ndarray
    """(N,) bool."""
    follows: np.ndarray
    """Ordinary and information agents that have kept up all the time, (N,) bool."""
    pairs: np.ndarray
    """Least distance of each pair, (N, N), above the diagonal; length."""
    clearance: np.ndarray
    """Least signed distance of each agent to a surface, (N,), length; inf far from all."""
    centre: np.ndarray
    """Distance of the flock's centre to the goal at every tick from 0 on, (T + 1,); or empty."""
    away: np.ndarray
    """Distance of each agent to the goal at the end, (N,); empty without a goal."""
    dt: float
    """Time that a tick stands for."""

    @property
    def success(self) -> float:
        """P_s (32): share of the agents that have kept up, in [0, 1]; information agents count."""
        return float(self.follows.mean())

    @property
    def least_obstacle(self) -> float:
        """D_obs: least distance of any agent to a surface, length."""
        return float(self.clearance.min())

    @property
    def least_pair(self) -> float:
        """Least distance between any two agents, length."""
        return float(self.pairs.min())

    @property
    def least_pair_of_followers(self) -> float:
        """D_ind: least distance between two agents that have kept up; inf if fewer have."""
        return float(self.pairs[np.ix_(self.follows, self.follows)].min(initial=np.inf))

    def settled(self, within: float = 2.0) -> float | None:
        """Time from which the flock's centre stays within a distance of the goal; None: never."""
        tick = settling_tick(self.centre, within)
        return None if tick is None else tick * self.dt

    def through(self, d: float) -> float:
        """Share of agents that end no further from the goal than a flock of spacing d needs."""
        return float((self.away <= spread_bound(len(self.away), d)).mean())


class MissionLog:
    """What is measured of a mission while it goes on."""

    def __init__(self, flock: Flock, every: int):
        n = len(flock.ids)
        self.flock = flock
        self.every = every
        self.positions: list[np.ndarray] = []
        self.centre: list[np.ndarray] = []
        self.follows = np.ones(n, bool)
        self.pairs2 = np.full((n, n), np.inf)
        self.clearance = np.full(n, np.inf)
        self.working = np.zeros(n, bool), np.zeros(n, np.int64)
        self.ticks = -1

    @cached_property
    def has_goal(self) -> bool:
        """Whether there is a gamma agent to come to."""
        mission = self.flock.world.mission
        return mission is not None and mission.goal is not None

    def take(self, trace: np.ndarray) -> None:
        """Measure the positions (T, N, dim) of the next T ticks."""
        flock = self.flock
        first = self.ticks + 1
        by_axis = np.ascontiguousarray(trace.transpose(0, 2, 1))
        nearest_pairs(by_axis, self.pairs2)
        least_clearances(by_axis, flock.engine.surroundings, self.clearance)
        late = by_axis[max(0, SINCE - first) :]
        if flock.informed.any() and len(late):
            keep_following(late, flock.informed, flock.reach, self.follows, *self.working)
        self.positions.append(trace[-first % self.every :: self.every].copy())
        if self.has_goal:
            ticks = np.arange(first, first + len(trace))
            goal = flock.goal_at(ticks)
            self.centre.append(np.linalg.norm(trace.mean(axis=1) - goal, axis=1))
        self.ticks += len(trace)

    def record(self, arrived: bool) -> MissionRecord:
        """What has been measured."""
        flock = self.flock
        away = np.empty(0)
        if self.has_goal:
            away = np.linalg.norm(flock.position - flock.goal_at([self.ticks])[0], axis=1)
        return MissionRecord(
            np.concatenate(self.positions),
            self.every,
            self.ticks,
            arrived,
            flock.informed.copy(),
            self.follows,
            np.sqrt(self.pairs2),
            self.clearance,
            np.concatenate(self.centre) if self.centre else np.empty(0),
            away,
            flock.dt,
        )


def fly(
    flock: Flock, limit: int, every: int = 1, between: Callable[[], None] = lambda: None
) -> MissionRecord:
    """Run a flock that has not begun until its information agents are at the end of their path.

    At most `limit` ticks; without a path just these. Keeps the positions of every `every`-th tick.
    `between` is called now and then and may end the run by raising. Raises InputError if the flock
    has already run.
    """
    if flock.tick:
        raise InputError(f"the flock is at tick {flock.tick}: a mission begins at tick 0")
    log = MissionLog(flock, every)
    log.take(flock.position[None].copy())
    while flock.tick < limit:
        between()
        trace = flock.trace(min(CHUNK, limit - flock.tick))
        end = end_of_path(flock, trace)
        if end is not None:
            log.take(trace[: end + 1])
            return log.record(True)
        log.take(trace)
    return log.record(False)


def end_of_path(flock: Flock, trace: np.ndarray) -> int | None:
    """Index in a trace at which the last information agent came to its last waypoint, or None."""
    path = flock.engine.surroundings.path
    legs = flock.arrays.leg[flock.informed]
    if (
        not len(path)
        or not len(legs)
        or flock.engine.surroundings.closed
        or (legs < len(path)).any()
    ):
        return None
    goal = path[-1, : flock.world.dim]
    near = (
        np.linalg.norm(trace[:, flock.informed] - goal, axis=2) <= flock.engine.surroundings.switch
    )
    return int(near.argmax(axis=0).max())


# Observables over a run: a series of each, and what is measured of the series.


@dataclass(frozen=True)
class Series:
    """Observables over a run, one value for each of K observed ticks."""

    tick: np.ndarray
    """(K,) int, rising."""
    agents: np.ndarray
    """Agents that had not crashed, (K,) int."""
    values: dict[str, np.ndarray]
    """Each observable by its name, (K,) float."""

    def over(self, name: str) -> float:
        """An observable of the whole series, such as `susceptibility`. Raises InputError.

        The number of agents is its mean over the series.
        """
        take = OBSERVABLES[name].over if name in OBSERVABLES else None
        if take is None:
            names = [observable.name for observable in OBSERVABLES.values() if observable.over]
            raise unknown("observable over a run", name, names)
        if SERIES not in self.values:
            raise InputError(
                f"{name} is measured from a series of {SERIES}, which was not observed"
            )
        return take(self.values[SERIES], float(self.agents.mean()) if len(self.agents) else 0.0)


class Follower:
    """Collects observables of a running flock at the ticks at which it is called."""

    def __init__(self, flock: Flock, names: Iterable[str]):
        """`names` as `needed` makes them. Raises InputError."""
        self.flock = flock
        self.names = needed(names)
        self.rows: list[list[float]] = []

    def note_values(self) -> None:
        """Note what is observed now."""
        flock = self.flock
        values = [float(flock.observe(name)) for name in self.names]
        self.rows.append([flock.tick, flock.active.sum(), *values])

    @property
    def series(self) -> Series:
        """What has been noted so far."""
        tick, agents, *columns = np.array(self.rows).reshape(-1, 2 + len(self.names)).T
        values = dict(zip(self.names, columns, strict=True))
        return Series(tick.astype(int), agents.astype(int), values)


def needed(names: Iterable[str]) -> list[str]:
    """The observables of which a series is needed, each once.

    Those that are measured over a run stand for the series that they are measured from. Raises
    InputError for an unknown name, or for a table, which has no series.

    >>> needed(["groups", "binder", "susceptibility"])
    ['groups', 'polarisation']
    """
    needed_names: dict[str, None] = {}
    for name in names:
        if name not in OBSERVABLES:
            raise unknown("observable", name, OBSERVABLES)
        observable = OBSERVABLES[name]
        if observable.is_table:
            raise InputError(f"{name} is a table, not a number: it has no series over a run")
        needed_names[SERIES if observable.over else name] = None
    return list(needed_names)


def follow(flock: Flock, ticks: int, names: Iterable[str] = (SERIES,), every: int = 1) -> Series:
    """Run a flock, looking at it every `every` ticks.

    Parameters
    ----------
    ticks: >= 0. Observed are the ticks `every`, 2 `every`, ... from now on; the last may be run
        without being observed.
    names: observables; of those that are measured over a run, the series that they need.
    every: >= 1.

    Raises InputError for an unknown name or for what is out of range, before anything runs.

    >>> from flockscope import Flock
    >>> series = follow(Flock("vem", agents=50, rng=1, eta=3.0), 200)
    >>> 0.0 < series.over("susceptibility") < 50 / 4
    True
    """
    follower = Follower(flock, names)
    ticks, every = whole_number("ticks", ticks, 0), whole_number("every", every, 1)
    for _ in range(ticks // every):
        flock.run(every)
        follower.note_values()
    flock.run(ticks % every)
    return follower.series
