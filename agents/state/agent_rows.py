"""The rows of a flock's arrays: how many there can be, their first values, joining and choosing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from agents.engine.arrays import Arrays
from agents.engine.cache import compile_to_disk
from agents.engine.message_past import BEGINS
from agents.models.model import Model
from agents.state.start import Start
from worlds.input_error import InputError
from worlds.memory import demand_memory
from worlds.queries.crossing import skin
from worlds.queries.surroundings import Surroundings, signed_distance
from worlds.world import World

BYTES = 135
"""Of an agent in space: its arrays, their sorted copy, a cell. In a plane 97, at a start less."""
BYTES_OF_A_SIGNAL = 16
"""Of each signal or memory of an agent, and its copy."""
BYTES_OF_A_THREAD = 4
"""Of each agent and thread: a thread counts the cells by itself."""


def demand_memory_for(model: Model, agents: int, threads: int) -> None:
    """Refuse more agents than can be. Raises InputError naming how much memory they would need."""
    each = BYTES + BYTES_OF_A_SIGNAL * len(model.columns) + BYTES_OF_A_THREAD * threads
    demand_memory(f"agents = {agents}", float(agents) * each)


def start_arrays(start: Start, model: Model, first_id: int) -> Arrays:
    """The arrays of agents at a start, with identities from `first_id` on."""
    n = len(start.position)
    return Arrays(
        np.ascontiguousarray(start.position),
        np.ascontiguousarray(start.heading),
        start.speed.copy(),
        start.informed.astype(np.bool_),
        first_id + start.number,
        np.zeros(n, np.int32),
        np.repeat(model.initial_columns[:, None], n, axis=1),
        no_crashes(n if model.body.touches else 0, start.position.shape[1]),
        np.empty((n, 0, 0)),
        np.empty(0),
        np.empty((0, 3)),
        np.empty((n, 0)),
    )


def resize_past(arrays: Arrays, ages: int, signals: int, tick: int) -> Arrays:
    """The same agents at a tick with so many ticks of their past; what is older than it, as it.

    `signals`: how many they tell each other. Those without a past have `BEGINS` there.
    """
    n, dim = arrays.position.shape
    old_ages = arrays.past.shape[1]
    past = np.full((n, ages, 2 * dim + 1 + signals if ages else 0), BEGINS)
    for age in range(1, ages + 1 if old_ages else 0):
        past[:, (tick - age) % ages] = arrays.past[:, (tick - min(age, old_ages)) % old_ages]
    return arrays._replace(past=past)


def no_crashes(n: int, dim: int) -> np.ndarray:
    """The crash records (n, 2 + dim) of agents that have not crashed."""
    return np.full((n, 2 + dim), -1.0)


def join_arrays(arrays: Arrays, new_arrays: Arrays) -> Arrays:
    """The rows of one behind the other's; agents are the memory's last axis, else the first."""
    joined = {
        name: np.concatenate(pair, axis=int(name == "memory"))
        for name, *pair in zip(Arrays._fields, arrays, new_arrays, strict=True)
    }
    return Arrays(**joined)


def select_rows(arrays: Arrays, rows: np.ndarray) -> Arrays:
    """The arrays of some rows, copies."""
    crashed_rows = rows if len(arrays.crash_record) else np.empty(0, int)
    rows_of_fields = {
        name: np.take(column, rows, axis=int(name == "memory"))
        for name, column in arrays._asdict().items()
        if name not in ("crash_record", "kind", "wish")
    }
    crash_record = np.take(arrays.crash_record, crashed_rows, axis=0)
    kind = arrays.kind[rows] if len(arrays.kind) else arrays.kind
    wish = arrays.wish[rows] if len(arrays.wish) else arrays.wish
    return Arrays(**rows_of_fields, crash_record=crash_record, kind=kind, wish=wish)


# Who has crashed: when, where, and against what.

CAUSES = {1: "another agent", 2: "an obstacle or a wall"}
"""What an agent can have touched, as `agents.models.declare.Body.touches` answers it."""


@dataclass(frozen=True)
class Crashes:
    """The crashes of a run, in the order of ticks and then of rows; (M,) each."""

    tick: np.ndarray
    """The tick at whose beginning it touched something, int."""
    id: np.ndarray
    row: np.ndarray
    place: np.ndarray
    """Where it was then, (M, dim), length."""
    cause: np.ndarray
    """A key of CAUSES, int."""

    def __len__(self) -> int:
        return len(self.tick)


def crashes(arrays: Arrays) -> Crashes:
    """The crashes in the crash records of a flock's arrays."""
    crash_record = arrays.crash_record
    row = np.flatnonzero(crash_record[:, 0] >= 0.0)
    row = row[np.argsort(crash_record[row, 0], kind="stable")]
    tick, cause = crash_record[row, :2].astype(int).T
    return Crashes(tick, arrays.ids[row], row, crash_record[row, 2:], cause)


def active(arrays: Arrays) -> np.ndarray:
    """Which agents have not crashed, (N,) bool."""
    if not len(arrays.crash_record):
        return np.ones(len(arrays.ids), bool)
    return arrays.crash_record[:, 0] < 0.0


# Whether arrays that come from a file are a flock's: what compiled code takes on trust.

FARTHEST = 1e12
"""How far an agent can be from the origin, length."""
LARGEST = 2**53
"""No tick and no identity is larger, so that each is exact as a float too."""
ROUNDED = 1e-6
"""By how much the length of a heading may be off 1."""


def demand_usable(arrays: Arrays, world: World, origin: str) -> None:
    """Raise InputError, naming the row, where the rows of a file cannot be a flock in a world."""
    n = len(arrays.ids)
    for name in ("position", "heading", "speed"):
        demand(np.isfinite(getattr(arrays, name)), f"a {name} that is no finite number", origin)
    demand(np.abs(arrays.position) <= FARTHEST, "a position that is too far away", origin)
    length = np.linalg.norm(arrays.heading, axis=1)
    demand(np.abs(length - 1.0) <= ROUNDED, "a heading that is no unit vector", origin)
    demand((arrays.ids >= 0) & (arrays.ids < LARGEST), "an identity that none can be", origin)
    if len(np.unique(arrays.ids)) < n:
        raise InputError(f"{origin} has two agents of one identity at one tick")
    path = None if world.mission is None else world.mission.path
    legs = 0 if path is None else len(path.waypoints)
    demand((arrays.leg >= 0) & (arrays.leg <= legs), "a waypoint that is not there", origin)
    if len(arrays.crash_record):
        tick, cause = arrays.crash_record[:, :2].T
        is_known = (tick < 0.0) | np.isin(cause, list(CAUSES))
        is_finite = np.isfinite(arrays.crash_record).all(axis=1) & (np.abs(tick) < LARGEST)
        demand(is_known & is_finite, "a crash that cannot be", origin)


def demand(is_sound: np.ndarray, fault: str, origin: str) -> None:
    """Raise InputError for the first row that is not sound, (N,) or (N, dim)."""
    is_sound_row = is_sound.reshape(len(is_sound), -1).all(axis=1)
    if not is_sound_row.all():
        row = int(np.argmin(is_sound_row))
        raise InputError(f"{origin} holds {fault} (row {row} of its tick)")


# Agents that are where none can be: inside an obstacle or beyond a solid edge.


@dataclass(frozen=True)
class StrayAgents:
    """The first row of the agents that are where none can be, and how many these are."""

    id: int
    row: int
    tick: int
    place: np.ndarray
    """(dim,), length."""
    depth: float
    """How far it is inside what is solid at least, length."""
    number: int
    """How many are, itself among them."""

    def __str__(self) -> str:
        place = ", ".join(f"{x:.6g}" for x in self.place)
        others = f", and {self.number - 1} more" if self.number > 1 else ""
        return (
            f"agent {self.id}{others} where it cannot be: {self.depth:.3g} inside what is solid at "
            f"({place}), tick {self.tick}"
        )


@compile_to_disk
def strays(surroundings, position, crash_record):
    """The first row that is inside something solid or -1, how far, and how many rows are.

    Rounding is none of it; those that have crashed lie where they lie.
    """
    first, depth, number = -1, 0.0, 0
    for i in range(position.shape[0]):
        x, y = position[i, 0], position[i, 1]
        z = position[i, 2] if position.shape[1] == 3 else 0.0
        d = signed_distance(surroundings, x, y, z)
        flies = crash_record.shape[0] == 0 or crash_record[i, 0] < 0.0
        if flies and d < -skin(x, y, z):
            number += 1
            if first < 0:
                first, depth = i, -d
    return first, depth, number


def stray(surroundings: Surroundings, arrays: Arrays, tick: int) -> StrayAgents | None:
    """The first agent that is inside something solid, None if nobody is."""
    row, depth, number = strays(surroundings, arrays.position, arrays.crash_record)
    if row < 0:
        return None
    place = arrays.position[row].copy()
    return StrayAgents(int(arrays.ids[row]), int(row), tick, place, float(depth), int(number))
