"""What may be asked of a room, from any thread; nothing of it waits, and nothing raises."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from app.live.control.arm import Request, Wish
from app.live.operating.choices import Choices
from app.viewer.live.opened import Opened
from app.viewer.live.room_state import RoomState
from app.viewer.live.wanted import number, parameter_value, whole_number, word
from app.viewer.run.words import in_words
from worlds.refusal import Refusal

ASKED: dict[str, Wish] = {"arm": "arm", "disarm": "disarm", "reset": "reset"}
"""What may be asked with `ask`."""
CLOSED = "was not answered: the room was closed"
"""What becomes of changes that wait then."""


class Asking:
    """The near side of a room. What is refused becomes a notice."""

    def __init__(self, choices: Choices):
        self.lab = choices.lab
        self.state = RoomState(choices.source, choices.link, choices.rule)
        self.notices: queue.SimpleQueue[str] = queue.SimpleQueue()
        """What must be told in browsers."""
        self.chosen = choices.choosing()
        """What was chosen last."""
        self.next: tuple[Choices, str] | None = self.chosen, ""
        """What is to be opened next, and who chose it."""
        self.opened: Opened | None = None
        self.changing = threading.Lock()
        """Of the state and of what is chosen; held for moments only."""
        self.latch = ""
        """Who asked for an emergency stop that was not reset: the next opening begins with it."""
        self.closing = threading.Event()
        self.woken = threading.Event()

    def ask(self, wish: str, cause: str) -> None:
        """Arm, disarm or reset."""
        with self.telling():
            wanted = ASKED[word("request", wish, ASKED)]
            if wanted == "arm" and self.next is not None:
                raise Refusal("cannot be armed: another room is about to be opened")
            self.open_one().desk.ask(Request(wanted, cause))

    def emergency(self, cause: str) -> None:
        """Stop the cars now, and latched. While no desk is open the next begins so."""
        with self.telling():
            self.latch = cause or "the page"
            opened = self.opened
            if opened is not None:
                opened.desk.ask(Request("emergency", cause))
            else:
                self.notices.put(f"EMERGENCY STOP ({cause}): the next room begins with it")
            self.change(latched=True)

    def tune(self, name: str, value: Any, cause: str) -> Future:
        """Give a parameter of the rule a new value; the answer is the one that the loop took."""
        answer: Future = Future()
        try:
            opened = self.open_one()
            taken = parameter_value(opened.setting.model, opened.values, name, value)
            change = opened.tuning.begin(name, taken, cause)
            opened.desk.ask(change.request)
            if self.opened is not opened:  # closed meanwhile: nobody would answer
                opened.tuning.end(CLOSED)
        except Exception as error:
            self.notices.put(in_words(error))
            answer.set_exception(error)
            return answer
        return change.answer

    def accompany(self, count: int, cause: str) -> None:
        """Have so many simulated cars beside the real ones."""
        with self.telling():
            found = whole_number("simulated cars", count, self.lab.simulated.most)
            self.open_one().desk.ask(Request("accompany", cause, str(found)))

    def place(self, x: float, y: float) -> None:
        """Move the injected car of the hand, m; the loop keeps it within the fence."""
        with self.telling():
            at = number("x", x), number("y", y)
            opened = self.opened
            if opened is not None:
                opened.desk.place(*at)

    def choose(
        self,
        source: str | None = None,
        link: str | None = None,
        rule: str | None = None,
        cause: str = "",
    ) -> None:
        """Close the room and open another; what is not given stays.

        The names are those of `app.live.operating.choices`. Not while the cars are
        armed. Of several choices at once only the last is opened.
        """
        asked = {"source": source, "link": link, "rule": rule}
        with self.telling():
            opened = self.opened
            if self.closing.is_set():
                raise Refusal("the room is closed")
            if opened is not None and opened.armed:
                raise Refusal("no other room is opened while the cars are armed: disarm them first")
            with self.changing:
                last = self.chosen
            made = last.choosing(
                **{
                    kind: word(kind, name, last.offered[kind])
                    for kind, name in asked.items()
                    if name is not None
                }
            )
            with self.changing:
                self.chosen, self.next = made, (made, cause)
            self.woken.set()

    def reopen(self, cause: str) -> None:
        """Close the room, if it is open, and open it again."""
        self.choose(cause=cause)

    def browsers(self, count: int) -> None:
        """Say how many browsers are open: armed by a browser, the cars stop when none is left."""
        opened = self.opened
        if count == 0 and opened is not None:
            opened.deserted()

    # What helps them.

    @contextmanager
    def telling(self) -> Iterator[None]:
        """Whatever is raised within becomes a notice."""
        try:
            yield
        except Exception as error:
            self.notices.put(in_words(error))

    def open_one(self) -> Opened:
        """The opening. Raises Refusal if there is none."""
        opened = self.opened
        if opened is None:
            raise Refusal(f"the room is not open ({self.state.status})")
        return opened

    def change(self, **changes: Any) -> None:
        """Change the state; a closed room stays closed."""
        with self.changing:
            if self.state.status == "closed":
                changes.pop("status", None)
            self.state = replace(self.state, **changes)
