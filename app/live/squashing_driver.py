"""Drives real cars with the compiled code that drives the simulated ones: same rule, same steering.

It keeps a flock of the laboratory's cars. Each tick it puts them where they were seen, lets the
flock tick once, and reads off what the flock's computer would send to its cars. What the flock then
makes of its cars' places is thrown away: the next tick brings the true ones.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from typing import Any

import numpy as np

from agents.bodies import car
from agents.bodies.car import driving
from agents.bodies.car_signals import SIGNALS
from agents.bodies.tracking import Tracking
from agents.catalogue import MODELS
from agents.declare import Rule, checked
from agents.model import Model
from agents.motion import Motion
from agents.rows import begun
from agents.rules.squashing import SQUASHING
from agents.start import Start
from app.live.ends import Ends, open_ends
from app.live.lab import Lab
from app.live.pose import Pose, Sighting
from worlds.mission import Goal, Mission
from worlds.refusal import Refusal, unknown
from worlds.world import World

NOT_SIMULATED = {
    "dt": None,
    "noise_xy": 0.0,
    "noise_yaw": 0.0,
    "dropout": 0.0,
    "loss": 0.0,
    "contact": "stops",
}
"""What a real room has of its own and its rule therefore may not be told, and what the flock that
decides takes for it; a tick lasts as long as the loop's."""
OVER = 10
"""Ticks over which the speed of a car is measured: noise of 0.5 mm then makes 7 mm/s."""
CARS = (car.BODY.name, car.STEERED.name)
ON_WHEELS = "-cars"
"""Behind a rule's name: the model of cars that go by it."""
WHEEL, THROTTLE, PACE = (SIGNALS.index(one) for one in ("wheel sent 1", "throttle sent 1", "pace"))
"""Among the body's signals."""


class FlockDriver(Motion):
    """A driver by a rule of the catalogue; see `app.live.driver.Driver` and `Tunable`.

    Raises Refusal if the rule is unknown or cannot drive cars, or for its parameters.
    """

    def __init__(self, lab: Lab):
        self.names = sorted(lab.cars)
        self.model = model_for(lab.rule)
        self.world = room(lab)
        self.seed, self.tick, self.threads = 0, 0, 1
        self.activation, self.noise = "synchronous", "angular"
        self._acted = set()
        self.fixed = NOT_SIMULATED | {"dt": 1.0 / lab.rate}
        fastest = max(one.speed for one in lab.cars.values())
        self.parameters = self.agreed({"v_max": fastest} | dict(lab.parameters))
        n = len(self.names)
        self.place = np.full((n, 2), np.nan)
        self.nose = np.tile((1.0, 0.0), (n, 1))
        self.past: list[deque[tuple[float, float, float]]] = [deque() for _ in self.names]
        self.first_signal = len(self.model.rule.signals)
        self.begin()
        self.warm()
        self.begin()

    def begin(self) -> None:
        """The cars as a flock that has done nothing yet."""
        n = len(self.names)
        still = Start(np.zeros((n, 2)), self.nose.copy(), np.zeros(n, bool), np.zeros(n))
        self._use(begun(still, self.model, 1))

    def warm(self) -> None:
        """Compile, which takes up to a minute the first time, so that the loop need not."""
        from numba.core.errors import NumbaError

        try:
            self.engine.open(self.law, 0)
        except NumbaError:
            raise Refusal(
                f"rule {self.model.rule.name} cannot drive cars: it needs the body that it is "
                "declared with"
            ) from None

    def agreed(self, values: Mapping[str, Any]) -> Any:
        """The parameters of the rule and of the car with these values. Raises Refusal."""
        for name in values:
            if name in NOT_SIMULATED:
                raise Refusal(
                    f"{name} = {values[name]} is not allowed: it is of simulated cars, and real "
                    "ones have their own"
                )
        return checked(self.model.parameters, self.fixed | dict(values), "the laboratory")

    def tune(self, values: Mapping[str, Any]) -> None:
        """Change parameters while it drives. Raises Refusal, and then changes nothing."""
        now = self.parameters.model_dump()
        kept = {name: value for name, value in now.items() if name not in NOT_SIMULATED}
        self.parameters = self.agreed(kept | dict(values))
        self.law = self._make_law()

    def drive(
        self, now: float, sightings: tuple[Sighting, ...], injected: Pose | None
    ) -> dict[str, tuple[float, float]]:
        """(steer, throttle) of every car that is seen, once all have been seen.

        Others hear a car that is not seen where it was last. No command for anybody while there
        is an injected car in the laboratory that is not seen.
        """
        seen = [sighting.name for sighting in sightings if self.found(now, sighting)]
        if np.isnan(self.place).any() or (injected is None and self.follows):
            return {}
        self.position[:], self.heading[:] = self.place, self.nose
        self.speed[:] = [pace(past, nose) for past, nose in zip(self.past, self.nose, strict=True)]
        self._memory[self.first_signal + PACE] = self.speed
        if injected is not None and self.follows:
            self.engine.ground.route[0, :2] = injected.x, injected.y
        self.advance(1)
        most = math.radians(self.law.parameters.wheel_max)
        steer = self._memory[self.first_signal + WHEEL] / most
        throttle = self._memory[self.first_signal + THROTTLE]
        rows = [self.names.index(name) for name in seen]
        return {self.names[row]: (float(steer[row]), float(throttle[row])) for row in rows}

    @property
    def follows(self) -> bool:
        """Whether there is an injected car in the laboratory."""
        return self.world.mission is not None

    def found(self, now: float, sighting: Sighting) -> bool:
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


def room(lab: Lab) -> World:
    """The laboratory as a flock's world: open, with the injected car as its goal."""
    area, plan = lab.area, lab.injected
    goal = None if plan.path == "none" else Mission(goal=Goal(route=(plan.centre,)))
    size = tuple(high - low for low, high in zip(area.low, area.high, strict=True))
    return World("laboratory", size, ("open", "open"), low=tuple(area.low), mission=goal)


def model_for(name: str) -> Model:
    """The cars that go by a rule: a model of cars, or the rule of another one. Raises Refusal."""
    if name in MODELS and MODELS[name].body.name in CARS:
        return MODELS[name]
    rules = rules_by_name()
    if name not in rules:
        models = [one for one, model in MODELS.items() if model.body.name in CARS]
        raise unknown("rule", name, dict.fromkeys([*models, *rules]), "the laboratory")
    rule = rules[name]
    if rule.name + ON_WHEELS in MODELS:
        return MODELS[rule.name + ON_WHEELS]
    if 2 not in rule.dimensions or rule.wish not in ("heading", "velocity"):
        raise Refusal(
            f"rule {name} cannot drive cars: it wishes {rule.wish} in "
            f"{' and '.join(f'{d}-D' for d in rule.dimensions)}, and cars take a heading or a "
            "velocity in 2-D"
        )
    taken = set(rule.parameters.model_fields) & set(car.Car.model_fields)
    if taken and not issubclass(rule.parameters, Tracking):
        raise Refusal(
            f"rule {name} cannot drive cars: it has a parameter {sorted(taken)[0]} of its own, "
            "and so have they"
        )
    return driving(rule)


def rules_by_name() -> dict[str, Rule]:
    """The rules of all models and their names; a model's name stands for its rule too."""
    found = {SQUASHING.name: SQUASHING}
    for name, model in MODELS.items():
        found |= {model.rule.name: model.rule, name: model.rule}
    return found


def open_driven(lab: Lab) -> Ends:
    """The ends that the laboratory's file names, driven by its rule. Raises Refusal."""
    return open_ends(lab, FlockDriver(lab))
