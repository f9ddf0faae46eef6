"""What a page draws by itself: starts, random orders of turns, and gusts.

They are those of `agents.state.start`, `agents.engine.runner` and `agents.conditions`, drawn from
the same numbers: a seed means one run here and in every page. The page's script tries places until
all fit, as `try_positions` does, and lays the rows along space; what is computed of single agents
is compiled.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np

from agents.conditions import Wind
from agents.engine.noise import GUSTS, ORDERS, normal, random_direction, tick_key, uniform
from agents.flock import Flock
from agents.flock_world import world_of_any_seed
from agents.models.declare import NumberParameter, declared
from agents.observables.of_rows import squared_distance
from agents.state.start import FIRST, SPEED, goal_heading, start_gap
from agents.web.web_kinds import as_javascript, farthest_parameters
from worlds.compilation import compiled, entry
from worlds.queries.surroundings import signed_distance


class StartTask(NamedTuple):
    """What a page asks for when it has agents placed."""

    low: np.ndarray
    """Lower corner of the box that they start in, length (3,)."""
    side: np.ndarray
    """Its sides, length (3,); `draw_places` writes them where `density` is not 0."""
    slow: np.ndarray
    """Velocities are uniform between `slow` and `fast` (3,), length per unit of time; where these
    are no numbers, the body has its own."""
    fast: np.ndarray
    lacks_place: np.ndarray
    """1 where an agent has to be placed, uint8 (N,)."""
    density: float
    """Agents per area or volume of the box; 0: the box has its sides."""
    first: int
    """The rows [first, end) are placed."""
    end: int
    attempt: int
    """Number of the try, from 1 on."""
    spacing: float
    """Least distance to the rows before, length."""
    gap: float
    """Least distance to what is solid, length."""


@entry
def draw_places(flock, task, seed):
    """Place the agents that lack a place."""
    n, dim = flock.position.shape
    key = tick_key(seed, FIRST + task.attempt)
    if task.density > 0.0:
        for axis in range(dim):
            task.side[axis] = (n / task.density) ** (1.0 / dim)
    for i in range(task.first, task.end):
        if task.lacks_place[i] != 0:
            for axis in range(dim):
                chance = uniform(key, flock.ids[i], axis)
                flock.position[i, axis] = chance * task.side[axis] + task.low[axis]
    return 0.0


@entry
def count_misplaced(flock, task, surroundings, space):
    """Note which agents are too near to a row before them, or to what is solid; how many are."""
    count = 0.0
    for i in range(task.first, task.end):
        z = flock.position[i, 2] if flock.position.shape[1] == 3 else 0.0
        x, y = flock.position[i, 0], flock.position[i, 1]
        lacks = signed_distance(surroundings, x, y, z) <= task.gap
        if task.spacing > 0.0:
            for j in range(task.first, i):
                near = squared_distance(flock, space, i, j) <= task.spacing * task.spacing
                lacks = lacks or near
        # Without a spacing nobody who had a place can lack one now.
        lacks = lacks and (task.lacks_place[i] != 0 or task.spacing > 0.0)
        task.lacks_place[i] = 1 if lacks else 0
        count += 1.0 if lacks else 0.0
    return count


@compiled
def velocity_along(task, key, agent, axis):
    """A velocity along an axis, uniform as the world's start says."""
    low = task.slow[axis]
    return uniform(key, agent, SPEED + axis) * (task.fast[axis] - low) + low


@entry
def draw_headings(flock, task, seed):
    """Give all agents headings, and speeds: the numbers of which the body makes them, or those that
    the world's start says."""
    dim = flock.position.shape[1]
    key = tick_key(seed, FIRST)
    for i in range(flock.position.shape[0]):
        x, y, z = random_direction(key, flock.ids[i], dim)
        speed = uniform(key, flock.ids[i], SPEED)
        if task.slow[0] <= task.fast[0]:
            vx = velocity_along(task, key, flock.ids[i], 0)
            vy = velocity_along(task, key, flock.ids[i], 1)
            vz = velocity_along(task, key, flock.ids[i], 2) if dim == 3 else 0.0
            speed = math.sqrt(vx * vx + vy * vy + vz * vz)
            if speed > 0.0:
                x, y, z = vx / speed, vy / speed, vz / speed
        flock.heading[i, 0] = x
        flock.heading[i, 1] = y
        if dim == 3:
            flock.heading[i, 2] = z
        flock.speed[i] = speed
    return 0.0


@entry
def draw_order(flock, keys, seed, tick):
    """Write the numbers by which rows take turns at random, see `SequentialEngine.order`."""
    key = tick_key(seed, ORDERS + tick)
    for i in range(flock.ids.shape[0]):
        keys[i] = uniform(key, flock.ids[i], 0)
    return 0.0


class WindTask(NamedTuple):
    """The wind of a run, see `agents.conditions.Wind`."""

    steady: np.ndarray
    """Velocity of the wind, length per unit of time (3,)."""
    pulse: np.ndarray
    """What a pulse adds, length per unit of time (3,)."""
    gust: np.ndarray
    """The gusts of deviation 1 as they blew last, (3,)."""
    known: np.ndarray
    """For how many ticks gusts are known, and with what time step; (2,)."""
    pulse_at: float
    pulse_lasts: float
    gusts: float
    """Their standard deviation, length per unit of time."""
    gust_time: float


def wind_task(flock: Flock) -> WindTask:
    """The wind of a flock."""
    run, wind = flock.options, Wind(flock.options, flock.seed, 1.0, flock.world.dim)
    return WindTask(
        steady=run.wind * wind.along + np.array([0.0, 0.0, run.wind_up]),
        pulse=run.pulse * wind.along,
        gust=np.zeros(3),
        known=np.zeros(2),
        pulse_at=run.pulse_at,
        pulse_lasts=run.pulse_lasts,
        gusts=run.gusts,
        gust_time=run.gust_time,
    )


@entry
def blow(flock, context, air, seed, tick):
    """Write how far the wind carries agents in a tick, see `Wind.displacements`."""
    dt, key = context.lasts, tick_key(seed, GUSTS)
    dim = flock.position.shape[1]
    if air.known[0] > tick or air.known[1] != dt:
        air.known[0], air.known[1] = 0.0, dt
    persistence = math.exp(-dt / air.gust_time)
    fresh = math.sqrt(1.0 - persistence * persistence)
    blows = air.pulse_at <= tick * dt < air.pulse_at + air.pulse_lasts
    for axis in range(3):
        if air.gusts > 0.0:
            known = int(air.known[0])
            if known == 0:
                air.gust[axis] = normal(key, 0, 2 * axis)
            for k in range(known + 1, tick + 2):
                noise = normal(key, k, 2 * axis)
                air.gust[axis] = persistence * air.gust[axis] + fresh * noise
        speed = air.steady[axis] + air.gusts * air.gust[axis]
        if blows:
            speed += air.pulse[axis]
        context.wind[0, axis] = speed * dt if axis < dim else 0.0
    air.known[0] = tick + 1.0
    return 0.0


DRAWS: dict[str, tuple[Callable, tuple[str, ...]]] = {
    "draw_places": (draw_places, ("flock", "start", "seed")),
    "count_misplaced": (count_misplaced, ("flock", "start", "surroundings", "space")),
    "draw_headings": (draw_headings, ("flock", "start", "seed")),
    "draw_order": (draw_order, ("flock", "keys", "seed", "tick")),
    "blow": (blow, ("flock", "context", "air", "seed", "tick")),
}
"""What a page calls to draw, and with which of its arguments."""


def can_begin_anew(flock: Flock) -> bool:
    """Whether a page can draw other starts: not of one that was given by hand."""
    return bool(flock.options.start == "random")


def draws(flock: Flock, is_anew: bool) -> list[str]:
    """What of DRAWS a page of a flock needs, which begins anew or does not."""
    is_crowded = flock.world.is_solid or start_words(flock)["spacing"] > 0
    is_needed = {
        "count_misplaced": is_anew and is_crowded,
        "draw_order": flock.options.activation == "random",
        "blow": flock.options.is_windy,
    }
    return [name for name in DRAWS if is_needed.get(name, is_anew)]


def start_task(flock: Flock) -> StartTask:
    """A task for the agents of a flock."""
    task = StartTask(
        low=in_three(flock.world.low),
        side=in_three(flock.world.size),
        slow=np.full(3, math.nan),
        fast=np.full(3, math.nan),
        lacks_place=np.zeros(len(flock.ids), np.uint8),
        density=0.0,
        first=0,
        end=0,
        attempt=0,
        spacing=0.0,
        gap=0.0,
    )
    region = None if flock.world.mission is None else flock.world.mission.start
    if region is None:
        return task
    task = task._replace(low=in_three(region.low), density=region.density or 0.0)
    if region.high is not None:
        task = task._replace(side=in_three(np.subtract(region.high, region.low)))
    if any(region.speed_low or ()) or any(region.speed_high or ()):
        task = task._replace(slow=in_three(region.speed_low), fast=in_three(region.speed_high))
    return task


def start_words(flock: Flock) -> dict[str, Any]:
    """What the page's script has to know to draw starts."""
    run, world, mission = flock.options, flock.world, flock.world.mission
    region = None if mission is None else mission.start
    path = None if mission is None or region is None else mission.path
    spacing = region.spacing if run.spacing is None and region is not None else run.spacing
    columns = map(as_javascript, flock.model.initial_columns.tolist())
    return {
        "agents": run.agents if flock.kinds.kinds else len(flock.ids) - run.informed,
        "informed": run.informed,
        "others": run.count_of_kinds,
        "spacing": spacing or 0.0,
        "apart": run.spacing or 0.0,
        "whole": region is None,
        "corner": region is None and not world.is_solid,
        "stays": world_of_any_seed(run, flock.model).random is not None,
        "goal": goal_heading(world.dim).tolist(),
        "waypoint": None if path is None else list(path.waypoints[0]),
        "speeds": not math.isnan(start_task(flock).slow[0]) and flock.model.body.speed is None,
        "memory": [[one, len(list(same))] for one, same in groupby(columns)],
    }


def start_reach(flock: Flock) -> float:
    """How far from what is solid a start keeps agents at most, wherever sliders stand, length."""
    parameters, gap = flock.parameters, start_gap(flock.model.body)
    if not flock.world.is_solid or not can_begin_anew(flock):
        return 0.0
    widest = farthest_parameters(flock).model_copy(
        update={
            one.name: max(one.proposed[1], getattr(parameters, one.name))
            for one in declared(type(parameters))
            if isinstance(one, NumberParameter) and one.name not in flock.differing
        }
    )
    return max(start_words(flock)["apart"], 0.0 if gap is None else float(gap(widest)))


def of_parameters(flock: Flock) -> dict[str, tuple[Callable, tuple[str, ...]]]:
    """Plain functions of the parameters, as DRAWS: how far from what is solid agents
    start at least, and with what speed; none of either where that is 0, or said by the world."""
    body, slow = flock.model.body, start_task(flock).slow
    parameters = "context.parameters"
    found: dict[str, tuple[Callable, tuple[str, ...]]] = {}
    gap = start_gap(body)
    if flock.world.is_solid and gap is not None:
        found["start_gap"] = gap, (parameters,)
    if body.speed is not None:
        found["start_speed"] = body.speed, (parameters,)
    elif body.begins is not None and math.isnan(slow[0]):
        found["start_speed"] = body.begins, (parameters, "chance")
    return found


def in_three(corner: Any) -> np.ndarray:
    """Two or three numbers as three."""
    return np.pad(np.asarray(corner, float), (0, 3 - len(corner)))
