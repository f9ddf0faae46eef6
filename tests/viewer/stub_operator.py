"""An operator without a process: its loop is as good as the test wants it to be."""

from __future__ import annotations

import json
import math
import threading
import time
from types import SimpleNamespace

from agents.catalogue import cars_for_rule
from app.live.control.arm import OperatorRequest
from app.live.control.loop_status import CarStatus, DurationSummary, Event, Status
from app.live.control.pose import Companion, Pose
from app.live.links.link import EMERGENCY, RUN, STOP
from worlds.input_error import InputError

MODES = {"safe": STOP, "armed": RUN, "emergency": EMERGENCY}
SUMMARY = DurationSummary(0.01, 0.012, 0.02)
AT = Pose(1.0, 0.5, 0.0)


def car_status(name, pose=AT, age=0.005, tracking="tracked", runs=True, sent=(0.5, 1.0)):
    return CarStatus(
        name, pose, age if pose else math.inf, tracking if pose else "lost", runs, sent
    )


def status_at(tick=0, time=0.0, arm="safe", cars=(), injected=None, companions=(), events=0):
    return Status(
        tick,
        time,
        arm,
        MODES[arm],
        (),
        tuple(cars),
        injected,
        tuple(companions),
        SUMMARY,
        SUMMARY,
        0,
        0,
        {},
        events,
    )


def companion(number, x=0.0, y=0.0, steer=0.0):
    return Companion(f"sim {number}", Pose(x, y, 0.0), steer)


class StubOperator:
    """Answers at once, as the loop does; `mute` for one that does not."""

    def __init__(self, lab, opener, recording):
        self.lab = lab
        self.opener = opener
        self.recording = recording
        self.events: list[Event] = []
        self.trouble = ""
        self.alive = True
        self.asked: list[OperatorRequest] = []
        self.placed: list[tuple[float, float]] = []
        self.arm = "safe"
        self.ticks = 0
        self.closed = 0
        self.mute = False
        self.refuses = ""
        self.seen = {name: Pose(k, 0.0, 0.0) for k, name in enumerate(lab.cars)}

    def ask(self, request):
        self.asked.append(request)
        if not self.mute:
            self.answer(request)

    def answer(self, request):
        kind, words = request.action, request.action
        after = {"arm": "armed", "disarm": "safe", "hold": "safe", "emergency": "emergency"}
        if self.refuses or (kind == "arm" and self.arm == "emergency"):
            kind, words = "refused", self.refuses or "latched"
        elif kind == "reset":
            self.arm = "safe"
        elif self.arm != "emergency":
            self.arm = after.get(kind, self.arm)
        self.happens(kind, words, request.cause, request.action, request.words)

    def happens(self, kind, words, cause="", asked="", note="", car=""):
        self.events.append(
            Event(self.ticks, time.monotonic(), kind, words, car, cause, asked, note)
        )

    def place(self, x, y):
        self.placed.append((x, y))

    def record(self, folder, cause):
        self.recording = folder
        self.happens("record", "recording", cause, note=str(folder or ""))

    def status(self):
        if self.mute:
            return None
        self.ticks += 3
        cars = [car_status(name, pose) for name, pose in self.seen.items()]
        return status_at(self.ticks, time.monotonic(), self.arm, cars, events=len(self.events))

    def close(self):
        self.closed += 1
        self.alive = False

    def actions(self):
        return [request.action for request in self.asked]

    def tuned(self):
        """The parameters that were asked for, in order."""
        return [json.loads(request.words) for request in self.asked if request.action == "tune"]


class Operators:
    """Makes the operators of a room: `gate` closed keeps them from being ready."""

    def __init__(self):
        self.made: list[StubOperator] = []
        self.begun = 0
        self.gate = threading.Event()
        self.gate.set()
        self.refuses = ""

    def __call__(self, lab, opener, recording):
        self.begun += 1
        assert self.gate.wait(60)
        if self.refuses:
            raise InputError(self.refuses)
        self.made.append(StubOperator(lab, opener, recording))
        return self.made[-1]

    @property
    def last(self):
        return self.made[-1]


def driver(lab, _tell):
    """What a room has to know of a driver, without compiling one."""
    model = cars_for_rule(lab.rule)
    return SimpleNamespace(model=model, parameters=model.parameters(**lab.parameters))
