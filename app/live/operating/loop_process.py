"""The process of a control loop: opens its ends, ticks, and ends when its operator is gone."""

from __future__ import annotations

import gc
import multiprocessing
import signal
import sys
import threading
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import TYPE_CHECKING

from app.live.control.arm import UNDOING, OperatorRequest
from app.live.control.control_loop import Loop
from app.live.control.loop_events import Event
from app.live.control.loop_status import Status
from app.live.laboratory.lab_file import lab_from_toml
from app.live.operating.recorder import LoopRecorder, RecordRequest
from worlds.input_error import InputError

if TYPE_CHECKING:
    from app.live.operating.loop_components import Opener

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
            loop.leave(leaving[0])

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
            loop.leave(leaving[0])
        arguments = (line, stops, loop, recorder)
        threading.Thread(target=attend, args=arguments, name="operator", daemon=True).start()
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

    def ask(self, asked: NumberedRequest) -> None:
        """Pass on a request, unless it was overtaken."""
        if asked.request.action == "emergency":
            self.stopped = max(self.stopped, asked.number)
        elif asked.request.action in UNDOING and asked.number < self.stopped:
            self.loop.overtake(asked.request)
            return
        self.loop.ask(asked.request)

    def ask_all(self, stops: Connection) -> None:
        """Pass on the emergency stops that have come."""
        with suppress(EOFError, OSError):
            while stops.poll():
                self.ask(stops.recv())


def attend(line: Connection, stops: Connection, loop: Loop, recorder: LoopRecorder) -> None:
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
                    told = new[:MOST_EVENTS]
                    line.send(LoopReply(loop.latest, tuple(told), count - len(new) + len(told)))
                case None:
                    why = "the operator says so"
                    break
    except (EOFError, OSError):
        pass
    asking.ask_all(stops)
    loop.leave(why)
