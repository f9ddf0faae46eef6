"""Who has crashed: when, where, and against what."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from agents.engine.arrays import Arrays

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
