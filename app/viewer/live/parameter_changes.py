"""Requested changes of parameters that wait for the answer of the control loop."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from app.live.control.arm import OperatorRequest
from app.live.control.loop_events import Event
from worlds.input_error import InputError

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

    def hear(self, event: Event) -> dict[str, Any]:
        """The values that the loop took, as an event says; empty if it says nothing of them."""
        if event.asked != "tune":
            return {}
        refused = event.kind != "tune"
        if refused:
            self.notify(event.words)
        change = self.found(event)
        if change is not None:
            self.heard.append((change, InputError(event.words) if refused else None))
        taken: dict[str, Any] = {} if refused else json.loads(event.note)
        return taken

    def settle(self) -> None:
        """Answer the changes that have been heard of; by now their values are to be seen."""
        heard, self.heard = self.heard, []
        for change, refusal in heard:
            change.settle(refusal)

    def found(self, event: Event) -> ParameterChange | None:
        """The change that an event answers, which waits no more; None for somebody else's."""
        with self.lock:
            for change in self.waiting:
                if (change.request.cause, change.request.words) == (event.cause, event.note):
                    self.waiting.remove(change)
                    return change
        return None

    def give_up(self) -> None:
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
