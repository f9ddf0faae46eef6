"""Cars behind an injected one: their ways in space and time, time upwards, and how all runs end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from app.studies.charts.boxes import draw_key
from app.studies.experiment import Case, Experiment, flock_of
from app.studies.judge.verdict import Verdict, verdicts_on
from app.studies.measure import SUCCESS, Measure, Number, Settings
from worlds.input_error import InputError
from worlds.mission import Goal

if TYPE_CHECKING:
    from agents import Flock

# Runs of cars that follow an injected car on a circle: Jacobs and Koessler, figures 3 and 11.

STOPS = "stops"
"""The signal of a body that others can stop: the ticks in which it was stopped."""


@dataclass(frozen=True)
class Drive:
    """Where cars were, and which of them met."""

    position: np.ndarray
    """Where they were at every tick from 0 on, (T + 1, N, 2), m."""
    met: np.ndarray
    """Ticks at which a car was stopped, by the car and the one nearest to it then, (N, N)."""
    touched: list[tuple[int, int]]
    """The first tick and the row of each car that was stopped."""
    hunts: np.ndarray
    """Which are predators, (N,) bool."""
    crashes: int
    """Cars that are out of the run."""

    @property
    def has_collision(self) -> bool:
        """Whether cars that are no predators have stopped each other, or any has crashed."""
        return bool(self.met[np.ix_(~self.hunts, ~self.hunts)].any()) or self.crashes > 0

    @property
    def has_caught(self) -> bool:
        """Whether a predator and another car have stopped each other."""
        prey = self.met[np.ix_(self.hunts, ~self.hunts)], self.met[np.ix_(~self.hunts, self.hunts)]
        return any(bool(position.any()) for position in prey)


class DrivingSettings(Settings):
    """How long cars drive, and when they count as locked to the injected car and as stuck."""

    kind: ClassVar[str] = "driving"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure(
            "ok", "ok", "Runs that end locked without a fault", "%", whole=True, bounds=SUCCESS
        ),
        Measure(
            "locked",
            "locked",
            "Runs that end locked to the injected car",
            "%",
            whole=True,
            bounds=SUCCESS,
        ),
        Measure("lag", "lag", "Mean angle behind the injected car", "deg", "not locked"),
        Measure(
            "collision",
            "collision",
            "Runs in which cars touch",
            "%",
            "no bodies",
            whole=True,
            bounds=SUCCESS,
        ),
        Measure(
            "stuck",
            "stuck",
            "Runs that end with a car stuck",
            "%",
            "no bodies",
            whole=True,
            bounds=SUCCESS,
        ),
        Measure(
            "outside",
            "outside",
            "Runs in which a car leaves the area",
            "%",
            whole=True,
            bounds=SUCCESS,
        ),
        Measure("apart", "apart", "Mean distance to the nearest other car", "m", "one car"),
        Measure(
            "caught",
            "caught",
            "Runs in which a predator touches",
            "%",
            "no predator",
            whole=True,
            bounds=SUCCESS,
        ),
        Measure("chased", "chased", "Least distance of a predator", "m", "no predator"),
    )

    limit: float = Field(gt=0.0)
    """How long a run lasts, s; its last lap of the injected car is what is looked at."""
    every: int = Field(5, ge=1)
    """Ticks between two looks at which car was stopped."""
    drift: float = Field(45.0, gt=0.0)
    """Change of a car's lag over the last lap below which it is locked, deg."""
    spread: float = Field(90.0, gt=0.0)
    """Largest less least lag of a car in the last lap below which it is locked, deg."""
    crawl: float = Field(0.1, gt=0.0)
    """Mean speed over the last lap below which a car is stuck, m/s."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Drive, and measure it. Raises InputError in a world without an injected car that goes
        round.

        `locked`, `lag`, `stuck` and `apart` are of the last lap, the others of the whole drive.
        What predators do counts in `caught` and `chased` only.
        """
        lap = lap_of(flock)
        if lap > self.ticks(None, flock.dt):
            raise InputError(
                f"limit = {self.limit:g} s is less than a lap of the injected car, "
                f"{lap * flock.dt:.1f} s in {flock.world.name}"
            )
        return self.measure_drive(flock, self.drive(flock, between), lap)

    def drive(self, flock: Flock, between: Callable[[], None] = lambda: None) -> Drive:
        """Drive from tick 0 to the limit."""
        n = len(flock.ids)
        solid = STOPS in flock.model.signals
        met = np.zeros((n, n), int)
        positions = [flock.position[None].copy()]
        before = np.zeros(n)
        touched = []
        for look in range(round(self.ticks(None, flock.dt) / self.every)):
            if look % 100 == 0:
                between()
            positions.append(flock.trace(self.every))
            if solid and n > 1:
                stops = flock.signal(STOPS)
                for row in map(int, np.flatnonzero(stops > before)):
                    if not met[row].any():
                        touched.append((flock.tick, row))
                    met[row, nearest_car(flock.position, row)] += 1
                before = stops.copy()
        hunts = flock.ids <= getattr(flock.parameters, "predators", 0.0)
        return Drive(
            np.concatenate(positions), met, touched, hunts, len(flock.crashes) if solid else 0
        )

    def measure_drive(self, flock: Flock, drive: Drive, lap: int) -> dict[str, Number | None]:
        """The measures of a drive whose last `lap` ticks are looked at."""
        solid = STOPS in flock.model.signals
        prey = drive.position[:, ~drive.hunts]
        late = prey[-lap - 1 :]
        lag = lags(flock, late, len(prey) - 1)
        locked = self.is_locked(lag)
        pace = np.linalg.norm(np.diff(late, axis=0), axis=2).mean(axis=0) / flock.dt
        low = np.array(flock.world.low)
        outside = bool(((prey < low) | (prey > low + np.array(flock.world.size))).any())
        stuck = solid and bool((pace < self.crawl).any())
        ok = locked and not (outside or stuck or (solid and drive.has_collision))
        chases = bool(drive.hunts.any())
        return {
            "ok": 100 * ok,
            "locked": 100 * locked,
            "lag": float(np.degrees(lag.mean())) if locked else None,
            "collision": 100 * drive.has_collision if solid else None,
            "stuck": 100 * stuck if solid else None,
            "outside": 100 * outside,
            "apart": float(nearest_distances(late).mean()) if prey.shape[1] > 1 else None,
            "caught": 100 * drive.has_caught if chases and solid else None,
            "chased": float(least_chase_distance(drive)) if chases else None,
        }

    def is_locked(self, lag: np.ndarray) -> bool:
        """Whether all cars stay behind the injected car by much the same angle, lags (T, N) rad."""
        drift = np.degrees(np.abs(lag[-1] - lag[0]))
        spread = np.degrees(np.ptp(lag, axis=0))
        return bool((drift < self.drift).all() and (spread < self.spread).all())

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.every * round(self.limit / dt / self.every)


def goal_of(flock: Flock) -> Goal:
    """The goal of its world, which the injected car goes after. Raises InputError without one."""
    mission = flock.world.mission
    goal = None if mission is None else mission.goal
    if goal is None:
        raise InputError(f"the world {flock.world.name!r} has no injected car that goes round")
    return goal


def lap_of(flock: Flock) -> int:
    """Ticks in which the injected car goes round its route once. Raises InputError if it does
    not."""
    goal = goal_of(flock)
    if not goal.closed or goal.speed == 0.0:
        raise InputError(f"the world {flock.world.name!r} has no injected car that goes round")
    route = np.array([*goal.route, goal.route[0]])
    return round(
        float(np.linalg.norm(np.diff(route, axis=0), axis=1).sum()) / goal.speed / flock.dt
    )


def lags(flock: Flock, position: np.ndarray, last: int) -> np.ndarray:
    """Angles (T, N) by which cars are behind the injected car about the middle of its route, rad.

    `position` (T, N, 2) are the last ticks up to `last`. The angle of a car goes on from tick to
    tick; at the first one it is within half a turn.
    """
    middle = np.array(goal_of(flock).route).mean(axis=0)
    goal = flock.goal_at(np.arange(last - len(position) + 1, last + 1)) - middle
    away = position - middle
    turned = np.arctan2(goal[:, 1], goal[:, 0])[:, None] - np.arctan2(away[..., 1], away[..., 0])
    turned = np.unwrap(turned, axis=0)
    return turned - 2.0 * np.pi * np.round(turned[0] / (2.0 * np.pi))


def nearest_distances(position: np.ndarray) -> np.ndarray:
    """Distance of each car to the nearest other one, (T, N), m; of positions (T, N, 2), N > 1."""
    apart = np.linalg.norm(position[:, :, None] - position[:, None], axis=3)
    n = position.shape[1]
    apart[:, np.arange(n), np.arange(n)] = np.inf
    return apart.min(axis=2)


def least_chase_distance(drive: Drive) -> float:
    """Least distance between a predator and another car, m."""
    hunters, prey = drive.position[:, drive.hunts], drive.position[:, ~drive.hunts]
    return float(np.linalg.norm(hunters[:, :, None] - prey[:, None], axis=3).min(initial=np.inf))


def nearest_car(position: np.ndarray, row: int) -> int:
    """The row of the car that is nearest to that of `row`; positions (N, 2), N > 1."""
    apart = np.linalg.norm(position - position[row], axis=1)
    apart[row] = np.inf
    return int(apart.argmin())


CARS = ("#2166ac", "#1f9d63", "#c0392b", "#8e44ad", "#0b2545", "#5aa9c9", "#7a828c", "#8c510a")
INJECTED, HUNTER = "#e3b505", "#101418"
"""The injected car is yellow, as in the paper."""
TOUCH = "#d6403a"
WAYS = 3
"""Rows whose run is drawn in space and time, the first ones."""
SHOWN = 1500
"""Points of a way, about."""
BARS = {
    "ok": "#1f9d63",
    "locked": "#2166ac",
    "collision": "#c0392b",
    "stuck": "#b07d12",
    "outside": "#8e44ad",
    "caught": "#101418",
}


def draw_driving(figure: Any, experiment: Experiment, verdicts: list[Verdict], seed: int) -> None:
    """Draw the run of that seed of the first rows above, the share of runs of all rows below."""
    settings = experiment.settings
    assert isinstance(settings, DrivingSettings)
    cases = experiment.cases[:WAYS]
    figure.set_size_inches(4.4 * max(2, len(cases)), 9.0)
    above, below = figure.subfigures(2, 1, height_ratios=[1.5, 1.0])
    panels = above.subplots(1, len(cases), subplot_kw={"projection": "3d"}, squeeze=False)[0]
    for axes, case in zip(panels, cases, strict=True):
        draw_ways(axes, case, settings, seed)
    shares, lags = below.subplots(1, 2, width_ratios=[2.2, 1.0])
    signs = draw_shares(shares, verdicts)
    draw_lags(lags, verdicts_on(verdicts, "lag"))
    draw_key(
        figure,
        signs,
        f"above: a run of each of the first rows, seed {seed}, time upwards, the injected car "
        "yellow, a predator black, a red dot where cars touch; below: all runs",
    )


def draw_ways(axes: Any, case: Case, settings: DrivingSettings, seed: int) -> None:
    """Draw one run in space and time."""
    flock = flock_of(case, seed)
    drive = settings.drive(flock)
    step = max(1, len(drive.position) // SHOWN)
    ticks = np.arange(0, len(drive.position), step)
    time = flock.dt * ticks
    goal = flock.goal_at(ticks)
    if getattr(flock.parameters, "c_goal", 1.0) > 0.0:
        axes.plot(goal[:, 0], goal[:, 1], time, color=INJECTED, linewidth=2.2)
    for row in range(drive.position.shape[1]):
        way = drive.position[ticks, row]
        colour = HUNTER if drive.hunts[row] else CARS[row % len(CARS)]
        axes.plot(way[:, 0], way[:, 1], time, color=colour, linewidth=1.1)
    for tick, row in drive.touched:
        x, y = drive.position[tick, row]
        axes.plot([x], [y], [flock.dt * tick], "o", color=TOUCH, markersize=4)
    low, size = np.array(flock.world.low), np.array(flock.world.size)
    axes.set_xlim(low[0], low[0] + size[0])
    axes.set_ylim(low[1], low[1] + size[1])
    axes.set_zlim(0.0, time[-1])
    axes.set_box_aspect((size[0], size[1], 1.25 * size.max()))
    axes.set_xlabel("x / m")
    axes.set_ylabel("y / m")
    axes.set_zlabel("time / s")
    axes.set_title(f"{case.label}, N = {case.agents}", loc="left")


def draw_shares(axes: Any, verdicts: list[Verdict]) -> list[Any]:
    """Draw the share of runs of each row that end well and of each fault; what is what."""
    from matplotlib.patches import Patch

    names = [
        name
        for name in BARS
        if any(verdict.summary.runs for verdict in verdicts_on(verdicts, name))
    ]
    width = 0.8 / max(1, len(names))
    for k, name in enumerate(names):
        points = verdicts_on(verdicts, name)
        axes.bar(
            [x + (k - 0.5 * (len(names) - 1)) * width for x in range(len(points))],
            [point.summary.mean if point.summary.runs else 0.0 for point in points],
            width,
            color=BARS[name],
        )
    rows = verdicts_on(verdicts, verdicts[0].measure.name)
    labels = [f"{row.case.label}, N = {row.case.agents}".replace(", ", "\n") for row in rows]
    axes.set_xticks(range(len(rows)), labels, fontsize=8)
    axes.tick_params(axis="x", length=0)
    axes.set_ylim(0.0, 103.0)
    axes.set_ylabel("runs / %")
    return [Patch(facecolor=BARS[name], label=name) for name in names]


def draw_lags(axes: Any, points: list[Verdict]) -> None:
    """Draw the lags of the runs that end locked, a dot for each."""
    for x, point in enumerate(points):
        values = [value for value in point.values if value is not None]
        aside = np.random.default_rng(0).uniform(-0.25, 0.25, len(values))
        axes.plot(x + aside, values, ".", color=BARS["locked"], markersize=4, alpha=0.5)
    axes.set_xticks(
        range(len(points)), [point.case.label for point in points], rotation=40, fontsize=8
    )
    axes.set_xlim(-0.6, len(points) - 0.4)
    most = max(
        (value for point in points for value in point.values if value is not None), default=0.0
    )
    axes.set_ylim(0.0, 90.0 if most < 90.0 else 180.0)
    axes.set_ylabel("lag / deg")


PICTURES = {"driving": draw_driving}
