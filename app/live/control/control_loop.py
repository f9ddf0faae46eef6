"""The control loop: 100 times a second from tracked poses to commands for the cars.

Its deadlines are absolute, so that it does not drift; those that it misses are left out, never
caught up. It looks at what the source has brought and waits for nobody: neither source nor viewer
nor disk. However it ends, the last thing that it sends is a stop; should it be killed, the cars'
own watchdogs stop them.
"""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Protocol

from app.live.control.arm import UNDOING, OperatorRequest
from app.live.control.car_control import CarControl, ControlStep, TickRecord
from app.live.control.injected_target import InjectedTarget
from app.live.control.loop_status import Durations, Event, Events, Status, cars_of
from app.live.control.pose import MocapFrame, Pose
from app.live.control.safety import Command, SafetyDecision
from app.live.links.firmware import WATCHDOG
from app.live.links.link import EMERGENCY, STOP, CarLink

RATE = 100.0
"""Ticks per second."""
MOST_REQUESTS = 4
"""Requests that are taken in one tick, up to half a millisecond each; the others wait."""
OVERTAKEN = "overtaken by an emergency stop"
PARTING = 5
"""Stop frames that are sent at the end."""
STATUS_EVERY = 3
"""Ticks between which a status is made for the viewer."""


class FrameFeed(Protocol):
    """What the loop reads of a tracking feed; nothing in it waits."""

    @property
    def trouble(self) -> str:
        """What is wrong with the source, in one line; empty while all is well."""
        ...

    def since(self, number: int) -> list[MocapFrame]:
        """The frames after frame `number`, oldest first."""
        ...


class Journal(Protocol):
    """A recording, to which every tick is written; it does not wait either."""

    @property
    def trouble(self) -> str:
        """Why it cannot write, in one line; empty while all is well."""
        ...

    def write(self, moment: TickRecord) -> None:
        """Take down a tick."""
        ...

    def new_lines(self) -> list[str]:
        """What is new of the recording, each in one line."""
        ...


class Loop:
    """Runs the control; `ask`, `place`, `end` and `latest` may be used by any thread."""

    def __init__(
        self,
        control: CarControl,
        feed: FrameFeed,
        link: CarLink,
        addresses: Mapping[str, int],
        injected: InjectedTarget,
        journal: Journal | None = None,
        rate: float = RATE,
        clock: Callable[[], float] = time.monotonic,
        wait: Callable[[float], None] = time.sleep,
    ):
        self.control = control
        self.feed = feed
        self.link = link
        self.addresses = dict(addresses)
        self.injected = injected
        self.journal = journal
        """The recording; another thread may begin and end one."""
        self.period = 1.0 / rate
        self.clock = clock
        self.wait = wait
        self.events = Events()
        self.latest: Status | None = None
        """The status at one of the last few ticks."""
        self.attended: float | None = None
        """When the operator last asked for the status, `time.monotonic()`, s; None: never."""
        self.leaving = ""
        """Why the loop is to end; empty: it is not."""
        self.asked: queue.SimpleQueue[OperatorRequest] = queue.SimpleQueue()
        self.pending: list[OperatorRequest] = []
        """Requests that wait for their turn."""
        self.late: queue.SimpleQueue[OperatorRequest] = queue.SimpleQueue()
        """Requests that arrive after an emergency stop and were made before it."""
        self.overtaken: list[OperatorRequest] = []
        """Requests that an emergency stop has made void in this tick."""
        self.taken = -1
        """The number of the newest frame that a tick has taken."""
        self.before: float | None = None
        self.periods = Durations()
        self.latencies = Durations()
        self.missed = 0
        self.sent = 0
        self.troubles: dict[str, str] = {}
        """What is wrong with the link, the source and the recording."""
        self.known: dict[str, str] = {}
        """Those of them that are in the events already."""

    def ask(self, request: OperatorRequest) -> None:
        """Make a request: it is carried out at the next tick, an emergency stop before all else."""
        self.asked.put(request)

    def note_overtaken(self, request: OperatorRequest) -> None:
        """Note a request that an emergency stop has overtaken; it is not carried out."""
        self.late.put(request)

    def place(self, x: float, y: float) -> None:
        """Move the injected car of the hand, m; kept within the fence. Raises InputError for
        NaN."""
        self.injected.place(x, y)

    def end(self, cause: str) -> None:
        """End the loop after this tick."""
        self.leaving = cause

    def run(self) -> None:
        """Tick until `end` is called; then, or should anything fail, stop the cars."""
        try:
            due = self.clock()
            while not self.leaving:
                self.tick()
                due += self.period
                now = self.clock()
                if now < due:
                    self.wait(due - now)
                else:
                    left_out = int((now - due) / self.period)
                    self.missed += left_out
                    due += left_out * self.period
        except BaseException as error:
            self.leaving = f"it failed: {type(error).__name__}: {' '.join(str(error).split())}"
            raise
        finally:
            self.stop_and_close()

    def tick(self) -> None:
        """One tick, without waiting for its time."""
        now = self.clock()
        if self.before is not None:
            self.periods.add(now - self.before)
        self.before = now
        frames = self.feed.since(self.taken)
        if frames:
            self.taken = frames[-1].number
        self.check_operator(now)
        self.control.begin_tick(now, self.requests(), frames)
        control = self.control
        injected = self.injected.pose_at(now, control.running, control.sightings)
        step = control.end_tick(now, injected)
        self.send(step.verdict.mode, step.verdict.commands)
        latency = None
        if frames:
            latency = self.clock() - frames[-1].received
            self.latencies.add(latency)
        events = (*step.events, *self.trouble_events(now))
        self.events.add(*events)
        arm = control.safety.arm.state
        journal = self.journal
        if journal is not None:
            journal.write(
                TickRecord(control.tick, now, tuple(frames), injected, step, arm, events, latency)
            )
        if control.tick % STATUS_EVERY == 0 or step.events:
            self.latest = self.status(now, injected, step.verdict)

    def check_operator(self, now: float) -> None:
        """Take the arming away where an operator has long been silent: its process hangs."""
        unattended = self.control.safety.limits.unattended
        armed = self.control.safety.arm.state == "armed"
        if armed and self.attended is not None and now - self.attended > unattended:
            words = f"the operator has been silent for {unattended:g} s"
            self.ask(OperatorRequest("hold", "operator", words))

    def requests(self) -> list[OperatorRequest]:
        """The requests to carry out in this tick, emergency stops first.

        Nothing that was asked before an emergency stop may undo it or arm again.
        """
        self.pending += drain_requests(self.asked)
        self.overtaken = drain_requests(self.late)
        urgent = [request for request in self.pending if request.action == "emergency"]
        if urgent:
            last = max(k for k, request in enumerate(self.pending) if request.action == "emergency")
            self.overtaken += [
                request for request in self.pending[:last] if request.action in UNDOING
            ]
            done = {id(request) for request in (*urgent, *self.overtaken)}
            self.pending = [request for request in self.pending if id(request) not in done]
        requests = urgent + self.pending[:MOST_REQUESTS]
        del self.pending[:MOST_REQUESTS]
        return requests

    def send(self, mode: int, commands: Mapping[str, Command]) -> None:
        """Send commands; a link that fails takes the arming away, once more if armed again."""
        self.sent += 1
        try:
            by_address = {self.addresses[name]: command for name, command in commands.items()}
            self.link.send(self.sent % 65536, mode, by_address)
            trouble = ""
        except Exception as error:  # whatever a link does wrong, the loop goes on and says so
            trouble = " ".join(str(error).split()) or type(error).__name__
        if trouble and self.control.safety.arm.state == "armed":
            self.ask(OperatorRequest("hold", "link", trouble))
        self.troubles["link"] = trouble

    def trouble_events(self, now: float) -> list[Event]:
        """Events: requests overtaken, and troubles of source, link and disk that begin or end."""
        events = [
            Event(
                self.control.tick,
                now,
                "refused",
                f"{request.action}: {OVERTAKEN}",
                cause=request.cause,
            )
            for request in self.overtaken
        ]
        self.overtaken = []
        source = self.feed.trouble
        if source and self.control.safety.arm.state == "armed":
            # A source that is opened again may have changed: a person looks at what it tells. That
            # holds also for who arms while its last pose is still fresh.
            self.ask(OperatorRequest("hold", "source", source))
        self.troubles["source"] = source
        journal = self.journal
        self.troubles["recording"] = journal.trouble if journal is not None else ""
        for kind, trouble in self.troubles.items():
            if trouble != self.known.get(kind, ""):
                words = trouble or f"the {kind} works again"
                events.append(Event(self.control.tick, now, kind, words))
                self.known[kind] = trouble
        news = journal.new_lines() if journal is not None else []
        events += [
            Event(self.control.tick, now, "part", words, cause="recording") for words in news
        ]
        return events

    def stop_and_close(self) -> None:
        """Send stops, close the link, record the stops. A latched emergency stop stays latched.

        Recording comes last: whatever has failed, and fails again, delays no stop.
        """
        stop_requests = [
            request for request in drain_requests(self.asked) if request.action == "emergency"
        ]
        state = self.control.safety.arm.state
        latched = state == "emergency" or bool(stop_requests)
        if state == "armed" and not stop_requests:
            stop_requests = [OperatorRequest("hold", "loop", self.leaving)]
        mode = EMERGENCY if latched else STOP
        still = {name: (steer, 0.0) for name, (steer, _) in self.control.safety.sent.items()}
        times = []
        frames = 0
        for _ in range(PARTING):
            dropped = self.link.dropped
            times.append(self.clock())
            self.send(mode, still)
            frames += not self.troubles["link"] and self.link.dropped == dropped
            self.wait(self.period)
        self.link.close()
        end = self.describe_end(frames, latched)
        for left, now in zip(reversed(range(PARTING)), times, strict=True):
            self.record_stop(now, stop_requests, mode, still, "" if left else end)
            stop_requests = []

    def describe_end(self, frames: int, latched: bool) -> str:
        """Why the loop ends and what stops the cars, in words."""
        stop = "an emergency stop" if latched else "to stop"
        message = (
            f"{frames} frames told the cars {stop}"
            if frames
            else f"the link took no stop ({self.troubles['link'] or 'it is busy'}): the cars' own "
            f"watchdogs stop them, {1000 * WATCHDOG:g} ms after their last command"
        )
        return f"the control loop ends ({self.leaving or 'nobody asked it to'}): {message}"

    def record_stop(
        self,
        now: float,
        requests: list[OperatorRequest],
        mode: int,
        still: dict[str, Command],
        end: str,
    ) -> None:
        """Record a stop that was sent at `now` (s), in events and tables: a tick that replays."""
        control = self.control
        injected = None
        try:
            control.begin_tick(now, requests, ())
            injected = self.injected.pose_at(now, control.running, control.sightings)
            step = control.end_tick(now, injected)
        except Exception:  # what has failed before may fail again; what was sent is known
            step = ControlStep({}, SafetyDecision(mode, still, ()), ())
        events = step.events
        if end:
            events = (*events, Event(control.tick, now, "end", end, cause="loop"))
        self.events.add(*events)
        journal = self.journal
        if journal is not None:
            arm = control.safety.arm.state
            journal.write(TickRecord(control.tick, now, (), injected, step, arm, events, None))

    def status(self, now: float, injected: Pose | None, verdict: SafetyDecision) -> Status:
        """What the loop reports of itself at this tick."""
        control, safety = self.control, self.control.safety
        return Status(
            control.tick,
            now,
            safety.arm.state,
            verdict.mode,
            verdict.reasons,
            cars_of(safety, verdict, now),
            injected,
            control.companions,
            self.periods.summary(),
            self.latencies.summary(),
            self.missed,
            self.link.dropped,
            {kind: words for kind, words in self.troubles.items() if words},
            self.events.count,
        )


def drain_requests(waiting: queue.SimpleQueue[OperatorRequest]) -> list[OperatorRequest]:
    """All entries of a queue, which is then empty."""
    requests: list[OperatorRequest] = []
    with suppress(queue.Empty):
        while True:
            requests.append(waiting.get_nowait())
    return requests
