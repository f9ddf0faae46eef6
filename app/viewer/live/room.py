"""A laboratory as its page sees it."""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import Protocol

from agents.declare import Parameters
from agents.model import Model
from app.live.control.arm import Request
from app.live.control.events import Event, Events
from app.live.control.look import Look
from app.live.laboratory.lab import Lab
from app.live.operating.desk import Desk
from app.live.operating.driven import open_driven
from app.live.operating.ends import Opener
from app.live.operating.squashing_driver import FlockDriver
from app.viewer.live.arming_code import ArmingCode, Verdict
from app.viewer.live.asking import CLOSED, Asking
from app.viewer.live.folders import new_folder
from app.viewer.live.framing import Setting, deserted
from app.viewer.live.opened import Counter, Opened
from app.viewer.live.readings import RoomReadings
from app.viewer.live.room_state import Choice
from app.viewer.run.words import in_words
from app.viewer.scene.shown.frame import Frame
from worlds.refusal import Refusal

LOOK_EVERY = 1 / 50
"""Seconds between two looks at the loop."""
OFF = "no browser arms until the next start"
"""What is said after too many wrong codes."""
FAREWELL = 2.0
"""Seconds that closing waits for an opening; its desk closes by itself when it is ready."""


class Driving(Protocol):
    """What a room has to know of what drives the cars."""

    model: Model
    parameters: Parameters


class Room(Asking):
    """Opens and closes the desk of a laboratory in a thread of its own and looks at it 50 times a
    second; `frame`, `look`, `readings` and `state` are always the latest.

    With `recording`, a folder, each opening is recorded in a new folder in it. For `source`, and
    what is raised, see `Asking`.
    """

    def __init__(
        self,
        lab: Lab,
        source: str | None = None,
        recording: Path | None = None,
        opener: Opener = open_driven,
        desk: Callable[[Lab, Opener, Path | None], Counter] = Desk,
        driver: Callable[[Lab, Callable[[str], None]], Driving] = FlockDriver,
    ):
        super().__init__(lab, source)
        self.folder = recording
        self.opener = opener
        self.make_desk = desk
        self.make_driver = driver
        self.frame: Frame | None = None
        self.look: Look | None = None
        """The newest of the desk that is open."""
        self.readings = RoomReadings(lab.injected)
        self.events = Events()
        """Those of all openings."""
        self.code = ArmingCode()
        """What a browser needs to arm, for as long as this room is served."""
        self.parting = threading.Lock()
        """Held while a desk is closed, never while one is opened."""
        self.traced = ""
        """What was traced last in the terminal."""
        self.thread = threading.Thread(target=self.live, name="room", daemon=True)
        self.thread.start()

    def close(self) -> None:
        """Stop the cars and close for good."""
        self.closing.set()
        self.woken.set()
        self.part()
        self.thread.join(FAREWELL)
        self.change(status="closed")

    def part(self) -> None:
        """Close the desk, if one is open: the cars stop."""
        with self.parting:
            opened, self.opened = self.opened, None
            if opened is not None:
                opened.desk.close()
                opened.tuning.end(CLOSED)

    def arm_by_code(self, entered: str, cause: str) -> Verdict:
        """Arm for a browser, if it gives the code; every code that is tried becomes an event."""
        verdict = self.code.tried(entered)
        if verdict == "right":
            self.say("code", "the right code", cause)
            self.ask("arm", cause)
        elif verdict == "wrong":
            left = f"{self.code.left} more and no browser arms" if self.code.left else OFF
            self.say("code", f"a wrong code: {left}", cause)
            if self.code.off:
                self.notices.put(f"a wrong code to arm ({cause}): {left}")
                self.change(browsers_arm=False)
        return verdict

    # The room's own thread.

    def live(self) -> None:
        """Open what is chosen and look at it, until closed; whatever goes wrong is told."""
        while not self.closing.is_set():
            try:
                if self.next is not None:
                    self.turn_to_next()
                self.poll()
            except Exception as error:
                if in_words(error) != self.state.trouble:
                    self.change(trouble=in_words(error))
                    self.notices.put(in_words(error))
                    self.trace(error)
            self.woken.wait(LOOK_EVERY)
            self.woken.clear()

    def turn_to_next(self) -> None:
        """Close what is open, and open what was chosen last."""
        with self.changing:
            choice, self.next = self.next, None
        assert choice is not None
        with suppress(Exception):  # what is wrong with the room that is left has been told
            self.poll()
        self.part()
        self.forget()
        self.change(
            status="opening",
            trouble="",
            source=choice.source,
            link=choice.link,
            rule=choice.rule,
            model=None,
            values={},
            recording="",
            compiling="",
            run=self.state.run + 1,
        )
        self.say("room", f"opening {choice.source}, {choice.rule}", choice.cause)
        try:
            self.open(choice)
        except Exception as error:
            self.trace(error)
            self.fail(in_words(error))

    def open(self, choice: Choice) -> None:
        """Open a choice, unless it is overtaken by another or by the end. Raises Refusal."""
        lab = self.fitting(choice)
        driver = self.make_driver(lab, self.compiles)  # here, so that the loop need not
        self.change(compiling="")
        setting = Setting.of(self.state.run, lab, driver.model)
        values = driver.parameters.model_dump()
        self.change(model=driver.model, values=values)
        if self.overtaken:
            return
        folder = None if self.folder is None else new_folder(self.folder, datetime.now())
        desk = self.make_desk(lab, self.opener, folder)
        if self.overtaken:
            desk.close()
            return
        self.take_over(Opened(setting, desk, values, self.notices.put))
        self.change(status="open", recording="" if folder is None else str(folder))
        self.say("room", "open", choice.cause)

    def compiles(self, words: str) -> None:
        """Say that a rule is being compiled."""
        self.change(compiling=words)
        self.say("compile", words)

    @property
    def overtaken(self) -> bool:
        """Whether something else has been chosen meanwhile, or the room is to close."""
        return self.closing.is_set() or self.next is not None

    def take_over(self, opened: Opened) -> None:
        """Let everybody ask the desk, once it has heard of an emergency stop that is latched."""
        given = self.latch
        if given:
            opened.desk.ask(Request("emergency", given))
        self.opened = opened
        if self.latch != given:  # another one, while nobody was there to hear it
            opened.desk.ask(Request("emergency", self.latch))
        if self.closing.is_set():
            self.part()

    def poll(self) -> None:
        """Look at the desk that is open, and pass on what is new."""
        opened = self.opened
        if opened is None:
            return
        try:
            for event in opened.poll():
                self.note(event)
            if opened.values is not self.state.values:
                self.change(values=opened.values)
            opened.tuning.settle()
            opened.see()
            if opened.look is not None:
                self.look, self.frame, self.readings = opened.look, opened.frame, opened.readings
            silence = opened.silence
            if silence != self.state.trouble:
                self.change(trouble=silence)
                if silence:
                    self.notices.put(silence)
        finally:
            if opened.ended:
                self.lose(opened)

    def note(self, event: Event) -> None:
        """Take an event down; an emergency stop lasts beyond this opening until it is reset."""
        self.events.add(event)
        if event.kind == "emergency":
            self.latch = event.cause or event.kind
            self.change(latched=True)
        elif event.kind == "reset":
            self.latch = ""
            self.change(latched=False)

    def lose(self, opened: Opened) -> None:
        """The loop has ended by itself; `reopen` and `choose` lead on."""
        with self.parting:
            closed = self.opened is not opened
        if not closed:
            self.part()
            self.forget()
            self.fail(opened.ended)

    def forget(self) -> None:
        """What was seen is not what is."""
        self.look = None
        self.readings = RoomReadings(self.lab.injected)
        if self.frame is not None:
            self.frame = deserted(self.frame)

    def fail(self, why: str) -> None:
        """There is no room now, and why."""
        self.change(status="failed", trouble=why)
        self.say("failed", why)
        self.notices.put(why)

    def say(self, kind: str, words: str, cause: str = "") -> None:
        """Put an event of the room's own among the others."""
        self.events.add(Event(0, time.monotonic(), kind, words, cause=cause))

    def trace(self, error: Exception) -> None:
        """Show in the terminal what should not have happened, but not again and again."""
        if not isinstance(error, Refusal) and in_words(error) != self.traced:
            self.traced = in_words(error)
            traceback.print_exception(error)
