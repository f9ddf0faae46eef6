"""Keeps a flock's thread to what it may take of a machine that many share."""

from __future__ import annotations

import time
from collections.abc import Callable

from agents.spec import Spec
from app.viewer.run.allowance import Allowance
from app.viewer.run.flock_run import FlockRun
from app.viewer.run.pace import ANSWER, Pace
from app.viewer.run.past.stored_flock import Beginning
from app.viewer.web.incoming.rate_limit import RateLimit
from worlds.input_error import InputError
from worlds.world import World

FRAMES = 1 / 50
"""Shortest time between two frames, s."""
LONGEST = 2.0
"""Seconds at most for which a flock stands because it has taken more than its share, and of whose
share it may take as much at once."""
BATCH = 1.0
"""Time for which ticks wait for others while nobody looks, s."""
EDITS_AT_ONCE = 10.0
"""Changes of a world at once."""
MEASURING = 0.2
"""The part of the share that is for what is measured aside, and as much for what is examined."""


class Share:
    """Keeps a thread to a share of a core: what it has taken too much, it waits for.

    >>> now, worked = [0.0], [0.0]
    >>> share = Share(0.1, lambda: now[0], lambda: worked[0])
    >>> worked[0] = 0.25  # 0.2 of it are free
    >>> share.note()
    >>> round(share.wait(), 3)
    0.5
    """

    def __init__(
        self,
        share: float,
        clock: Callable[[], float] = time.monotonic,
        worked: Callable[[], float] = time.thread_time,
    ):
        """`worked` says how long the thread has worked, s; it is that thread that asks."""
        self.limit = RateLimit(share, LONGEST * share, clock)
        self.worked = worked
        self.known = 0.0

    def note(self) -> None:
        """Count what the thread has worked since it was last asked."""
        now = self.worked()
        self.limit.owe(now - self.known, LONGEST * self.limit.rate)
        self.known = now

    def wait(self) -> float:
        """Seconds until it may go on."""
        return max(0.0, -self.limit.fill() / self.limit.rate)

    def become(self, share: float) -> None:
        """Have it keep to another share from now on."""
        self.limit.fill()
        self.limit.rate, self.limit.most = share, LONGEST * share


class SimulationLimits:
    """Says when a simulation may go on, and what it may build; without an allowance all it wants.

    It belongs to the simulation's thread, but for `seen`.
    """

    def __init__(self, allowance: Allowance | None):
        self.allowance = allowance
        self.seen = True
        """Whether somebody looks, or may."""
        self.share = Share(1.0)
        self.edits: RateLimit | None = None
        if allowance is not None:
            self.share.become(allowance.share)
            self.edits = RateLimit(allowance.edits, EDITS_AT_ONCE)

    def note(self) -> None:
        """The thread has been round once more."""
        if self.allowance is not None:
            self.share.note()

    @property
    def wait(self) -> float:
        """Seconds until it may go on, having taken more than its share."""
        return 0.0 if self.allowance is None else self.share.wait()

    @property
    def between_frames(self) -> float:
        """Shortest time between two frames, s."""
        if self.allowance is None:
            return FRAMES
        return 1.0 / self.allowance.pictures if self.seen else self.allowance.unseen

    def pace(self, speed: float) -> Pace:
        """What has it run at so many ticks/s."""
        if self.allowance is None:
            return Pace(speed)
        pace = Pace(speed, min(ANSWER, self.allowance.share / self.allowance.pictures))
        pace.timeout = 0.0 if self.seen else BATCH
        return pace

    def look(self) -> None:
        """Somebody looks now, or nobody any more."""
        if self.allowance is not None:
            self.share.become(self.allowance.share if self.seen else self.allowance.unseen_share)

    def demand(self, spec: Spec, beside: Spec | None, stored: Beginning | None) -> None:
        """Raise InputError for a run that is too much, before it is built."""
        if self.allowance is not None:
            self.allowance.demand(spec, beside, stored)

    def take(self, run: FlockRun) -> None:
        """Raise InputError for what was built and is too much after all; what is not, is measured
        no more often and for no longer than is allowed."""
        allowance = self.allowance
        if allowance is None:
            return
        allowance.demand_world(run.flock.world)
        for one in run.both:
            for limit in (one.readings.quick, one.readings.slow, one.camera.rate_limit):
                limit.period = max(limit.period, allowance.panels)
                limit.share = MEASURING * allowance.share

    def demand_turn(self) -> None:
        """Raise InputError if a world has been changed too often of late."""
        if self.allowance is not None and self.edits is not None and not self.edits.take():
            raise InputError(
                f"a class allows {self.allowance.edits:g} changes of the world a second: go slower"
            )

    def demand_world(self, world: World, before: World) -> None:
        """Raise InputError for a world with too many obstacles, if there are more than before."""
        if self.allowance is not None and len(world.obstacles) > len(before.obstacles):
            self.allowance.demand_world(world)
