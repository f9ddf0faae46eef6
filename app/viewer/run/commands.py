"""What a simulation can be told, from any thread."""

from __future__ import annotations

import queue
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from typing import Any

import numpy as np

from app.viewer.run.command_queue import CommandQueue, Waiting
from app.viewer.run.edits import Edits
from app.viewer.run.picture import Wanted
from app.viewer.run.start import Start
from app.viewer.run.words import in_words

Models = tuple[str, str | None]
"""Names of the model and of the one beside it."""


class Commands(Edits):
    """Commands return at once and are carried out in order, between two ticks; a pause comes first.

    However much is told, little waits: what comes to the same is merged, and what is too much is
    refused. What a user must be told is left in `notices`.
    """

    def __init__(self) -> None:
        super().__init__()
        self.notices: queue.SimpleQueue[str] = queue.SimpleQueue()
        self.commands = CommandQueue()

    def tell(self, command: Callable[[], Any], key: str = "", runs: bool | None = None) -> Future:
        """Carry out a command between two ticks; what it refuses becomes a notice.

        Of commands with one `key` that follow each other only the last is carried out, as the
        answer to all. `runs` says whether the flock runs afterwards.
        """
        return self.answered(lambda: self.commands.put(command, key, runs))

    def answered(self, put: Callable[[], Future]) -> Future:
        """Let a command wait; if it may not, its answer says so, and a notice."""
        try:
            return put()
        except Exception as error:
            self.notices.put(in_words(error))
            refused: Future = Future()
            refused.set_exception(error)
            return refused

    def carry_out(self, waiting: Waiting) -> None:
        """On the simulation's own thread: do what waits, and answer."""
        try:
            waiting.answer.set_result(waiting())
        except Exception as error:
            self.notices.put(in_words(error))
            waiting.answer.set_exception(error)

    def setup(self, start: Start) -> Future:
        """Build a new flock; of several set-ups at once only the last is built."""
        return self.tell(lambda: self.schedule(start), "set up")

    def reset(self) -> Future:
        """The same flock again: same seed, same start, the parameters as they are now."""
        return self.tell(lambda: self.schedule(self.state.again()), "set up")

    def go(self) -> Future:
        """Run."""
        return self.tell(lambda: self.switch(True), "go", runs=True)

    def pause(self) -> Future:
        """Stop running, before anything else that waits, until told to go."""
        return self.commands.pause(lambda: self.switch(False))

    def toggle(self) -> Future:
        """Pause if it runs once all is done that waits, go if not."""
        return self.pause() if self.commands.will_run(self.state.running) else self.go()

    def step(self, ticks: int = 1) -> Future:
        """Pause and run a few ticks; with those that wait already never very many."""
        return self.answered(lambda: self.commands.step(self.step_now, ticks))

    def run_at(self, speed: float) -> Future:
        """Run at so many ticks per second; infinity for as fast as it goes."""
        return self.tell(lambda: self.change_pace(speed), "pace")

    def set(
        self, name: str, value: Any, beside: bool = False, models: Models | None = None
    ) -> Future:
        """Give a parameter a new value, in both flocks if they share it; or only `beside`.

        The answer is the value that it has taken: a zone stops at the next one, which is told. If
        `models` are given, and others have come since, nothing is done.
        """
        key = f"set {name} {beside} {models}"
        return self.tell(lambda: self.set_now(name, value, beside, models), key)

    def place(self, row: int, position: np.ndarray, heading: np.ndarray) -> Future:
        """Put an agent somewhere and turn it."""
        return self.tell(lambda: self.place_now(row, position, heading), f"place {row}")

    def want(self, wanted: Wanted) -> Future:
        """Say what frames should hold beside positions and headings."""
        return self.tell(lambda: self.want_now(wanted), "want")

    def watch(self, names: Iterable[str]) -> Future:
        """Say which observables should be measured beside those that always are."""
        chosen = frozenset(names)
        return self.tell(lambda: self.watch_now(chosen), "watch")

    def look_again(self) -> Future:
        """Take another frame, though nothing has moved."""
        return self.tell(self.look_again_now, "look again")

    def spec(self) -> Future:
        """The run as TOML, bytes; of two flocks a ZIP of both."""
        return self.tell(lambda: self.sound_run().spec(), "spec")

    def saved(self) -> Future:
        """The flock's saved state, bytes; of two flocks a ZIP of both."""
        return self.tell(lambda: self.sound_run().saved(), "saved")

    # What the simulation's own thread does about them.

    def switch(self, on: bool) -> None:
        raise NotImplementedError

    def step_now(self, ticks: int) -> None:
        raise NotImplementedError

    def change_pace(self, speed: float) -> None:
        raise NotImplementedError

    def set_now(self, name: str, value: Any, beside: bool, models: Models | None) -> Any:
        raise NotImplementedError

    def place_now(self, row: int, position: np.ndarray, heading: np.ndarray) -> None:
        raise NotImplementedError

    def want_now(self, wanted: Wanted) -> None:
        raise NotImplementedError

    def watch_now(self, names: frozenset[str]) -> None:
        raise NotImplementedError

    def look_again_now(self) -> None:
        raise NotImplementedError
