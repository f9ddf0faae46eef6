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
        unhurt(n if model.body.touches else 0, start.position.shape[1]),
    )


def unhurt(n: int, dim: int) -> np.ndarray:
    """The fate (n, 2 + dim) of agents that have not crashed."""
    return np.full((n, 2 + dim), -1.0)


def joined(arrays: Arrays, more: Arrays) -> Arrays:
    """The rows of both; agents are the last axis of the memory and the first of all else."""
    both = {
        name: np.concatenate(pair, axis=int(name == "memory"))
        for name, *pair in zip(Arrays._fields, arrays, more, strict=True)
    }
    return Arrays(**both)


def without(arrays: Arrays, row: int) -> Arrays:
    """The arrays without one row; those behind it move up."""
    there = [row] if len(arrays.fate) else []
    kept = {
        name: np.delete(column, row, axis=int(name == "memory"))
        for name, column in arrays._asdict().items()
        if name != "fate"
    }
    return Arrays(**kept, fate=np.delete(arrays.fate, there, axis=0))
