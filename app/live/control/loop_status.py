"""What the control loop reports of itself at a tick, for the viewer and the terminal."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, overload

import numpy as np

from app.live.control.arm import State
from app.live.control.pose import Companion, Pose
from app.live.control.safety import Command, Safety, SafetyDecision, StopReason
from app.live.links.link import RUN

# How long the control loop takes: its periods, and how old its commands' poses are when sent.

DURATIONS_KEPT = 1000
"""Values that a summary is of: 10 s at 100 Hz."""


@dataclass(frozen=True)
class DurationSummary:
    """Median, 99th percentile and maximum of the last durations, s; NaN where there are none."""

    median: float
    late: float
    """Exceeded by one in a hundred."""
    worst: float

    @staticmethod
    def of(durations: np.ndarray) -> DurationSummary:
        """The summary of durations (N,), s; those that are NaN are left out."""
        finite = durations[np.isfinite(durations)]
        if not len(finite):
            return DurationSummary(np.nan, np.nan, np.nan)
        return DurationSummary(
            float(np.median(finite)),
            float(np.quantile(finite, 0.99, method="higher")),
            float(finite.max()),
        )


class Durations:
    """The last durations of something that recurs."""

    def __init__(self) -> None:
        self.values = np.empty(DURATIONS_KEPT)
        self.count = 0

    def add(self, seconds: float) -> None:
        """Add a duration, s."""
        self.values[self.count % DURATIONS_KEPT] = seconds
        self.count += 1

    def summary(self) -> DurationSummary:
        """Their summary.

        >>> durations = Durations()
        >>> for seconds in (0.01, 0.01, 0.04):
        ...     durations.add(seconds)
        >>> durations.summary().median, durations.summary().worst
        (0.01, 0.04)
        """
        return DurationSummary.of(self.values[: min(self.count, DURATIONS_KEPT)])


# Events of a laboratory, each with its time, its words and its cause.

EVENTS_KEPT = 10_000
"""Events that are kept in memory; the recording has them all."""


@dataclass(frozen=True)
class Event:
    """Something that happened."""

    tick: int
    """Tick of the control loop."""
    time: float
    """`time.monotonic()` of the machine that runs the loop, s."""
    kind: str
    """Of which kind: a request (`arm`, `emergency`, ...), a reason to stop, or `run`, `stop`."""
    words: str
    """The event in words."""
    car: str = ""
    """The car that it is about; empty: all."""
    cause: str = ""
    """Who or what caused it, where that is not the loop itself."""
    asked: str = ""
    """The request that it answers; with `cause` and `note` all that a replay needs."""
    note: str = ""
    """What the request said."""


class Events:
    """All events, of which the newest are kept; one thread writes, any may read.

    It is read as a list is, and counts from the first event that there ever was: those that are no
    longer kept are left out of a slice, and change the place of no other.

    >>> log = Events(limit=2)
    >>> for tick, kind in enumerate(("arm", "run", "stop")):
    ...     log.add(Event(tick, 0.01 * tick, kind, kind))
    >>> len(log), [event.kind for event in log[0:]], [event.kind for event in log[2:]]
    (3, ['run', 'stop'], ['stop'])
    """

    def __init__(self, limit: int = EVENTS_KEPT) -> None:
        self.count = 0
        self.kept: deque[Event] = deque(maxlen=limit)
        # The count and the events that are kept change together: a reader must not see one alone.
        self.lock = threading.Lock()

    def add(self, *events: Event) -> None:
        """Write events down."""
        with self.lock:
            self.kept.extend(events)
            self.count += len(events)

    def since(self, count: int) -> tuple[int, list[Event]]:
        """How many there are, and those after the first `count` as far as they are kept.

        >>> log = Events()
        >>> log.add(Event(0, 0.0, "run", "runs"), Event(1, 0.01, "stop", "stops"))
        >>> [event.kind for event in log.since(1)[1]]
        ['stop']
        """
        with self.lock:
            new = min(self.count - count, len(self.kept))
            return self.count, list(self.kept)[len(self.kept) - new :] if new > 0 else []

    @property
    def dropped(self) -> int:
        """How many are no longer kept."""
        with self.lock:
            return self.count - len(self.kept)

    def __len__(self) -> int:
        return self.count

    def __iter__(self) -> Iterator[Event]:
        return iter(self[:])

    @overload
    def __getitem__(self, which: int, /) -> Event: ...
    @overload
    def __getitem__(self, which: slice, /) -> list[Event]: ...
    def __getitem__(self, which: int | slice, /) -> Event | list[Event]:
        with self.lock:
            dropped = self.count - len(self.kept)
            if isinstance(which, int):
                place = range(self.count)[which] - dropped
                if place < 0:
                    raise IndexError(f"event {which} is no longer kept")
                return self.kept[place]
            places = range(self.count)[which]
            return [self.kept[place - dropped] for place in places if place >= dropped]


LATE = 0.03
"""Seconds since it was last seen after which a car is late: three frames at 100 Hz."""
Tracking = Literal["tracked", "late", "lost"]


@dataclass(frozen=True)
class CarStatus:
    """One car at a tick."""

    name: str
    pose: Pose | None
    """Where it was last seen."""
    age: float
    """Seconds since then; infinite if it never was."""
    tracking: Tracking
    runs: bool
    """Whether the command sent to it was to run."""
    sent: Command

    @property
    def state(self) -> str:
        """tracked, late, lost or stopped; lost before stopped before late."""
        if self.tracking == "lost":
            return "lost"
        return self.tracking if self.runs else "stopped"


@dataclass(frozen=True)
class Status:
    """The control loop and its cars at one tick."""

    tick: int
    time: float
    """`time.monotonic()` of the machine that runs the loop, s."""
    arm: State
    mode: int
    reasons: tuple[StopReason, ...]
    """Why the cars do not run, or could not be armed."""
    cars: tuple[CarStatus, ...]
    injected: Pose | None
    companions: tuple[Companion, ...]
    """The simulated cars beside them."""
    period: DurationSummary
    """Seconds from tick to tick."""
    latency: DurationSummary
    """Seconds from the arrival of a frame to the commands that it leads to."""
    missed: int
    """Ticks left out because their deadline had passed, in all."""
    dropped: int
    """Frames that the link did not send, in all."""
    troubles: dict[str, str]
    """What is wrong with the source, the link and the recording, by these names."""
    events: int
    """Number of events so far."""


def cars_of(safety: Safety, verdict: SafetyDecision, now: float) -> tuple[CarStatus, ...]:
    """The status of each car at `now` (s)."""
    return tuple(
        CarStatus(
            name,
            safety.seen.last[name].pose if name in safety.seen.last else None,
            safety.seen.age(name, now),
            tracking(safety.seen.age(name, now), safety.limits.stale),
            verdict.mode == RUN,
            verdict.commands[name],
        )
        for name in safety.cars
    )


def tracking(age: float, stale: float) -> Tracking:
    """Whether a car is tracked, late or lost, by the age (s) of its last pose.

    >>> tracking(0.02, stale=0.1), tracking(0.09, stale=0.1), tracking(0.11, stale=0.1)
    ('tracked', 'late', 'lost')
    """
    if age > stale:
        return "lost"
    return "late" if age > LATE else "tracked"
