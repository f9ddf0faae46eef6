"""Simulated cars beside real ones: how many there may be, where they begin, their rows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from agents.engine.arrays import Arrays
from agents.models.model import Model
from agents.state.agent_rows import begun
from agents.state.start import Start
from app.live.control.driver import NoFreeSpace
from app.live.control.pose import Pose
from app.live.laboratory.lab_file import Lab
from worlds.input_error import InputError

APART = 0.6
"""Metres between the middles of a car that begins and of any other, the injected one too."""
TRIES = 200
"""Places that are tried for a car."""


def named(number: int) -> str:
    """The name of a simulated car, the first being number 1."""
    return f"sim {number}"


def demand_allowed(lab: Lab, count: int) -> None:
    """Raise InputError unless the laboratory may have so many simulated cars."""
    most = lab.simulated.most
    if not 0 <= count <= most:
        bound = "at least 0" if count < 0 else f"at most {most} (the laboratory's file)"
        raise InputError(f"simulated cars = {count} is not allowed: {bound}")


def begins(lab: Lab, number: int, taken: Iterable[Sequence[float]], size: float) -> Pose:
    """Where simulated car `number` begins: within the fence, clear of the places (m) taken.

    It heads along the injected car's circle, or anywhere if that goes no circle. `size` is the
    longest line in a car, m. A car tries the same places whenever it begins, which follow from the
    seed and its number. Raises NoFreeSpace if none of them is free.
    """
    area = lab.area
    rng = np.random.default_rng([lab.simulated.seed, number])
    low, high = np.array(area.low) + area.fence, np.array(area.high) - area.fence
    tried = rng.uniform(low, high, (TRIES, 2))
    yaw = float(rng.uniform(-math.pi, math.pi))
    apart = max(APART, size)
    others = np.array([tuple(one) for one in taken]).reshape(-1, 2)
    gaps = np.linalg.norm(tried[:, None] - others[None], axis=2).min(axis=1, initial=math.inf)
    free = np.flatnonzero(gaps >= apart)
    if not len(free):
        raise NoFreeSpace(
            f"{named(number)} has no room: none of {TRIES} places within the fence is {apart:g} m "
            "from every other car"
        )
    x, y = (float(one) for one in tried[free[0]])
    return Pose(x, y, along_circle(lab, x, y) if lab.injected.path == "circle" else yaw)


def begin_more(
    lab: Lab, kept: int, count: int, taken: Iterable[Sequence[float]], size: float
) -> list[Pose]:
    """Where simulated cars `kept` + 1 to `count` begin; for the rest see `begins`.

    Raises NoFreeSpace with the number that would fit.
    """
    occupied = [tuple(one) for one in taken]
    more: list[Pose] = []
    for number in range(kept + 1, count + 1):
        try:
            more.append(begins(lab, number, occupied, size))
        except NoFreeSpace as refused:
            raise NoFreeSpace(
                f"simulated cars = {count} is not allowed: {refused}; {number - 1} would fit"
            ) from None
        occupied.append((more[-1].x, more[-1].y))
    return more


def along_circle(lab: Lab, x: float, y: float) -> float:
    """The yaw (rad) at (x, y) of a car that goes round the injected car's circle in its sense."""
    plan = lab.injected
    outwards = math.atan2(y - plan.centre[1], x - plan.centre[0])
    sense = 0.5 * math.pi if plan.speed >= 0.0 else -0.5 * math.pi
    return math.remainder(outwards + sense, 2.0 * math.pi)


def resized(arrays: Arrays, kept: int, more: Sequence[Pose], model: Model) -> Arrays:
    """The first `kept` rows of a flock with their memory, and rows of cars that begin."""
    n = kept + len(more)
    position, heading = np.zeros((n, 2)), np.tile((1.0, 0.0), (n, 1))
    for row, pose in enumerate(more, kept):
        position[row] = pose.x, pose.y
        heading[row] = math.cos(pose.yaw), math.sin(pose.yaw)
    made = begun(Start(position, heading, np.zeros(n, bool), np.zeros(n), np.arange(n)), model, 1)
    for name, column in made._asdict().items():
        before = getattr(arrays, name)
        if name == "memory":
            column[:, :kept] = before[:, :kept]
        else:
            column[:kept] = before[:kept]
    return made
