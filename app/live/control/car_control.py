"""One tick of control, without a clock, a thread or a device: requests, tracking, rule, safety.

The loop gives it the time and the outer world; a replay gives it the same from a recording, and the
same comes out.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from app.live.control.arm import OperatorRequest, State
from app.live.control.loop_status import Event
from app.live.control.pose import (
    Companion,
    CompanionDriver,
    Driver,
    MocapFrame,
    NoFreeSpace,
    Pose,
    Sighting,
    TunableDriver,
)
from app.live.control.safety import Command, Safety, SafetyDecision, StopReason
from app.live.links.link import RUN
from worlds.input_error import InputError

NAMES = {
    "arm": "armed",
    "disarm": "disarmed",
    "hold": "held",
    "emergency": "EMERGENCY STOP",
    "reset": "emergency stop reset; not armed",
}
"""What a request has done, in words."""


@dataclass(frozen=True)
class ControlStep:
    """The result of one tick."""

    wanted: dict[str, Command]
    """What the rule wants, by car."""
    verdict: SafetyDecision
    events: tuple[Event, ...]
    companions: tuple[Companion, ...] = ()
    """The simulated cars beside the real ones, as they are after it."""


class CarControl:
    """A driver behind the safety; `begin_tick`, then `end_tick`, once each a tick."""

    def __init__(self, safety: Safety, driver: Driver):
        self.safety = safety
        self.driver = driver
        self.accompanied = driver if isinstance(driver, CompanionDriver) else None
        self.tick = -1
        self.running = False
        self.reasons: dict[tuple[str, str], StopReason] = {}
        """Those of the last tick, by kind and car."""
        self.events: list[Event] = []
        self.sightings: tuple[Sighting, ...] = ()
        """The last poses of bodies seen within the limit `stale`."""

    @property
    def companions(self) -> tuple[Companion, ...]:
        """The simulated cars beside the real ones."""
        return self.accompanied.companions if self.accompanied is not None else ()

    def begin_tick(
        self, now: float, requests: Iterable[OperatorRequest], frames: Sequence[MocapFrame]
    ) -> None:
        """Begin a tick at `now` (s): take the frames that came since the tick before, oldest first,
        then carry out the requests."""
        self.tick += 1
        self.events = []
        self.sightings = self.safety.take_frames(now, frames)
        for request in requests:
            self.events.append(self.answer(now, request))

    def answer(self, now: float, request: OperatorRequest) -> Event:
        """Carry out a request; the event that says what it has done."""
        kind: str = request.action
        try:
            if request.action == "tune":
                words = self.set_parameters(request)
            elif request.action == "accompany":
                words = self.set_companions(request)
            else:
                changed = self.safety.ask(now, request)
                words = NAMES[kind] if changed else f"{NAMES[kind]}: nothing changed"
                words += f": {request.words}" if request.words else ""
        except Exception as refusal:  # whatever is asked, it cannot end the loop
            kind, words = "refused", " ".join(str(refusal).split()) or type(refusal).__name__
        return Event(
            self.tick, now, kind, words, "", request.cause, asked=request.action, note=request.words
        )

    def set_parameters(self, request: OperatorRequest) -> str:
        """Change parameters of the rule; what was changed, in words. Raises InputError."""
        if not isinstance(self.driver, TunableDriver):
            raise InputError("the parameters of this driver cannot be changed")
        try:
            values = json.loads(request.words)
        except json.JSONDecodeError:
            raise InputError(f"parameters {request.words!r} are no JSON") from None
        if not isinstance(values, dict):
            raise InputError(f"parameters {request.words!r} are no JSON object")
        self.driver.tune(values)
        return ", ".join(f"{name} = {value}" for name, value in values.items())

    def set_companions(self, request: OperatorRequest) -> str:
        """Have other simulated cars beside the real ones; how many, in words. Raises InputError."""
        if self.accompanied is None:
            raise InputError("this driver has no simulated cars beside the real ones")
        words = request.words
        if not re.fullmatch(r"-?[0-9]{1,9}", words):
            raise InputError(f"simulated cars = {words[:40]!r} is not allowed: not a whole number")
        count = int(words)
        self.accompanied.accompany(count)
        return "1 simulated car" if count == 1 else f"{count or 'no'} simulated cars"

    def end_tick(self, now: float, injected: Pose | None) -> ControlStep:
        """End the tick: ask the driver for commands and the safety what may be sent."""
        commands: dict[str, Command] = {}
        failed = ""
        try:
            cars = tuple(
                sighting for sighting in self.sightings if sighting.name in self.safety.cars
            )
            answer = self.driver.drive(now, cars, injected, self.running)
            commands = {
                name: (float(answer[name][0]), float(answer[name][1]))
                for name in self.safety.cars
                if name in answer
            }
        except NoFreeSpace as refused:  # for simulated cars: the real ones need not wait for them
            words = " ".join(str(refused).split())
            self.events.append(Event(self.tick, now, "refused", words))
        except Exception as error:  # whatever a rule does wrong, the cars stop
            failed = " ".join(f"{type(error).__name__}: {error}".split())
        verdict = self.safety.judge(now, commands, failed)
        self.add_events(now, verdict)
        return ControlStep(commands, verdict, tuple(self.events), self.companions)

    def add_events(self, now: float, verdict: SafetyDecision) -> None:
        """Events for what has changed: reasons that began and ended, runs that began and ended."""

        def happened(kind: str, words: str, car: str = "", cause: str = "") -> None:
            self.events.append(Event(self.tick, now, kind, words, car, cause))

        reasons = {(reason.kind, reason.car): reason for reason in verdict.reasons}
        for key, reason in reasons.items():
            if key not in self.reasons:
                happened(reason.kind, reason.words, reason.car)
        for key, reason in self.reasons.items():
            # what holds is not looked for any more once it has taken the arming away, but for cars
            # that move though told to stand
            if key not in reasons and (not reason.holds or reason.kind == "moves"):
                happened("cleared", f"no longer: {reason.words}", reason.car)
        if verdict.held:
            why = "; ".join(reason.words for reason in verdict.reasons if reason.holds)
            happened("hold", f"stopped until armed again: {why}", cause="safety")
        running = verdict.mode == RUN
        if running != self.running:
            happened("run" if running else "stop", "the cars run" if running else "the cars stop")
        self.reasons = reasons
        self.running = running


# One tick of the control loop as it is recorded: its inputs and its outputs.


@dataclass(frozen=True)
class TickRecord:
    """A tick. It and those before it hold all inputs that its commands depend on."""

    tick: int
    now: float
    """`time.monotonic()` at its beginning, s; the time for which its commands are computed."""
    frames: tuple[MocapFrame, ...]
    """Those that arrived since the last tick; the last of them is used."""
    injected: Pose | None
    step: ControlStep
    arm: State
    events: tuple[Event, ...]
    latency: float | None
    """Seconds from the arrival of the newest frame to its commands; None without a new frame."""
