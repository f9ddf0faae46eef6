"""A room for the tests: a laboratory of two cars, a plant that answers, a driver that is simple."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field

from app.live.control.arm import OperatorRequest
from app.live.control.car_control import CarControl, ControlStep
from app.live.control.pose import MocapFrame, Pose, seen
from app.live.laboratory.lab_file import Lab, lab_from_toml
from app.live.links.firmware import WATCHDOG
from app.live.links.link import RUN
from app.live.links.link_catalogue import open_link
from app.live.operating.loop_process import LoopComponents, open_ends

LAB = """title = "a room"
source = "mock:"
link = "dry"
rule = "none"

[area]
low = [-3.0, -3.0]
high = [3.0, 3.0]
fence = 0.5

[injected]
path = "circle"
radius = 2.0

[cars.red]
address = 1

[cars.blue]
address = 2
body = "blue body"
"""
TICK = 0.01
ROUND = (0.367, 0.9)
"""The command of a car that goes round the middle of a whole room, on the ring that it begins on.
"""


def lab(text: str = LAB) -> Lab:
    """The laboratory of the room."""
    return lab_from_toml(text, "room.toml")


@dataclass
class Steady:
    """Drives every car that it sees with one command."""

    command: tuple[float, float] = (0.0, 1.0)

    def drive(self, _now, sightings, _injected, _running):
        return {sighting.name: self.command for sighting in sightings}


@dataclass
class Room:
    """Cars that drive along x, each with its own motor, tracked 5 ms ago, every 10 ms."""

    driver: object = field(default_factory=Steady)
    text: str = LAB
    now: float = 100.0
    number: int = 0
    frozen: bool = False
    hidden: set[str] = field(default_factory=set)
    stuck: set[str] = field(default_factory=set)
    noise: float = 0.0005

    def __post_init__(self):
        self.lab = lab(self.text)
        self.control = CarControl(self.lab.safety(), self.driver)
        self.at = {name: [-2.0, 0.7 * k, 0.0] for k, name in enumerate(self.lab.cars)}
        self.events = []
        self.step: ControlStep | None = None
        self.shown = {}
        self.told = None
        self.cut_at: float | None = None

    def frame(self) -> MocapFrame:
        """What tracking says; a frozen stream goes on with noise around where it froze."""
        self.number += 1
        if not self.frozen:
            self.shown = {name: tuple(at) for name, at in self.at.items()}
        body = {name: car.body or name for name, car in self.lab.cars.items()}
        wave = self.noise * math.sin(12.9898 * self.number)
        return MocapFrame(
            self.number,
            self.now - 0.005,
            tuple(
                seen(body[name], Pose(x + wave, y - wave, 0.0))
                for name, (x, y, _) in self.shown.items()
                if name not in self.hidden
            ),
        )

    def tick(self, *requests: OperatorRequest) -> ControlStep:
        """One tick; then the cars move as they were told."""
        self.now += TICK
        self.control.begin_tick(self.now, requests, (self.frame(),))
        self.step = self.control.end_tick(self.now, None)
        self.events += self.step.events
        self.move()
        return self.step

    def move(self) -> None:
        """The cars obey the last command that they got; cut off, until their watchdog runs out."""
        if self.cut_at is None:
            self.told = self.step.verdict
        watched = self.cut_at is not None and self.now - self.cut_at >= WATCHDOG
        for name, at in self.at.items():
            car = self.lab.cars[name]
            runs = self.told.mode == RUN and not watched
            wanted = car.speed * self.told.commands[name][1] if runs else 0.0
            decay = math.exp(-TICK / car.lag)
            step = wanted * TICK + (at[2] - wanted) * car.lag * (1.0 - decay)
            at[0] += 0.0 if name in self.stuck else step
            at[2] = wanted + (at[2] - wanted) * decay

    def arm(self) -> ControlStep:
        """See the cars, then arm."""
        self.tick()
        return self.tick(OperatorRequest("arm", "test"))

    def ticks(self, seconds: float) -> ControlStep:
        """Tick for a while; at least once."""
        for _ in range(max(1, round(seconds / TICK))):
            step = self.tick()
        return step

    def until(self, mode: int, within: float) -> float:
        """Seconds until the mode is so; fails if it takes longer."""
        begun = self.now
        while self.tick().verdict.mode != mode:
            assert self.now - begun < within, f"mode {mode} not within {within} s"
        return self.now - begun

    def kinds(self) -> list[str]:
        """The kinds of the events so far."""
        return [event.kind for event in self.events]


class Waiting:
    """A feed of the two cars of the room, which wait; a frame whenever it is looked at."""

    trouble = ""

    def since(self, number):
        cars = (seen("red", Pose(0.0, 0.0, 0.0)), seen("blue body", Pose(0.0, 1.0, 0.0)))
        return [MocapFrame(number + 1, time.monotonic(), cars)]


def crawling(lab: Lab) -> LoopComponents:
    """Ends of the room whose cars are told so little throttle that they need not move."""
    return LoopComponents(Waiting(), open_link(lab.link), Steady((0.5, 0.1)))


def named(lab: Lab) -> LoopComponents:
    """The ends that the file names, with a driver whose cars need not move."""
    return open_ends(lab, Steady((0.5, 0.1)))


def refusing(lab: Lab) -> LoopComponents:
    """Ends that cannot be opened."""
    open_link("dri")
    raise AssertionError(lab)
