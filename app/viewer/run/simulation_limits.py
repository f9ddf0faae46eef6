"""Keeps a flock's thread to what it may take of a machine that many share."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable

from agents.spec import CompleteSpec, Spec
from app.front.client_addresses import RateLimit
from app.viewer.run.allowance import Allowance
from app.viewer.run.flock_run import FlockRun
from app.viewer.run.stored_flock import InitialState
from worlds.input_error import InputError
from worlds.world import World

# How many ticks to run now, so that a run keeps its speed and commands are answered soon.

ANSWER = 0.02
"""Longest time to spend in one call of the flock, s; commands wait for it."""
WINDOW = 1.5
"""Time over which the rate is measured, s."""


class Pace:
    """Shares time out into ticks: `speed` ticks/s, infinity for as fast as it goes."""

    def __init__(self, speed: float, answer: float = ANSWER):
        """`answer` is the longest time to spend in one call of the flock, s."""
        self.speed = speed
        self.answer = answer
        self.timeout = 0.0
        """For how long ticks that are due may wait for others, s: many at once cost less."""
        self.cost = answer
        """Seconds per tick, as measured."""
        self.due = 0.0
        self.done = 0
        self.marks: deque[tuple[float, int]] = deque()

    def restart(self) -> None:
        """Start to count afresh: the next tick is due at once."""
        self.due = 0.0
        self.marks.clear()
        self.reset_cost()

    def wait(self, now: float) -> float:
        """Time until the next tick is due, s."""
        if math.isinf(self.speed):
            return 0.0
        return max(0.0, self.due + self.timeout - now)

    def ticks_due(self, now: float) -> int:
        """Ticks to run now; a run that cannot keep up does not try to catch up."""
        most = max(1, int(self.answer / self.cost))
        if math.isinf(self.speed):
            return most
        if self.due == 0.0:
            self.due = now
        if now < self.due:
            return 0
        ticks = min(most, 1 + int((now - self.due) * self.speed))
        self.due += ticks / self.speed
        if self.due < now - 0.25 - self.timeout:
            self.due = now
        return ticks

    def reset_cost(self) -> None:
        """Something has changed: run a single tick next, to see what one costs now."""
        self.cost = self.answer

    def note_ticks(self, ticks: int, seconds: float) -> None:
        """Note how long ticks took: a rise is believed at once, a fall by halves."""
        self.cost = max(seconds / ticks, 0.5 * self.cost, 1e-7)
        self.done += ticks

    def rate(self, now: float) -> float:
        """Ticks per second over the last WINDOW, ticks/s."""
        self.marks.append((now, self.done))
        while len(self.marks) > 2 and self.marks[1][0] < now - WINDOW:
            self.marks.popleft()
        (then, before), (last, after) = self.marks[0], self.marks[-1]
        return (after - before) / (last - then) if last > then else 0.0


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

    def set_share(self, share: float) -> None:
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
            self.share.set_share(allowance.share)
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
    def frame_interval(self) -> float:
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
            self.share.set_share(self.allowance.share if self.seen else self.allowance.unseen_share)

    def demand(self, spec: CompleteSpec, beside: Spec | None, stored: InitialState | None) -> None:
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
        for flock_run in run.both:
            for limit in (
                flock_run.readings.quick,
                flock_run.readings.slow,
                flock_run.camera.rate_limit,
            ):
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
