"""The process of a control loop: opens its ends, ticks, and ends when its operator is gone."""

from __future__ import annotations

import gc
import multiprocessing
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path

from app.live.control.arm import UNDOING, OperatorRequest
from app.live.control.car_control import CarControl
from app.live.control.control_loop import FrameFeed, Journal, Loop
from app.live.control.injected_target import InjectedTarget
from app.live.control.loop_status import Event, Status
from app.live.control.pose import Driver
from app.live.device_kinds import SIMULATED, kind_of
from app.live.emulation.emulated_room import open_emulated
from app.live.laboratory.lab_file import Lab, lab_from_toml
from app.live.links.link import CarLink
from app.live.links.link_catalogue import open_link
from app.live.operating.recorder import LoopRecorder, RecordRequest
from app.live.sources.feed import Feed
from app.live.sources.pose_source import Source
from app.live.sources.source_catalogue import open_source
from worlds.input_error import InputError

# What the control loop of a laboratory stands between: source of poses, link, and driver.

TIMEOUT = 90.0
"""Seconds that the source of emulated cars may take to begin."""
Opener = Callable[[Lab], "LoopComponents"]
"""Opens source, link and driver in the process of the loop: a function of a module."""


@dataclass(frozen=True)
class LoopComponents:
    """The source, the link and the driver of a laboratory, open."""

    feed: FrameFeed
    link: CarLink
    driver: Driver

    def loop(self, lab: Lab, journal: Journal | None = None) -> Loop:
        """The control loop of the laboratory between these ends, unarmed."""
        return Loop(
            CarControl(lab.safety(), self.driver),
            self.feed,
            self.link,
            lab.addresses,
            InjectedTarget(lab.injected, lab.area),
            journal,
            lab.rate,
        )

    def close(self) -> None:
        """Close the source; the loop has closed the link."""
        if isinstance(self.feed, Feed):
            self.feed.close()


def open_ends(lab: Lab, driver: Driver) -> LoopComponents:
    """The source and the link of a laboratory, open, with this driver. Raises InputError."""
    source, link = source_and_link(lab)
    try:
        feed = Feed(source, TIMEOUT) if kind_of(lab.source) == SIMULATED else Feed(source)
        return LoopComponents(feed, link, driver)
    except BaseException:
        link.close()
        raise


def source_and_link(lab: Lab) -> tuple[Source, CarLink]:
    """The source of a laboratory, not yet connected, and its link, open. Raises InputError."""
    if kind_of(lab.source) == SIMULATED:
        return open_emulated(lab)
    source = open_source(lab.source)
    return source, open_link(lab.link)


LEAVES = ("SIGTERM", "SIGINT", "SIGHUP")
"""Signals at which it stops the cars and leaves."""
SWITCH = 0.0005
"""Seconds after which another thread gives way to the loop; Python's own 5 ms is half a tick."""
MOST_EVENTS = 100
"""Events in one answer; the others come with the next."""


@dataclass(frozen=True)
class LoopReply:
    """What the loop reports to its operator, when asked."""

    status: Status | None = None
    events: tuple[Event, ...] = ()
    known: int = 0
    """Number of events up to the last of these."""
    trouble: str = ""
    """Why the loop cannot begin."""


@dataclass(frozen=True)
class NumberedRequest:
    """A request of the operator with its number."""

    number: int
    """Requests are counted: an emergency stop has a way of its own and overtakes others."""
    request: OperatorRequest


def serve(
    laboratory: str, opener: Opener, recording: Path | None, line: Connection, stops: Connection
) -> None:
    """Run the control loop of a laboratory (its TOML) until the operator ends it or is gone.

    `line` leads to the operator, both ways; `stops` brings its emergency stops.
    """
    leaving: list[str] = []
    loop: Loop | None = None

    def leave(number: int, _frame: object) -> None:
        leaving.append(signal.Signals(number).name)
        if loop is not None:
            loop.end(leaving[0])

    for name in LEAVES:
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), leave)
    sys.setswitchinterval(SWITCH)
    with ExitStack() as stack:
        try:
            lab = lab_from_toml(laboratory, "the laboratory")
            ends = stack.enter_context(closing(opener(lab)))
            recorder = stack.enter_context(LoopRecorder(laboratory, lab.recording))
            journal = None if recording is None else recorder.begin(recording)
        except InputError as refusal:
            line.send(LoopReply(trouble=str(refusal)))
            return
        recorder.loop = loop = ends.loop(lab, journal)
        if leaving:
            loop.end(leaving[0])
        arguments = (line, stops, loop, recorder)
        threading.Thread(
            target=serve_operator, args=arguments, name="operator", daemon=True
        ).start()
        line.send(LoopReply())
        gc.collect()
        gc.freeze()  # so that later collections are short: they look at what a run makes
        loop.run()


class RequestForwarder:
    """Passes on to a loop the requests of two connections: one that was made before an emergency
    stop does not undo it, though it may arrive after it."""

    def __init__(self, loop: Loop):
        self.loop = loop
        self.stopped = 0
        """The number of the last emergency stop."""

    def ask(self, numbered: NumberedRequest) -> None:
        """Pass on a request, unless it was overtaken."""
        if numbered.request.action == "emergency":
            self.stopped = max(self.stopped, numbered.number)
        elif numbered.request.action in UNDOING and numbered.number < self.stopped:
            self.loop.note_overtaken(numbered.request)
            return
        self.loop.ask(numbered.request)

    def ask_all(self, stops: Connection) -> None:
        """Pass on the emergency stops that have come."""
        with suppress(EOFError, OSError):
            while stops.poll():
                self.ask(stops.recv())


def serve_operator(line: Connection, stops: Connection, loop: Loop, recorder: LoopRecorder) -> None:
    """Pass on the operator's requests, emergency stops first, and answer it; the loop ends when the
    operator is gone."""
    parent = multiprocessing.parent_process()
    watched: list[Connection | int] = [line, stops]
    if parent is not None:
        watched.append(parent.sentinel)
    asking = RequestForwarder(loop)
    why = "the operator is gone"
    try:
        while line in (ready := wait(watched)) or stops in ready:
            if stops in ready:
                asking.ask(stops.recv())
                continue
            match line.recv():
                case NumberedRequest() as asked:
                    asking.ask(asked)
                case RecordRequest() as wanted:
                    recorder.ask(wanted)
                case (int(known), hand):
                    loop.attended = loop.clock()
                    if hand is not None:
                        loop.place(*hand)  # the operator has checked that these are numbers
                    count, new = loop.events.since(known)
                    sent_events = new[:MOST_EVENTS]
                    line.send(
                        LoopReply(
                            loop.latest, tuple(sent_events), count - len(new) + len(sent_events)
                        )
                    )
                case None:
                    why = "the operator says so"
                    break
    except (EOFError, OSError):
        pass
    asking.ask_all(stops)
    loop.end(why)
