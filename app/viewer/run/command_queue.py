"""What waits to be carried out by a simulation: bounded, and merged where it comes to the same."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any

from worlds.input_error import InputError

MOST = 64
"""Commands that may wait, and beyond them one of each key: whoever fills the queue cannot keep
others from setting up."""
MOST_TICKS = 10
"""Ticks that may wait to be stepped, unless one command asks for more."""
GO = "go"
STEP = "step"


@dataclass
class QueuedCommand:
    """A command that waits; those that are merged have one answer."""

    work: Callable[..., Any]
    key: str = ""
    """Commands of one key that follow each other are one, the last; empty: each for itself."""
    runs: bool | None = None
    """Whether the flock runs after it; None: as before."""
    ticks: int = 0
    """Of a step: how many."""
    answer: Future = field(default_factory=Future)

    def __call__(self) -> Any:
        return self.work(self.ticks) if self.key == STEP else self.work()


class CommandQueue:
    """First come, first served, but for a pause, which comes before all; any thread may use it."""

    def __init__(self) -> None:
        self.waiting: deque[QueuedCommand] = deque()
        self.changed = threading.Condition()

    def put(self, work: Callable[[], Any], key: str = "", runs: bool | None = None) -> Future:
        """Have something done. Raises InputError if too much waits already, and it has no key."""
        with self.changed:
            same = self.waiting_command(key)
            if same is not None:
                same.work, same.runs = work, runs
                return same.answer
            return self.add(QueuedCommand(work, key, runs))

    def step(self, work: Callable[[int], Any], ticks: int) -> Future:
        """Have ticks run: with those that wait already at most `MOST_TICKS`."""
        with self.changed:
            same = self.waiting_command(STEP)
            if same is not None:
                same.ticks = max(same.ticks, min(same.ticks + ticks, MOST_TICKS), ticks)
                return same.answer
            return self.add(QueuedCommand(work, STEP, False, ticks))

    def pause(self, work: Callable[[], Any]) -> Future:
        """Have the flock stand still before anything else is done; what waits and would move it
        is left out."""
        with self.changed:
            moving = [command for command in self.waiting if command.key in (GO, STEP)]
            self.waiting = deque(
                command for command in self.waiting if command.key not in (GO, STEP)
            )
            for command in moving:
                command.answer.set_result(None)
            first = self.waiting[0] if self.waiting else None
            if first is not None and first.key == "pause":
                return first.answer
            pausing = QueuedCommand(work, "pause", False)
            self.waiting.appendleft(pausing)
            self.changed.notify()
            return pausing.answer

    def waiting_command(self, key: str) -> QueuedCommand | None:
        """What waits and is one with a new command of this key: the last of all, or where too much
        waits the last of its key."""
        if not key or not self.waiting:
            return None
        near = self.waiting if len(self.waiting) >= MOST else [self.waiting[-1]]
        return next((command for command in reversed(near) if command.key == key), None)

    def add(self, command: QueuedCommand) -> Future:
        """Let a command wait, one of each key in any case. Raises InputError if too many do."""
        if len(self.waiting) >= MOST and not command.key:
            raise InputError(f"too much at once: {MOST} commands wait already")
        self.waiting.append(command)
        self.changed.notify()
        return command.answer

    def wake(self) -> None:
        """Let whoever waits for a command go on without one."""
        with self.changed:
            self.waiting.appendleft(QueuedCommand(lambda: None))
            self.changed.notify()

    def get(self, timeout: float | None) -> QueuedCommand | None:
        """The next command, as soon as there is one; None if there is none in `timeout` s."""
        with self.changed:
            self.changed.wait_for(lambda: self.waiting, timeout)
            return self.waiting.popleft() if self.waiting else None

    def will_run(self, runs: bool) -> bool:
        """Whether the flock runs once all is done that waits, if now it does or not."""
        with self.changed:
            wishes = [command.runs for command in self.waiting if command.runs is not None]
        return wishes[-1] if wishes else runs
