"""Head where the others head: the mean cosine with the headings of all within reach."""

from __future__ import annotations

import numpy as np

from app.learning.reward import Reward, StepResult


def compute(result: StepResult) -> np.ndarray:
    """Mean cosine with those within the flock's reach, 0 for who has nobody there, (S,)."""
    flock, others = result.flock, result.others
    is_near = result.distances(others) <= flock.reach
    own = flock.heading[np.maximum(result.rows, 0)]
    cosine = own @ flock.heading[others].T
    count = is_near.sum(axis=1)
    return np.where(count > 0, (cosine * is_near).sum(axis=1) / np.maximum(count, 1), 0.0)


REWARD = Reward("align", "Head where those within reach head: the mean cosine.", compute)
