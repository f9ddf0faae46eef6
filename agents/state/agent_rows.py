"""The rows of a flock's arrays: how many there can be, their first values, joining and choosing."""

from __future__ import annotations

import numpy as np

from agents.engine.arrays import Arrays
from agents.engine.message_past import BEGINS
from agents.models.model import Model
from agents.state.start import Start
from worlds.input_error import InputError
from worlds.memory import demand_memory

MOST_AGENTS = 2**31 - 1
"""Rows are numbered by int32."""
BYTES = 200
"""Of an agent: its arrays, their sorted copy, and what its start is drawn from."""
BYTES_OF_A_SIGNAL = 16
"""Of each signal or memory of an agent, and its copy."""
BYTES_OF_A_THREAD = 4
"""Of each agent and thread: a thread counts the cells by itself."""


def demand_memory_for(model: Model, agents: int, threads: int) -> None:
    """Refuse more agents than can be. Raises InputError naming how much memory they would need."""
    if agents > MOST_AGENTS:
        raise InputError(f"agents = {agents} is not allowed: the largest is {MOST_AGENTS}")
    each = BYTES + BYTES_OF_A_SIGNAL * len(model.columns) + BYTES_OF_A_THREAD * threads
    demand_memory(f"agents = {agents}", float(agents) * each)


def begun(start: Start, model: Model, first_id: int) -> Arrays:
    """The arrays of agents at a start, with identities from `first_id` on."""
    n = len(start.position)
    return Arrays(
        np.ascontiguousarray(start.position),
        np.ascontiguousarray(start.heading),
        start.speed.copy(),
        start.informed.astype(np.bool_),
        first_id + start.number,
        np.zeros(n, np.int32),
        np.repeat(model.beginning[:, None], n, axis=1),
        no_crashes(n if model.body.touches else 0, start.position.shape[1]),
        np.empty((n, 0, 0)),
    )


def with_past(arrays: Arrays, ages: int, signals: int, tick: int) -> Arrays:
    """The same agents at a tick with so many ticks of their past; what is older than it, as it.

    `signals`: how many they tell each other. Those without a past have `BEGINS` there.
    """
    n, dim = arrays.position.shape
    before = arrays.past.shape[1]
    past = np.full((n, ages, 2 * dim + 1 + signals if ages else 0), BEGINS)
    for age in range(1, ages + 1 if before else 0):
        past[:, (tick - age) % ages] = arrays.past[:, (tick - min(age, before)) % before]
    return arrays._replace(past=past)


def no_crashes(n: int, dim: int) -> np.ndarray:
    """The crash records (n, 2 + dim) of agents that have not crashed."""
    return np.full((n, 2 + dim), -1.0)


def joined(arrays: Arrays, more: Arrays) -> Arrays:
    """The rows of one behind the other's; agents are the memory's last axis, else the first."""
    both = {
        name: np.concatenate(pair, axis=int(name == "memory"))
        for name, *pair in zip(Arrays._fields, arrays, more, strict=True)
    }
    return Arrays(**both)


def chosen(arrays: Arrays, rows: np.ndarray) -> Arrays:
    """The arrays of some rows, copies."""
    there = rows if len(arrays.crash_record) else np.empty(0, int)
    taken = {
        name: np.take(column, rows, axis=int(name == "memory"))
        for name, column in arrays._asdict().items()
        if name != "crash_record"
    }
    return Arrays(**taken, crash_record=np.take(arrays.crash_record, there, axis=0))
