"""What browsers and the terminal may ask of a session, from any thread; nothing waits or raises."""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from datetime import datetime
from itertools import count
from pathlib import Path
from typing import Any, Literal

import numpy as np
from viser import SceneApi, TransformControlsEvent

from agents.models.declare import checked, describe
from agents.models.model import Model
from app.live.control.arm import Action, OperatorRequest
from app.live.control.pose import TrackingArea
from app.live.operating.flock_driver import NOT_SIMULATED
from app.live.operating.lab_choices import Choices
from app.viewer.live.loop_connection import LoopConnection
from app.viewer.live.room_replay import RoomReplay, find_recording
from app.viewer.run.flock_run import describe_error
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.shown.frame import Frame
from worlds.input_error import InputError, unknown

# The state of a session.

Phase = Literal["opening", "open", "replay", "failed", "closed"]
"""`replay`: no loop is open, and an earlier recording is shown."""


@dataclass(frozen=True)
class SessionState:
    """The state of a session; replaced as a whole, never changed."""

    source: str
    """Names of the source, the link and the rule that are open or being opened."""
    link: str
    rule: str
    phase: Phase = "opening"
    trouble: str = ""
    """What is wrong, in one line."""
    model: Model | None = None
    """The rule with its body; None until it is known."""
    values: dict[str, Any] = field(default_factory=dict)
    """The parameters of the model, name -> value, as the control loop has them."""
    compiling: str = ""
    """A line of text while the rule is compiled, the first time that it is used; else empty."""
    recording: str = ""
    """The folder of this opening's recording; empty: none is made."""
    run: int = 0
    """Counts the openings."""
    browsers_arm: bool = True
    """Whether browsers may arm: not after too many wrong codes."""
    latched: bool = False
    """Whether an emergency stop was asked for and no reset has followed, in whichever opening."""
    emulated: bool = False
    """Whether the cars are emulated: no real one is driven."""
    disarmed: str = ""
    """Why the cars were disarmed or stopped last, and by whom; empty: they were not since they were
    armed, or since the room was opened."""


# Checks of what browsers send, before it goes to the control loop, which checks again.

LONGEST = 60
"""Characters of a value that are shown."""
PAGE = "the page"


def shorten_value(value: object) -> str:
    """A value in a message, cut short.

    >>> shorten_value("x" * 100)
    "'xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx..."
    """
    try:
        text = repr(value)
    except Exception:  # whatever it is, it can be refused
        return f"a {type(value).__name__}"
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."


def number(name: str, value: object) -> float:
    """A finite number. Raises InputError."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(
            f"{name} = {shorten_value(value)} is not allowed: it must be a number ({PAGE})"
        )
    try:
        parsed = float(value)
    except OverflowError:
        parsed = math.inf
    if not math.isfinite(parsed):
        raise InputError(f"{name} = {parsed} is not allowed: it must be finite ({PAGE})")
    return parsed


def whole_number(name: str, value: object, most: int) -> int:
    """A whole number from 0 to `most`. Raises InputError."""
    parsed = number(name, value)
    if not parsed.is_integer() or not 0 <= parsed <= most:
        raise InputError(f"{name} = {parsed:g} is outside 0 to {most}, whole numbers ({PAGE})")
    return int(parsed)


def check_word(kind: str, value: object, allowed: Iterable[str]) -> str:
    """One of the words that are offered. Raises InputError."""
    offered = list(allowed)
    if not isinstance(value, str) or value not in offered:
        raise unknown(kind, value[:LONGEST] if isinstance(value, str) else value, offered, PAGE)
    return value


def parameter_value(model: Model, values: Mapping[str, Any], name: object, value: object) -> Any:
    """The value that a parameter takes beside those that are set. Raises InputError."""
    offered = [field for field in model.parameters.model_fields if field not in NOT_SIMULATED]
    known_name = check_word("parameter", name, offered)
    kind = describe(known_name, model.parameters.model_fields[known_name]).kind
    if kind == "number":
        value = number(known_name, value)
    elif not isinstance(value, bool if kind == "switch" else str):
        raise InputError(f"{known_name} = {shorten_value(value)} is not allowed ({PAGE})")
    elif isinstance(value, str):
        value = value[:LONGEST]
    return getattr(checked(model.parameters, dict(values) | {known_name: value}, PAGE), known_name)


# The handle by which the injected car is dragged, where it is in a person's hand.

SETTLE = 0.35
"""Seconds after a release before the handle goes to the car again: frames on their way are old."""

Placed = Callable[[float, float], None]


class DragHandle:
    """Two arrows and a plate on the injected car; what is dragged out of the fence stays at it."""

    def __init__(self, scene: SceneApi, area: TrackingArea, placed: Placed):
        self.area = area
        self.placed = placed
        self.stage: Stage | None = None
        self.holder: int | None = None
        """The browser that holds it."""
        self.released = 0.0
        self.handle = scene.add_transform_controls(
            "/injected_hand",
            scale=85.0,
            fixed=True,
            line_width=3.5,
            active_axes=(True, True, False),
            disable_rotations=True,
            depth_test=False,
            opacity=0.9,
            visible=False,
        )
        self.handle.on_update(self.handle_drag)

    def draw(self, frame: Frame) -> None:
        """Bring the handle to the injected car, unless somebody drags it."""
        self.stage = Stage.of(frame)
        goal = frame.progress.goal
        if goal is None:
            self.handle.visible = False
        elif self.holder is None and time.monotonic() - self.released > SETTLE:
            self.handle.position = self.stage.to_display(goal)
            self.handle.visible = True

    async def handle_drag(self, event: TransformControlsEvent) -> None:
        """On the event loop, so that start, updates and end arrive in order."""
        if event.phase == "start":
            self.holder = event.client_id
        if event.client_id != self.holder or self.stage is None:
            return
        place = np.asarray(event.target.position, float)
        if place.shape == (3,) and np.isfinite(place).all():
            x, y = self.stage.world(place)
            self.placed(*self.area.clamp(float(x), float(y)))
        if event.phase == "end":
            self.release()

    def release(self) -> None:
        """The handle is free again."""
        self.holder, self.released = None, time.monotonic()


ASKED: dict[str, Action] = {"arm": "arm", "disarm": "disarm", "reset": "reset"}
"""What may be asked with `ask`."""
CLOSED = "was not answered: the room was closed"
"""The answer to changes that wait when a loop is closed."""


class SessionRequests:
    """The requests to a session. What is refused becomes a notice in every browser."""

    def __init__(self, choices: Choices):
        self.lab = choices.lab
        self.state = SessionState(choices.source, choices.link, choices.rule)
        self.notices: queue.SimpleQueue[str] = queue.SimpleQueue()
        """Notices for all browsers."""
        self.chosen = choices.choosing()
        """What was chosen last."""
        self.next: tuple[Choices | Path, str] | None = self.chosen, ""
        """What is to be opened next, a room or a recording, and who chose it."""
        self.shelf: Path | None = None
        """The folder of recordings that are made by a button, and listed."""
        self.replaying: RoomReplay | None = None
        """The recording that is shown; no loop is open then."""
        self.moves: queue.SimpleQueue[Callable[[RoomReplay], None]] = queue.SimpleQueue()
        """What is to be done with it."""
        self.opening: LoopConnection | None = None
        self.changing = threading.Lock()
        """Guards the state and the choice; held for moments only."""
        self.latch = ""
        """Who asked for an emergency stop that was not reset: the next opening begins with it."""
        self.closing = threading.Event()
        self.woken = threading.Event()

    def ask(self, action: str, cause: str) -> None:
        """Arm, disarm or reset."""
        with self.notifying_errors():
            request = ASKED[check_word("request", action, ASKED)]
            if request == "arm" and self.next is not None:
                raise InputError("cannot be armed: another room is about to be opened")
            self.open_connection().operator.ask(OperatorRequest(request, cause))

    def emergency(self, cause: str) -> None:
        """Stop the cars now, and latched. While no loop is open the next begins so."""
        with self.notifying_errors():
            self.latch = cause or "the page"
            opening = self.opening
            if opening is not None:
                opening.operator.ask(OperatorRequest("emergency", cause))
            else:
                self.notices.put(f"EMERGENCY STOP ({cause}): the next room begins with it")
            self.change(latched=True)

    def set_parameter(self, name: str, value: Any, cause: str) -> Future:
        """Give a parameter of the rule a new value; the answer is the one that the loop took."""
        answer: Future = Future()
        try:
            opening = self.open_connection()
            accepted = parameter_value(opening.setting.model, opening.values, name, value)
            change = opening.tuning.begin(name, accepted, cause)
            opening.operator.ask(change.request)
            if self.opening is not opening:  # closed meanwhile: nobody would answer
                opening.tuning.end(CLOSED)
        except Exception as error:
            self.notices.put(describe_error(error))
            answer.set_exception(error)
            return answer
        return change.answer

    def set_companions(self, count: int, cause: str) -> None:
        """Have so many simulated cars beside the real ones."""
        with self.notifying_errors():
            car_count = whole_number("simulated cars", count, self.lab.simulated.most)
            self.open_connection().operator.ask(OperatorRequest("accompany", cause, str(car_count)))

    def place(self, x: float, y: float) -> None:
        """Move the injected car of the hand, m; the loop keeps it within the fence."""
        with self.notifying_errors():
            at = number("x", x), number("y", y)
            opening = self.opening
            if opening is not None:
                opening.operator.place(*at)

    def choose(
        self,
        source: str | None = None,
        link: str | None = None,
        rule: str | None = None,
        cause: str = "",
    ) -> None:
        """Close the loop and open one with other choices; what is not given stays.

        The names are those of `app.live.operating.lab_choices`. Not while the cars are
        armed. Of several choices at once only the last is opened.
        """
        names = {"source": source, "link": link, "rule": rule}
        with self.notifying_errors():
            self.demand_unarmed("no other room is opened")
            with self.changing:
                last = self.chosen
            choices = last.choosing(
                **{
                    kind: check_word(kind, name, last.offered[kind])
                    for kind, name in names.items()
                    if name is not None
                }
            )
            with self.changing:
                self.chosen, self.next = choices, (choices, cause)
            self.woken.set()

    def reopen(self, cause: str) -> None:
        """Close the loop, if one is open, and open it again."""
        self.choose(cause=cause)

    def record(self, on: bool, cause: str) -> None:
        """Record what happens in the open room in a new folder of the shelf, or no more."""
        with self.notifying_errors():
            opening = self.open_connection()
            if not on:
                opening.operator.record(None, cause)
            elif self.shelf is None:
                raise InputError("nothing is recorded: there is no folder for recordings")
            else:
                opening.operator.record(new_folder(self.shelf, datetime.now()), cause)

    def play(self, name: str, cause: str) -> None:
        """Close the room and show a recording of the shelf. Not while the cars are armed."""
        with self.notifying_errors():
            self.demand_unarmed("no recording is shown")
            folder = find_recording(self.shelf, name)
            with self.changing:
                self.next = folder, cause
            self.woken.set()

    def seek(self, time: float) -> None:
        """Show a time of the recording, s."""
        with self.notifying_errors():
            at = number("time", time)
            self.move(lambda replay: replay.seek(at))

    def toggle_replay(self) -> None:
        """Pause the recording, or play it on."""
        self.move(RoomReplay.toggle)

    def replay_at(self, speed: float) -> None:
        """Play the recording so many times as fast as it was."""
        with self.notifying_errors():
            times = number("speed", speed)
            self.move(lambda replay: setattr(replay, "speed", times))

    def move(self, what: Callable[[RoomReplay], None]) -> None:
        """Have something done with the recording that is shown, if one is."""
        if self.replaying is not None:
            self.moves.put(what)

    def browsers(self, count: int) -> None:
        """Say how many browsers are open: armed by a browser, the cars stop when none is left."""
        opening = self.opening
        if count == 0 and opening is not None:
            opening.hold_without_browsers()

    # Used by the requests above.

    @contextmanager
    def notifying_errors(self) -> Iterator[None]:
        """What is raised within becomes a notice."""
        try:
            yield
        except Exception as error:
            self.notices.put(describe_error(error))

    def demand_unarmed(self, what: str) -> None:
        """Raise InputError while cars are armed, and once the session is closed."""
        opening = self.opening
        if self.closing.is_set():
            raise InputError("the room is closed")
        if opening is not None and opening.is_armed:
            raise InputError(f"{what} while the cars are armed: disarm them first")

    def open_connection(self) -> LoopConnection:
        """The open loop. Raises InputError if none is open."""
        opening = self.opening
        if opening is None:
            raise InputError(f"the room is not open ({self.state.phase})")
        return opening

    def change(self, **changes: Any) -> None:
        """Change the state; a closed session stays closed."""
        with self.changing:
            if self.state.phase == "closed":
                changes.pop("phase", None)
            self.state = replace(self.state, **changes)


def new_folder(folder: Path, now: datetime) -> Path:
    """A folder in `folder` that does not exist, named for the time: `2026-11-22-093015`."""
    name = now.strftime("%Y-%m-%d-%H%M%S")
    names = (name if number == 1 else f"{name}-{number}" for number in count(1))
    return next(folder / name for name in names if not (folder / name).exists())
