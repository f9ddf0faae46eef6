"""The rows of a flock's arrays: how they begin, are joined and are left."""

from __future__ import annotations

import numpy as np

from agents.engine.arrays import Arrays
from agents.model import Model
from agents.start import Start


def begun(start: Start, model: Model, first_id: int) -> Arrays:
    """The arrays of agents that begin there, with identities from `first_id` on."""
    n = len(start.position)
    return Arrays(
        np.ascontiguousarray(start.position),
        np.ascontiguousarray(start.heading),
        start.speed.copy(),
        start.informed.astype(np.bool_),
        np.arange(first_id, first_id + n),
        np.zeros(n, np.int32),
        np.tile(model.beginning[:, None], n),
    )


def joined(arrays: Arrays, more: Arrays) -> Arrays:
    """The rows of both; agents are the last axis of the memory and the first of all else."""
    *columns, memory = zip(arrays, more, strict=True)
    return Arrays._make([*(np.concatenate(pair) for pair in columns), np.hstack(memory)])


def without(arrays: Arrays, row: int) -> Arrays:
    """The arrays without one row; those behind it move up."""
    *columns, memory = arrays
    kept = [np.delete(column, row, axis=0) for column in columns]
    return Arrays._make([*kept, np.delete(memory, row, axis=1)])
