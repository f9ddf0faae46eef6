"""One opening of a laboratory's control loop by its page: what is known of it since."""

from __future__ import annotations

import json
import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from app.live.control.arm import OperatorRequest
from app.live.control.loop_status import Event, Status
from app.viewer.live.room_frame import RoomReadings, Setting, frame_of
from app.viewer.scene.shown.frame import Frame
from worlds.input_error import InputError

# Requested changes of parameters that wait for the answer of the control loop.

TIMEOUT = 2.0
"""Seconds that the loop has to answer."""
MOST = 8
"""Changes that may wait: a limit on how fast browsers can make requests."""


@dataclass(frozen=True)
class ParameterChange:
    """A change that waits; each is answered once."""

    request: OperatorRequest
    words: str
    value: Any
    due: float
    answer: Future = field(default_factory=Future)

    def settle(self, refusal: InputError | None = None) -> None:
        """Answer with the value that was taken, or with a refusal."""
        with suppress(InvalidStateError):
            if refusal is None:
                self.answer.set_result(self.value)
            else:
                self.answer.set_exception(refusal)


class ParameterChanges:
    """The changes that wait for an answer, oldest first. Any thread may begin one and end them; one
    hears and settles.

    `notify` is told what was refused and what was not answered.
    """

    def __init__(self, notify: Callable[[str], None], clock: Callable[[], float] = time.monotonic):
        self.notify = notify
        self.clock = clock
        # Browsers begin changes on viser's threads; the room's thread hears what came of them.
        self.lock = threading.Lock()
        self.waiting: list[ParameterChange] = []
        self.heard: list[tuple[ParameterChange, InputError | None]] = []
        """Changes that the loop has answered, with the refusal if there was one."""

    def begin(self, name: str, value: Any, cause: str) -> ParameterChange:
        """A change whose request is to be sent now. Raises InputError if too many wait already."""
        request = OperatorRequest("tune", cause, json.dumps({name: value}))
        change = ParameterChange(request, f"{name} = {value}", value, self.clock() + TIMEOUT)
        with self.lock:
            if len(self.waiting) >= MOST:
                raise InputError(f"{change.words} is too much at once: {MOST} changes wait already")
            self.waiting.append(change)
        return change

    def read_values(self, event: Event) -> dict[str, Any]:
        """The values that the loop took, as an event says; empty if it says nothing of them."""
        if event.asked != "tune":
            return {}
        refused = event.kind != "tune"
        if refused:
            self.notify(event.words)
        change = self.find_change(event)
        if change is not None:
            self.heard.append((change, InputError(event.words) if refused else None))
        accepted: dict[str, Any] = {} if refused else json.loads(event.note)
        return accepted

    def settle(self) -> None:
        """Answer the changes that have been heard of; by now their values are to be seen."""
        heard, self.heard = self.heard, []
        for change, refusal in heard:
            change.settle(refusal)

    def find_change(self, event: Event) -> ParameterChange | None:
        """The change that an event answers, which waits no more; None for somebody else's."""
        with self.lock:
            for change in self.waiting:
                if (change.request.cause, change.request.words) == (event.cause, event.note):
                    self.waiting.remove(change)
                    return change
        return None

    def refuse_late(self) -> None:
        """Refuse what has waited for too long."""
        now = self.clock()
        self.end("has no answer from the control loop", lambda change: change.due <= now)

    def end(self, why: str, which: Callable[[ParameterChange], bool] = lambda _: True) -> None:
        """Refuse what waits."""
        with self.lock:
            over = [change for change in self.waiting if which(change)]
            self.waiting = [change for change in self.waiting if not which(change)]
        for change in over:
            refusal = InputError(f"{change.words} {why}")
            self.notify(str(refusal))
            change.settle(refusal)


SILENCE = 1.0
"""Seconds without a new status after which the loop is said not to answer."""
KEPT = 10
"""Statuses that are kept to measure speeds by."""
BROWSER = "browser"
"""The causes of requests from a browser begin so."""
GONE = "the last browser is gone"
TROUBLES = ("source", "link", "recording")
"""Kinds of event that say what is wrong with these, or that it is over."""


class EventSequence(Protocol):
    """Events as `app.live.control.loop_status.Events` has them, by their number since the first."""

    def __len__(self) -> int: ...
    def __getitem__(self, which: slice, /) -> list[Event]: ...


class OperatorProtocol(Protocol):
    """What a session uses of an `app.live.operating.operator.Operator`."""

    @property
    def events(self) -> EventSequence:
        """What has happened."""
        ...

    trouble: str

    @property
    def alive(self) -> bool:
        """Whether the loop runs."""
        ...

    def ask(self, request: OperatorRequest) -> None:
        """Ask for something."""
        ...

    def place(self, x: float, y: float) -> None:
        """Move the injected car of the hand, m."""
        ...

    def record(self, folder: Path | None, cause: str) -> None:
        """Record in a new folder from now on, or no more."""
        ...

    def status(self) -> Status | None:
        """The newest status."""
        ...

    def close(self) -> None:
        """Stop the cars and end the loop."""
        ...


class LoopConnection:
    """One opening of a control loop; `poll` is called by one thread, again and again."""

    def __init__(
        self,
        setting: Setting,
        operator: OperatorProtocol,
        values: dict[str, Any],
        notify: Callable[[str], None],
    ):
        self.setting = setting
        self.operator = operator
        self.values = values
        """The parameters as the loop has them; replaced, never changed."""
        self.notify = notify
        self.tuning = ParameterChanges(notify)
        self.newest: Status | None = None
        self.status: Status | None = None
        """The status that the frame is drawn from."""
        self.frame: Frame | None = None
        self.readings = RoomReadings(setting.lab.injected)
        self.past: deque[Status] = deque(maxlen=KEPT)
        self.heard = time.monotonic()
        self.known = 0
        """Number of events that have been passed on."""
        self.armed_by = ""
        """Who armed the cars; empty while they are not armed."""
        self.asked_to_hold = False
        """Whether this arming was asked to end because no browser is left."""

    @property
    def is_armed(self) -> bool:
        """Whether the cars are armed, as far as is known."""
        return self.armed_by != "" or (self.status is not None and self.status.arm == "armed")

    def poll(self) -> list[Event]:
        """Ask for the newest status; the events that are new."""
        self.newest = self.operator.status()
        event_count = len(self.operator.events)
        events = self.operator.events[self.known : event_count]
        self.known = event_count
        for event in events:
            self.note_event(event)
        self.tuning.refuse_late()
        return events

    def note_event(self, event: Event) -> None:
        """Note what an event changes, and put up its notice if it has one."""
        words = notice_of(event, self.armed_by)
        if words:
            self.notify(words)
        accepted = self.tuning.read_values(event)
        if accepted:
            self.values = self.values | accepted
        if event.kind == "arm" and not self.armed_by:
            self.armed_by, self.asked_to_hold = event.cause, False
        elif event.kind in ("disarm", "hold", "emergency", "reset"):
            self.armed_by = ""

    def update(self) -> None:
        """Make the frame and the curves of the newest status."""
        status = self.newest
        if status is None or status is self.status:
            return
        self.status = status
        self.heard = time.monotonic()
        self.frame = frame_of(self.setting, status, self.values, tuple(self.past))
        self.readings.note(status)
        self.past.append(status)

    def hold_without_browsers(self) -> None:
        """No browser is left: hold the cars if it was a browser that armed them."""
        if self.armed_by.startswith(BROWSER) and not self.asked_to_hold:
            self.asked_to_hold = True
            self.operator.ask(OperatorRequest("hold", GONE))

    @property
    def end_reason(self) -> str:
        """Why the loop has ended, if it has."""
        if self.operator.trouble:
            return self.operator.trouble
        return "" if self.operator.alive else "the control loop has ended: the cars stop themselves"

    @property
    def describe_silence(self) -> str:
        """The trouble in words if no new status has come for too long; else empty."""
        if time.monotonic() - self.heard < SILENCE:
            return ""
        return "the control loop does not answer: the page shows old values"


def notice_of(event: Event, armed_by: str = "") -> str:
    """The notice in every browser of an event, one line; empty: none, the log has it.

    `armed_by` says who has armed the cars; that a car is not seen is a notice only while armed.

    >>> notice_of(Event(7, 0.07, "emergency", "EMERGENCY STOP", cause="browser 2"))
    'EMERGENCY STOP (browser 2)'
    >>> notice_of(Event(7, 0.07, "run", "the cars run"))
    ''
    """
    if event.kind in ("emergency", "hold"):
        by = "" if event.cause in ("", "safety") else f" ({event.cause})"
        return event.words + by
    if event.kind == "unseen":
        # without how long: a notice that is repeated within seconds is left out
        return f"{event.car} is not seen: the cars stop" if armed_by else ""
    if event.kind in TROUBLES:
        return "" if event.words.endswith("works again") else f"{event.kind}: {event.words}"
    if event.kind == "moves":
        return event.words
    return event.words if event.kind == "refused" and event.asked != "tune" else ""
