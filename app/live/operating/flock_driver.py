"""Drives real cars with the compiled code that drives the simulated ones: same rule, same steering.

It keeps a flock of the laboratory's cars. Each tick it puts them where they were seen, lets the
flock tick once, and reads off what the flock's computer would send to its cars. What the flock then
makes of its cars' places is thrown away: the next tick brings the true ones. Simulated cars beside
them are further rows of the same flock, which stay where it brings them.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from agents.catalogue import cars_for_rule
from agents.engine.arrays import Arrays
from agents.models.declare import checked
from agents.models.model import Model
from agents.motion.motion import Motion
from agents.state.agent_rows import start_arrays
from agents.state.start import Start
from app.live.control.pose import Companion, NoFreeSpace, Pose, Sighting
from app.live.laboratory.lab_file import Lab
from worlds.input_error import InputError
from worlds.mission import Goal, Mission
from worlds.world import World

# Simulated cars beside real ones: how many there may be, where they begin, their rows.

APART = 0.6
"""Metres between the middles of a car that begins and of any other, the injected one too."""
TRIES = 200
"""Places that are tried for a car."""


def simulated_car_name(number: int) -> str:
    """The name of a simulated car, the first being number 1."""
    return f"sim {number}"


def demand_allowed(lab: Lab, count: int) -> None:
    """Raise InputError unless the laboratory may have so many simulated cars."""
    most = lab.simulated.most
    if not 0 <= count <= most:
        bound = "at least 0" if count < 0 else f"at most {most} (the laboratory's file)"
        raise InputError(f"simulated cars = {count} is not allowed: {bound}")


def companion_start(
    lab: Lab, number: int, occupied: Iterable[Sequence[float]], size: float
) -> Pose:
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
    others = np.array([tuple(place) for place in occupied]).reshape(-1, 2)
    gaps = np.linalg.norm(tried[:, None] - others[None], axis=2).min(axis=1, initial=math.inf)
    free = np.flatnonzero(gaps >= apart)
    if not len(free):
        raise NoFreeSpace(
            f"{simulated_car_name(number)} has no room: none of {TRIES} places within the fence "
            f"is {apart:g} m from every other car"
        )
    x, y = (float(candidate) for candidate in tried[free[0]])
    return Pose(x, y, circle_yaw(lab, x, y) if lab.injected.path == "circle" else yaw)


def companion_starts(
    lab: Lab, kept_count: int, count: int, taken_places: Iterable[Sequence[float]], size: float
) -> list[Pose]:
    """Where simulated cars `kept_count` + 1 to `count` begin; for the rest see `companion_start`.

    Raises NoFreeSpace with the number that would fit.
    """
    occupied = [tuple(place) for place in taken_places]
    more: list[Pose] = []
    for number in range(kept_count + 1, count + 1):
        try:
            more.append(companion_start(lab, number, occupied, size))
        except NoFreeSpace as refused:
            raise NoFreeSpace(
                f"simulated cars = {count} is not allowed: {refused}; {number - 1} would fit"
            ) from None
        occupied.append((more[-1].x, more[-1].y))
    return more


def circle_yaw(lab: Lab, x: float, y: float) -> float:
    """The yaw (rad) at (x, y) of a car that goes round the injected car's circle in its sense."""
    plan = lab.injected
    outwards = math.atan2(y - plan.centre[1], x - plan.centre[0])
    sense = 0.5 * math.pi if plan.speed >= 0.0 else -0.5 * math.pi
    return math.remainder(outwards + sense, 2.0 * math.pi)


def resize_arrays(arrays: Arrays, kept_count: int, more: Sequence[Pose], model: Model) -> Arrays:
    """The first `kept_count` rows of a flock with their memory, and rows of cars that begin."""
    n = kept_count + len(more)
    position, heading = np.zeros((n, 2)), np.tile((1.0, 0.0), (n, 1))
    for row, pose in enumerate(more, kept_count):
        position[row] = pose.x, pose.y
        heading[row] = math.cos(pose.yaw), math.sin(pose.yaw)
    start_values = start_arrays(
        Start(position, heading, np.zeros(n, bool), np.zeros(n), np.arange(n)), model, 1
    )
    for name, column in start_values._asdict().items():
        before = getattr(arrays, name)
        if name == "memory":
            column[:, :kept_count] = before[:, :kept_count]
        else:
            column[:kept_count] = before[:kept_count]
    return start_values


NOT_SIMULATED = {
    "dt": None,
    "noise_xy": 0.0,
    "noise_yaw": 0.0,
    "dropout": 0.0,
    "loss": 0.0,
    "contact": "stops",
}
"""What a real room has of its own and its rule therefore may not be told, and what the flock that
decides takes for it, which goes for simulated cars too; a tick lasts as long as the loop's."""
AT_ONCE = {"latency": 0.0, "hop": 0.0}
"""The radio of simulated cars, unless the laboratory says otherwise; real ones have their own."""
COMPILING = "compiling {} for this machine: about half a minute, and only this first time ..."
"""What is said while a rule is compiled; once it is, it is kept for later starts."""
OVER = 10
"""Ticks over which the speed of a car is measured: noise of 0.5 mm then makes 7 mm/s."""


class FlockDriver(Motion):
    """A driver by a rule of the catalogue; see `app.live.control.pose`: `TunableDriver`,
    `CompanionDriver`.

    `tell` is called with a line if the rule must be compiled. Raises InputError if the rule is
    unknown or cannot drive cars, for its parameters, or if the simulated cars do not fit an empty
    room.
    """

    def __init__(self, lab: Lab, tell: Callable[[str], object] | None = None):
        self.lab = lab
        self.names = sorted(lab.cars)
        self.model = cars_for_rule(lab.rule)
        vehicle = self.model.body.vehicle
        if vehicle is None:
            raise InputError(f"rule {lab.rule} cannot drive cars: its body is no vehicle")
        self.vehicle = vehicle
        self.world = world_of(lab)
        self.seed, self.tick, self.threads = 0, 0, 1
        self._acted = set()
        self.fixed = NOT_SIMULATED | {"dt": 1.0 / lab.rate}
        fastest = max(car.speed for car in lab.cars.values())
        self.parameters = self.check_values({"v_max": fastest} | AT_ONCE | dict(lab.parameters))
        n = len(self.names)
        self.place = np.full((n, 2), np.nan)
        self.nose = np.tile((1.0, 0.0), (n, 1))
        self.past: list[deque[tuple[float, float, float]]] = [deque() for _ in self.names]
        self.target: tuple[float, float] | None = None
        """Where the injected car was last, m."""
        self.wanted = lab.simulated.cars
        """How many simulated cars there are to be; they begin once all real ones were seen."""
        self.begin()
        companion_starts(
            lab, 0, lab.simulated.cars, [], self.size
        )  # they must fit an empty room at least
        self.compile(tell)
        self.begin()

    def begin(self) -> None:
        """The cars as a flock that has done nothing yet."""
        n = len(self.names)
        number = np.arange(n)
        still = Start(np.zeros((n, 2)), self.nose.copy(), np.zeros(n, bool), np.zeros(n), number)
        self._set_arrays(start_arrays(still, self.model, 1))

    def compile(self, tell: Callable[[str], object] | None) -> None:
        """Compile, which takes up to a minute the first time, so that the loop need not."""
        from numba.core.errors import NumbaError

        if tell is not None and not self.is_compiled:
            tell(COMPILING.format(self.model.name))
        try:
            self.engine.open(self.context, 0)
        except NumbaError:
            raise InputError(
                f"rule {self.model.rule.name} cannot drive cars: it needs the body that it is "
                "declared with"
            ) from None

    def check_values(self, values: Mapping[str, Any]) -> Any:
        """The parameters of the rule and of the car with these values. Raises InputError."""
        for name in values:
            if name in NOT_SIMULATED:
                raise InputError(
                    f"{name} = {values[name]} is not allowed: it is of simulated cars, and real "
                    "ones have their own"
                )
        return checked(self.model.parameters, self.fixed | dict(values), "the laboratory")

    def tune(self, values: Mapping[str, Any]) -> None:
        """Change parameters while it drives. Raises InputError, and then changes nothing."""
        now = self.parameters.model_dump()
        unchanged = {name: value for name, value in now.items() if name not in NOT_SIMULATED}
        self.parameters = self.check_values(unchanged | dict(values))
        self.context = self._make_context()

    def drive(
        self, now: float, sightings: tuple[Sighting, ...], injected: Pose | None, running: bool
    ) -> dict[str, tuple[float, float]]:
        """(steer, throttle) of every car that is seen, once all have been seen.

        Others hear a car that is not seen where it was last. No command for anybody while there
        is an injected car in the laboratory that is not seen. Raises
        NoFreeSpace, once, if the simulated cars have no space to begin: there are none then.
        """
        seen_names = [sighting.name for sighting in sightings if self.place_car(now, sighting)]
        if injected is not None:
            self.target = injected.x, injected.y
        if not self.is_placed or (injected is None and self.has_injected_car):
            self.stop_companions()
            return {}
        if self.wanted != self.simulated:
            wanted_count, self.wanted = (
                self.wanted,
                self.simulated,
            )  # what is refused is not tried again
            self.set_companion_count(wanted_count)
            self.wanted = wanted_count
        n = len(self.names)
        self.position[:n], self.heading[:n] = self.place, self.nose
        self.speed[:n] = [pace(past, nose) for past, nose in zip(self.past, self.nose, strict=True)]
        self.signal_row(self.vehicle.pace)[:n] = self.speed[:n]
        if injected is not None and self.has_injected_car:
            self.engine.surroundings.route[0, :2] = injected.x, injected.y
        self.advance_once(running)
        most = math.radians(self.context.parameters.wheel_max)
        steer = self.signal_row(self.vehicle.wheel) / most
        throttle = self.signal_row(self.vehicle.throttle)
        rows = [self.names.index(name) for name in seen_names]
        return {self.names[row]: (float(steer[row]), float(throttle[row])) for row in rows}

    def advance_once(self, running: bool) -> None:
        """Let the flock tick; while the cars do not run, simulated ones stay where they are."""
        if running:
            self.advance(1)
            return
        n = len(self.names)
        own = self.position[n:], self.heading[n:], self.arrays.memory[:, n:]
        before = [column.copy() for column in own]
        self.advance(1)
        for column, values in zip(own, before, strict=True):
            column[:] = values
        self.stop_companions()
        # Who does not get on because it may not is not stuck.
        self.signal_row(self.vehicle.stuck)[:] = 0.0

    def stop_companions(self) -> None:
        """Stop the simulated cars where they are."""
        n = len(self.names)
        self.speed[n:] = self.signal_row(self.vehicle.pace)[n:] = 0.0

    def signal_row(self, name: str) -> np.ndarray:
        """One of the signals of all cars, real ones first; a view."""
        return self.arrays.memory[self.model.columns.index(name)]

    @property
    def is_placed(self) -> bool:
        """Whether it is known where everybody is, or was last: each car and the injected one."""
        return not np.isnan(self.place).any() and not (
            self.target is None and self.has_injected_car
        )

    @property
    def simulated(self) -> int:
        """How many simulated cars there are."""
        return len(self.ids) - len(self.names)

    @property
    def companions(self) -> tuple[Companion, ...]:
        """The simulated cars as they are after the last tick."""
        n = len(self.names)
        has_moved = 1.0 - self.signal_row(self.vehicle.fresh)
        wheels = has_moved * self.signal_row(self.vehicle.steering)
        share = np.clip(wheels / math.radians(self.context.parameters.wheel_max), -1.0, 1.0)
        return tuple(
            Companion(simulated_car_name(number), Pose(x, y, math.atan2(uy, ux)), steer)
            for number, ((x, y), (ux, uy), steer) in enumerate(
                zip(
                    self.position[n:].tolist(),
                    self.heading[n:].tolist(),
                    share[n:].tolist(),
                    strict=True,
                ),
                1,
            )
        )

    def accompany(self, count: int) -> None:
        """Have so many simulated cars from now on: new ones begin where there is room, the last
        ones leave first. Raises InputError, and then changes nothing."""
        demand_allowed(self.lab, count)
        if self.is_placed:
            self.set_companion_count(count)
        self.wanted = count

    def set_companion_count(self, count: int) -> None:
        """Make it so many simulated cars. Raises NoFreeSpace, and then changes nothing."""
        n = len(self.names)
        kept_count = n + min(count, self.simulated)
        occupied = [*self.place, *self.position[n:kept_count]]
        if self.target is not None:
            occupied.append(self.target)
        more = companion_starts(self.lab, kept_count - n, count, occupied, self.size)
        self._set_arrays(resize_arrays(self.arrays, kept_count, more, self.model))

    @property
    def size(self) -> float:
        """The longest line in a car, m."""
        body = self.context.parameters
        return math.hypot(body.length, body.width)

    @property
    def has_injected_car(self) -> bool:
        """Whether there is an injected car in the laboratory."""
        return self.world.mission is not None

    def place_car(self, now: float, sighting: Sighting) -> bool:
        """Take down where a car is; whether it is one of ours and seen."""
        pose = sighting.pose
        if sighting.name not in self.names or pose is None or not sighting.valid:
            return False
        row = self.names.index(sighting.name)
        self.place[row] = pose.x, pose.y
        self.nose[row] = math.cos(pose.yaw), math.sin(pose.yaw)
        self.past[row].append((now, pose.x, pose.y))
        if len(self.past[row]) > OVER + 1:
            self.past[row].popleft()
        return True


def pace(past: deque[tuple[float, float, float]], nose: np.ndarray) -> float:
    """The speed (m/s) of a car along its nose over the last ticks; below 0 backwards."""
    (before, x, y), (now, at_x, at_y) = past[0], past[-1]
    if now <= before:
        return 0.0
    return float((at_x - x) * nose[0] + (at_y - y) * nose[1]) / (now - before)


def world_of(lab: Lab) -> World:
    """The laboratory as a flock's world: open, with the injected car as its goal."""
    area, plan = lab.area, lab.injected
    goal = None if plan.path == "none" else Mission(goal=Goal(route=(plan.centre,)))
    size = tuple(high - low for low, high in zip(area.low, area.high, strict=True))
    return World("laboratory", size, ("open", "open"), low=tuple(area.low), mission=goal)
