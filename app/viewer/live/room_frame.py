"""A control loop's status as a frame for the drawing."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np

from agents.models.declare import Vehicle
from agents.models.model import Model
from app.live.control.injected_target import Injection
from app.live.control.loop_status import Status
from app.live.control.pose import Pose
from app.live.laboratory.lab_file import Lab
from app.live.operating.flock_driver import world_of
from app.viewer.measuring.time_series import TimeSeries
from app.viewer.scene.shown.frame import LOST, SIMULATED, Cars, Frame, Live, MissionProgress
from worlds.world import World

OVER = 0.1
"""Seconds over which speeds are measured: noise of 0.5 mm then makes 7 mm/s."""
TOO_SHORT = 0.02
"""Seconds between two poses of which no speed is made."""
FIRST_SIMULATED = 1000
"""The identity of the first simulated car; that of a real one is its row in the laboratory."""
WHEEL = 45.0
"""Full lock of cars that go by a rule without one, deg."""


@dataclass(frozen=True)
class Setting:
    """What is the same in all frames of one opening of a loop."""

    run: int
    lab: Lab
    world: World
    model: Model

    @staticmethod
    def of(run: int, lab: Lab, model: Model) -> Setting:
        """The setting of an opening."""
        return Setting(run, lab, world_of(lab), model)


@dataclass(frozen=True)
class DrawnCar:
    """One car of a frame."""

    identity: int
    name: str
    state: str
    age: float
    x: float
    y: float
    yaw: float
    speed: float
    steer: float


def frame_of(
    setting: Setting, status: Status, values: Mapping[str, Any], past: Sequence[Status] = ()
) -> Frame:
    """The frame of a status; those before it, oldest first, tell how fast the cars are.

    A lost car stays where it was last seen; one that was never seen is left out.
    """
    cars = placed_cars(status, past)
    yaw = np.array([car.yaw for car in cars])
    lab, count = setting.lab, len(cars)
    lock = math.radians(float(values.get("wheel_max", WHEEL)))
    fastest = max(car.fastest for car in lab.cars.values())
    vehicle = setting.model.body.vehicle or Vehicle()
    injected = status.injected
    goal = None if injected is None else np.array([injected.x, injected.y])
    return Frame(
        run=setting.run,
        tick=status.tick,
        world=setting.world,
        reach=float(values.get(setting.model.rule.reach, math.inf)),
        speed_scale=float(values.get("v_max", fastest)),
        position=np.array([(car.x, car.y) for car in cars]).reshape(count, 2),
        heading=np.stack([np.cos(yaw), np.sin(yaw)], axis=1),
        speed=np.array([car.speed for car in cars]),
        informed=np.zeros(count, bool),
        ids=np.array([car.identity for car in cars], int),
        dt=1.0 / lab.rate,
        unit="s",
        progress=MissionProgress(goal),
        cars=Cars(
            length=float(values.get("length", vehicle.length)),
            width=float(values.get("width", vehicle.width)),
            steering=lock * np.array([car.steer for car in cars]),
            stuck=np.zeros(count, bool),
            predator=np.zeros(count, bool),
        ),
        live=Live(
            names=tuple(car.name for car in cars),
            roster=roster(status),
            states=tuple(car.state for car in cars),
            ages=np.array([car.age for car in cars]),
            fence=lab.area.fence,
            arm=status.arm,
        ),
    )


def roster(status: Status) -> tuple[str, ...]:
    """The names of all cars of a room, the real ones first."""
    return (
        *(car.name for car in status.cars),
        *(companion.name for companion in status.companions),
    )


def placed_cars(status: Status, past: Sequence[Status]) -> list[DrawnCar]:
    """The cars of a status that have a place: the real ones, then the simulated ones."""
    statuses = [
        earlier for earlier in past if status.time - OVER - TOO_SHORT <= earlier.time < status.time
    ]
    real = [
        DrawnCar(
            row, car.name, car.state, car.age, car.pose.x, car.pose.y, car.pose.yaw,
            pace([place(earlier, car.name) for earlier in (*statuses, status)]), car.sent[0],
        )
        for row, car in enumerate(status.cars)
        if car.pose is not None
    ]  # fmt: skip
    simulated = [
        DrawnCar(
            FIRST_SIMULATED + k, companion.name, SIMULATED, 0.0,
            companion.pose.x, companion.pose.y, companion.pose.yaw,
            pace([simulated_place(other, companion.name) for other in (*statuses, status)]),
            companion.steer,
        )
        for k, companion in enumerate(status.companions)
    ]  # fmt: skip
    return real + simulated


Place = tuple[float, float, float]
"""When (s) and where (m)."""


def place(status: Status, name: str) -> Place | None:
    """When and where a car was last seen, by a status; None if it never was."""
    for car in status.cars:
        if car.name == name and car.pose is not None:
            return status.time - car.age, car.pose.x, car.pose.y
    return None


def simulated_place(status: Status, name: str) -> Place | None:
    """When and where a simulated car is, by a status; None if there is none of this name."""
    for companion in status.companions:
        if companion.name == name:
            return status.time, companion.pose.x, companion.pose.y
    return None


def pace(places: Sequence[Place | None]) -> float:
    """The speed (m/s) from the first of these places to the last; 0 where none can be told.

    >>> pace([None, (10.0, 1.0, 1.0), (10.5, 1.0, 1.25)])
    0.5
    """
    valid = [place for place in places if place is not None]
    if not valid:
        return 0.0
    (then, x, y), (now, at_x, at_y) = valid[0], valid[-1]
    return math.hypot(at_x - x, at_y - y) / (now - then) if now - then >= TOO_SHORT else 0.0


def frame_without_loop(frame: Frame) -> Frame:
    """The last frame of a loop that is gone: nobody knows where its cars are."""
    live = frame.live
    if live is not None:
        states = tuple(state if state == SIMULATED else LOST for state in live.states)
        live = replace(live, states=states, arm="safe")
    return replace(frame, speed=np.zeros(len(frame.ids)), live=live)


# What is measured of a room: the times of its loop, how close its cars are, how they lag.

EVERY = 0.1
"""Seconds between two values, at least."""
SLACK = 1e-9
MS = 1000.0


class RoomReadings:
    """What is measured of a room, over the seconds since it was opened.

    One thread notes; others may read it meanwhile.
    """

    def __init__(self, plan: Injection):
        """`plan` is how the injected car moves."""
        self.plan = plan
        self.began: float | None = None
        """`Status.time` of the first status, s."""
        self.noted = -math.inf
        """That of the last one that was taken, s."""
        self.loop = TimeSeries(gaps=True)
        """From tick to tick, median of the last ones, ms."""
        self.worst = TimeSeries(gaps=True)
        """From tick to tick, the longest of the last ones, ms."""
        self.latency = TimeSeries(gaps=True)
        """From a frame to its commands, median of the last ones, ms."""
        self.least = TimeSeries(gaps=True)
        """Between the middles of any two cars, real or simulated, m."""
        self.lags: dict[str, TimeSeries] = {}
        """By car, how far it is behind an injected car that goes round a circle, deg; only of cars
        that have lagged, with a gap where one was not there."""

    def note(self, status: Status) -> None:
        """Take a status, unless it follows the last one too soon.

        A lost car has no place: where it is nobody knows.
        """
        if status.time < self.noted + EVERY - SLACK:
            return
        self.began = status.time if self.began is None else self.began
        self.noted = status.time
        poses = {
            car.name: car.pose
            for car in status.cars
            if car.pose is not None and car.tracking != "lost"
        } | {companion.name: companion.pose for companion in status.companions}
        now = status.time - self.began
        self.loop.add(now, MS * status.period.median)
        self.worst.add(now, MS * status.period.worst)
        self.latency.add(now, MS * status.latency.median)
        self.least.add(now, least_distance(list(poses.values())))
        lags = {} if status.injected is None else phase_lags(self.plan, status.injected, poses)
        new = lags.keys() - self.lags.keys()
        self.lags = self.lags | {name: TimeSeries(gaps=True) for name in lags if name in new}
        for name, series in self.lags.items():
            series.add(now, lags.get(name, math.nan))


def least_distance(poses: list[Pose]) -> float:
    """The distance of the two that are closest, m; NaN of fewer than two."""
    apart = [math.hypot(a.x - b.x, a.y - b.y) for a, b in combinations(poses, 2)]
    return min(apart, default=math.nan)


def phase_lags(plan: Injection, injected: Pose, poses: dict[str, Pose]) -> dict[str, float]:
    """By how much each is behind the injected car round its circle, deg; none off a circle.

    The convention is that of `app.studies.figures.driving.lags`, along the injected car's sense.
    """
    if plan.path != "circle":
        return {}
    sense = -1.0 if plan.speed < 0.0 else 1.0
    ahead = angle(plan, injected)
    return {
        name: wrapped_degrees(sense * (ahead - angle(plan, pose))) for name, pose in poses.items()
    }


def angle(plan: Injection, pose: Pose) -> float:
    """Where a pose is about the centre of the circle, rad."""
    return math.atan2(pose.y - plan.centre[1], pose.x - plan.centre[0])


def wrapped_degrees(turned: float) -> float:
    """An angle (rad) in (-180, 180] deg.

    >>> wrapped_degrees(-math.pi), wrapped_degrees(0.5 * math.pi)
    (180.0, 90.0)
    """
    degrees = math.degrees(math.remainder(turned, 2.0 * math.pi))
    return 180.0 if degrees <= -180.0 else degrees
