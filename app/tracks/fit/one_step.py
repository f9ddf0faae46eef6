"""One tick of a model's own rule from frames of tracks, and how far its headings are off.

Each frame is written into a flock, noise off, which runs one tick; a flock is kept for each number
of individuals, so that nothing is built again. The error of an individual is the angle between the
heading that the rule takes and the one that it was seen with, 0.5 rad at most: one individual that
turns round for no reason of the model must not outweigh all others.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import Any

import numpy as np

from agents.flock import Flock
from agents.spec import Spec
from app.tracks.fit.frame_sample import FrameSample
from app.tracks.fit.tick_scale import ScaledModel
from worlds.world import World

MOST_ANGLE = 0.5
"""rad: an error counts as this much at most."""


def angle_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The angle between unit vectors (..., dim), rad in [0, pi]; exact for small ones too."""
    chord = np.sqrt(((a - b) ** 2).sum(axis=-1))
    return 2.0 * np.arcsin(np.minimum(0.5 * chord, 1.0))


def frame_costs(
    sample: FrameSample, predicted: np.ndarray, most_angle: float = MOST_ANGLE
) -> np.ndarray:
    """The mean of min(angle, 0.5)^2 of each frame, (F,), rad^2; predicted is (F, N, dim)."""
    angle = np.minimum(angle_between(predicted, sample.following), most_angle)
    return np.nanmean(np.where(sample.judged, angle * angle, np.nan), axis=1)


def costs_of_kept_headings(sample: FrameSample, most_angle: float = MOST_ANGLE) -> np.ndarray:
    """The costs (F,) of the rule that everybody keeps its heading: what a model has to beat."""
    return frame_costs(sample, sample.heading, most_angle)


class OneStepPredictor(threading.local):
    """Predictions of one model in the world of the tracks; each thread has flocks of its own."""

    def __init__(self, scaled: ScaledModel, world: World, most_angle: float = MOST_ANGLE):
        self.scaled, self.world, self.most_angle = scaled, world, most_angle
        self.flocks: dict[int, Flock] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        # Another process begins its own flocks.
        return OneStepPredictor, (self.scaled, self.world, self.most_angle)

    def flock(self, individuals: int) -> Flock:
        """The flock of so many individuals, wherever they are."""
        if individuals not in self.flocks:
            spec = Spec(
                self.scaled.name,
                agents=individuals,
                informed=0,
                world=self.world,
                spacing=0.0,
                seed=0,
                parameters=self.scaled.fixed,
            )
            self.flocks[individuals] = Flock(spec)
        return self.flocks[individuals]

    def predict(self, sample: FrameSample, parameters: Mapping[str, Any]) -> np.ndarray:
        """Headings (F, N, dim) a tick later, NaN for who is not there. Raises InputError."""
        predicted = np.full(sample.heading.shape, np.nan)
        prepared: set[int] = set()
        for k, present in enumerate(sample.present):
            rows = np.flatnonzero(present)
            flock = self.flock(len(rows))
            if len(rows) not in prepared:
                flock.set(**{**self.scaled.fixed, **parameters})
                prepared.add(len(rows))
            self.write(flock, sample, k, rows)
            # The engine itself: a flock's own clock takes as long as the tick of 60 agents.
            flock.engine.run(flock.context, 0, 1)
            predicted[k, rows] = flock.arrays.heading
        return predicted

    def write(self, flock: Flock, sample: FrameSample, k: int, rows: np.ndarray) -> None:
        """Put the individuals of a frame into a flock, as if its run began with them."""
        arrays, speed = flock.arrays, flock.model.body.speed
        arrays.position[:] = sample.position[k, rows]
        arrays.heading[:] = sample.heading[k, rows]
        if speed is None:
            arrays.speed[:] = sample.speed[k, rows] * self.scaled.time_unit
        else:
            arrays.speed[:] = speed(flock.parameters)
        if len(arrays.memory):
            arrays.memory[:] = flock.model.initial_columns[:, None]
        arrays.crash_record[:] = -1.0
        arrays.leg[:] = 0

    def costs(self, sample: FrameSample, parameters: Mapping[str, Any]) -> np.ndarray:
        """The cost of each frame, (F,), rad^2."""
        return frame_costs(sample, self.predict(sample, parameters), self.most_angle)
