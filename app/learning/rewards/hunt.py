"""Catch: 10 for each agent that one catches, and -0.01 for each tick."""

from __future__ import annotations

import numpy as np

from app.learning.reward import Reward, StepResult

CAUGHT, WAITED = 10.0, -0.01


def compute(result: StepResult) -> np.ndarray:
    """CAUGHT for each catch of the tick that has just ended, (S,)."""
    catches = result.flock.catches
    is_new = catches.tick == result.flock.tick
    catchers = catches.gate[is_new]
    return WAITED + CAUGHT * (catchers[None] == result.ids[:, None]).sum(axis=1)


REWARD = Reward("hunt", "Catch others: 10 for each, -0.01 a tick.", compute)
