"""Stay alive: 1 for each tick, and -10 for being caught or for a crash."""

from __future__ import annotations

import numpy as np

from app.learning.reward import Reward, StepResult

LOST = -10.0


def compute(result: StepResult) -> np.ndarray:
    """1, or LOST for whom it is over, (S,)."""
    return np.where(result.is_over, LOST, 1.0)


REWARD = Reward("evade", "Stay alive: 1 a tick, -10 for being caught or crashing.", compute)
