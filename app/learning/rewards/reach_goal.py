"""Go to the goal: the way towards it in a tick, over the reach."""

from __future__ import annotations

import numpy as np

from app.learning.reward import Reward, StepResult


def compute(result: StepResult) -> np.ndarray:
    """How much nearer the goal one came in the tick, over the reach; 0 for who is gone, (S,)."""
    flock = result.flock
    goal = flock.goal_at(np.array([flock.tick]))[0]
    rows = np.maximum(result.rows, 0)
    away = goal - flock.position[rows]
    distance = np.linalg.norm(away, axis=1)
    towards = (away * flock.heading[rows]).sum(axis=1) / np.where(distance > 0.0, distance, 1.0)
    return np.where(result.rows >= 0, towards * flock.speed[rows] / flock.reach, 0.0)


REWARD = Reward("reach-goal", "Go to the goal of the world: the way towards it.", compute)
