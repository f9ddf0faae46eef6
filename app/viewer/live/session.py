"""The page's session with a laboratory: its control loop is opened, polled and closed here."""

from __future__ import annotations

import hmac
import re
import secrets
import threading
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import Any, Literal, Protocol

from agents.models.declare import Parameters
from agents.models.model import Model
from app.live.control.arm import OperatorRequest
from app.live.control.loop_status import Event, Events, Status
from app.live.device_kinds import SIMULATED, kind_of
from app.live.laboratory.lab_file import Lab
from app.live.operating.flock_driver import FlockDriver
from app.live.operating.lab_choices import Choices, open_driven
from app.live.operating.loop_process import Opener
from app.live.operating.operator import Operator
from app.viewer.live.loop_connection import LoopConnection, OperatorProtocol
from app.viewer.live.room_frame import RoomReadings, Setting, frame_without_loop
from app.viewer.live.room_replay import RoomReplay
from app.viewer.live.session_requests import CLOSED, SessionRequests, new_folder
from app.viewer.run.flock_run import describe_error
from app.viewer.scene.shown.frame import Frame
from worlds.input_error import InputError

# The code without which no browser arms: whoever knows it can see the terminal.

DIGITS = 6
TRIES = 5
"""Wrong codes, of all browsers together, after which none is taken any more."""
WRITTEN = re.compile(rf"[0-9]{{{DIGITS}}}")

Verdict = Literal["right", "wrong", "no code", "off"]
"""`no code`: what was entered cannot be one, and counts as no try."""


class ArmingCode:
    """A code made by chance at the start; it is shown in the terminal and nowhere else.

    >>> code = ArmingCode()
    >>> code.check(code.digits), code.check("12"), code.left
    ('right', 'no code', 5)
    """

    def __init__(self) -> None:
        self.digits = f"{secrets.randbelow(10**DIGITS):0{DIGITS}d}"
        self.left = TRIES
        """Wrong codes until it is off."""
        # Without it browsers that guess at once would all be let in by the same last try.
        self.trying = threading.Lock()

    @property
    def is_off(self) -> bool:
        """Whether no code is taken any more, until the next start."""
        return self.left == 0

    def check(self, entered: str) -> Verdict:
        """What is to be said of an entered code; a wrong one is counted for good."""
        code = entered.strip()
        if not WRITTEN.fullmatch(code):
            return "off" if self.is_off else "no code"
        with self.trying:
            if self.is_off:
                return "off"
            if hmac.compare_digest(code, self.digits):
                return "right"
            self.left -= 1
            return "wrong"


POLL_EVERY = 1 / 50
"""Seconds between two polls of the loop."""
OFF = "no browser arms until the next start"
"""What is said after too many wrong codes."""
FAREWELL = 2.0
"""Seconds that closing waits for an opening; its loop is closed when it is ready."""


class SessionDriver(Protocol):
    """What a session has to know of what drives the cars."""

    model: Model
    parameters: Parameters


class Session(SessionRequests):
    """Opens and closes the control loop of a laboratory in a thread of its own, and polls it 50
    times a second; `frame`, `status`, `readings` and `state` are always the latest.

    With `recording`, a folder, each opening is recorded in a new folder in it. An earlier recording
    is shown in the place of a loop, never beside one.
    """

    def __init__(
        self,
        choices: Choices,
        recording: Path | None = None,
        opener: Opener = open_driven,
        operator: Callable[[Lab, Opener, Path | None], OperatorProtocol] = Operator,
        driver: Callable[[Lab, Callable[[str], None]], SessionDriver] = FlockDriver,
    ):
        super().__init__(choices)
        self.folder = recording
        self.opener = opener
        self.make_operator = operator
        self.make_driver = driver
        self.frame: Frame | None = None
        self.status: Status | None = None
        """The newest of the loop that is open."""
        self.readings = RoomReadings(self.lab.injected)
        self.events = Events()
        """Those of all openings."""
        self.is_armed = False
        """Whether the cars were armed by the last event that says so."""
        self.code = ArmingCode()
        """What a browser needs to arm, for as long as this page is served."""
        self.parting = threading.Lock()
        """Held while a loop is closed, never while one is opened, which takes seconds: `close` has
        to stop the cars meanwhile."""
        self.traced = ""
        """The error whose traceback was printed last."""
        self.thread = threading.Thread(target=self.run, name="room", daemon=True)
        self.thread.start()

    def close(self) -> None:
        """Stop the cars and close for good."""
        self.closing.set()
        self.woken.set()
        self.close_loop()
        self.thread.join(FAREWELL)
        self.change(phase="closed")

    def close_loop(self) -> None:
        """Close the loop, if one is open: the cars stop."""
        with self.parting:
            opening, self.opening = self.opening, None
            if opening is not None:
                opening.operator.close()
                opening.tuning.end(CLOSED)

    def arm_by_code(self, entered: str, cause: str) -> Verdict:
        """Arm for a browser, if it gives the code; every code that is tried becomes an event."""
        verdict = self.code.check(entered)
        if verdict == "right":
            self.add_event("code", "the right code", cause)
            self.ask("arm", cause)
        elif verdict == "wrong":
            left = f"{self.code.left} more and no browser arms" if self.code.left else OFF
            self.add_event("code", f"a wrong code: {left}", cause)
            if self.code.is_off:
                self.notices.put(f"a wrong code to arm ({cause}): {left}")
                self.change(browsers_arm=False)
        return verdict

    # The session's own thread.

    def run(self) -> None:
        """Open what is chosen and poll it, until closed; whatever goes wrong becomes a notice."""
        while not self.closing.is_set():
            try:
                self.open_next()
                self.poll()
            except Exception as error:
                if describe_error(error) != self.state.trouble:
                    self.change(trouble=describe_error(error))
                    self.notices.put(describe_error(error))
                    self.trace(error)
            self.woken.wait(POLL_EVERY)
            self.woken.clear()

    def open_next(self) -> None:
        """Close what is open, and open what was chosen last, if anything was."""
        with self.changing:
            choice, self.next = self.next, None
        if choice is None:
            return
        choices, cause = choice
        with suppress(Exception):  # what is wrong with the loop that is left has become a notice
            self.poll()
        self.close_loop()
        self.replaying = None
        self.is_armed = False
        self.forget()
        if isinstance(choices, Path):
            self.show_recording(choices, cause)
            return
        self.change(
            phase="opening",
            trouble="",
            source=choices.source,
            link=choices.link,
            rule=choices.rule,
            model=None,
            values={},
            recording="",
            compiling="",
            emulated=kind_of(choices.lab.source) == SIMULATED,
            disarmed="",
            run=self.state.run + 1,
        )
        self.add_event("room", f"opening {choices.source}, {choices.rule}", cause)
        try:
            self.open(choices.lab, cause)
        except Exception as error:
            self.trace(error)
            self.fail(describe_error(error))

    def show_recording(self, folder: Path, cause: str) -> None:
        """Show a recording, with no loop open."""
        empty: dict[str, Any] = {"model": None, "values": {}, "recording": "", "compiling": ""}
        self.change(phase="opening", trouble="", run=self.state.run + 1, **empty)
        self.add_event("room", f"closed, to show the recording {folder.name}", cause)
        try:
            replay = RoomReplay(folder, self.state.run)
        except Exception as error:
            self.trace(error)
            self.fail(describe_error(error))
            return
        while not self.moves.empty():  # what was meant for another one
            self.moves.get_nowait()
        self.replaying = replay
        self.change(phase="replay")

    def replay(self, replay: RoomReplay) -> None:
        """Play on the recording that is shown."""
        while not self.moves.empty():
            self.moves.get_nowait()(replay)
        self.status, self.frame = replay.play(time.monotonic())
        self.readings = replay.readings

    def open(self, lab: Lab, cause: str) -> None:
        """Open a laboratory, unless another is chosen or the session closed. Raises InputError."""
        driver = self.make_driver(lab, self.compiles)  # here, so that the loop need not
        self.change(compiling="")
        setting = Setting.of(self.state.run, lab, driver.model)
        values = driver.parameters.model_dump()
        self.change(model=driver.model, values=values)
        if self.is_overtaken:
            return
        folder = None if self.folder is None else new_folder(self.folder, datetime.now())
        operator = self.make_operator(lab, self.opener, folder)
        if self.is_overtaken:
            operator.close()
            return
        self.take_over(LoopConnection(setting, operator, values, self.notices.put))
        self.change(phase="open", recording="" if folder is None else str(folder))
        self.add_event("room", "open", cause)

    def compiles(self, words: str) -> None:
        """Report that a rule is being compiled."""
        self.change(compiling=words)
        self.add_event("compile", words)

    @property
    def is_overtaken(self) -> bool:
        """Whether another choice has been made meanwhile, or the session is to close."""
        return self.closing.is_set() or self.next is not None

    def take_over(self, opening: LoopConnection) -> None:
        """Let everybody ask the loop, once it has been sent an emergency stop that is latched."""
        reason = self.latch
        if reason:
            opening.operator.ask(OperatorRequest("emergency", reason))
        self.opening = opening
        if self.latch != reason:  # another one, while nobody was there to hear it
            opening.operator.ask(OperatorRequest("emergency", self.latch))
        if self.closing.is_set():
            self.close_loop()

    def poll(self) -> None:
        """Ask the loop that is open for its status, and pass on what is new."""
        opening = self.opening
        if self.replaying is not None:
            self.replay(self.replaying)
        if opening is None:
            return
        try:
            for event in opening.poll():
                self.note(event)
            if opening.values is not self.state.values:
                self.change(values=opening.values)
            opening.tuning.settle()
            opening.update()
            if opening.status is not None:
                self.status, self.frame, self.readings = (
                    opening.status,
                    opening.frame,
                    opening.readings,
                )
            silence = opening.describe_silence
            if silence != self.state.trouble:
                self.change(trouble=silence)
                if silence:
                    self.notices.put(silence)
        finally:
            if opening.end_reason:
                self.lose(opening)

    def note(self, event: Event) -> None:
        """Keep an event; an emergency stop lasts beyond this opening until it is reset."""
        self.events.add(event)
        is_repeated = event.kind == "emergency" and self.latch and self.state.disarmed
        stops = event.kind == "emergency" or (self.is_armed and event.kind in ("hold", "disarm"))
        if event.kind == "arm":
            self.is_armed = True
            self.change(disarmed="")
        elif stops and not is_repeated:
            self.is_armed = False
            by = f" ({event.cause})" if event.cause else ""
            self.change(disarmed=f"{event.words}{by}")
        if event.kind == "emergency":
            self.latch = event.cause or event.kind
            self.change(latched=True)
        elif event.kind == "reset":
            self.latch = ""
            self.change(latched=False)
        elif event.kind == "record":
            self.change(recording=event.note)

    def lose(self, opening: LoopConnection) -> None:
        """Close a loop that has ended by itself; `reopen` and `choose` open one again."""
        with self.parting:
            closed = self.opening is not opening
        if not closed:
            self.close_loop()
            self.forget()
            self.fail(opening.end_reason)

    def forget(self) -> None:
        """Nothing is known any more of the loop that was open."""
        self.status = None
        self.readings = RoomReadings(self.lab.injected)
        if self.frame is not None:
            self.frame = frame_without_loop(self.frame)

    def fail(self, why: str) -> None:
        """Report why no loop is open."""
        self.change(phase="failed", trouble=why)
        self.add_event("failed", why)
        self.notices.put(why)

    def add_event(self, kind: str, words: str, cause: str = "") -> None:
        """Add an event of the session itself."""
        self.events.add(Event(0, time.monotonic(), kind, words, cause=cause))

    def trace(self, error: Exception) -> None:
        """Print the traceback of an unexpected error, once while it repeats."""
        if not isinstance(error, InputError) and describe_error(error) != self.traced:
            self.traced = describe_error(error)
            traceback.print_exception(error)
