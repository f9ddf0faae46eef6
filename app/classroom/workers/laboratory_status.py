"""What a class sees of one laboratory from afar: two numbers and a small picture."""

from __future__ import annotations

import base64
from dataclasses import dataclass

import numpy as np

from agents.catalogue import MODELS
from agents.models.model import Model
from app.viewer.lab.laboratory import Laboratory
from app.viewer.measuring.observable_format import QUICK, STEADY, observable_words
from app.viewer.scene.shown.frame import Frame

MOST = 400
"""Agents of a small picture: of more, so many that are spread over the rows."""
STEPS = 255
"""Places along a side of the small picture."""


@dataclass(frozen=True)
class LaboratoryStatus:
    """How a laboratory stands, ready to be written as JSON."""

    model: str
    """Its title."""
    tick: int
    agents: int
    running: bool
    compiling: bool
    browsers: int
    numbers: tuple[tuple[str, float], ...] = ()
    """At most two: title and value."""
    shape: float = 1.0
    """Width of the small picture over its height."""
    dots: str = ""
    """Of each agent three bytes in base 64: how far to the right, how far up, of `STEPS`, and its
    heading, of 256 from the x axis to the left."""
    error: str = ""
    lesson: str = ""
    """Which lesson its scene is, by `lesson_key`; empty: none."""
    turn: int = 0
    """In which turn of the class's lessons, as it was told."""
    predictions: tuple[tuple[int, int, int | None], ...] = ()
    """Of each step in which a prediction stays: its number, and the places of the choice and of
    that which the run showed."""


def laboratory_status(laboratory: Laboratory) -> LaboratoryStatus:
    """How a laboratory stands now."""
    simulation = laboratory.simulation
    state, frame, readings = simulation.state, simulation.frame, simulation.readings
    model = MODELS[state.spec.model]
    lesson, turn, predictions = laboratory.lesson.predictions()
    shape, dots = (1.0, "") if frame is None else small_picture(frame)
    return LaboratoryStatus(
        model.title,
        0 if frame is None else frame.tick,
        state.agents,
        state.running,
        state.compiling is not None,
        laboratory.browsers(),
        two_numbers(model, {} if readings is None else readings.values),
        shape,
        dots,
        state.error,
        lesson,
        turn,
        predictions,
    )


def two_numbers(model: Model, values: dict[str, float]) -> tuple[tuple[str, float], ...]:
    """At most two of what has been measured, what tells most of a model first: words and value."""
    names = dict.fromkeys((*model.tells, *QUICK, *STEADY))
    found = [(observable_words(name), values[name]) for name in names if name in values]
    return tuple(one for one in found if np.isfinite(one[1]))[:2]


def small_picture(frame: Frame) -> tuple[float, str]:
    """Width over height, and the dots; from above, where the world has three dimensions."""
    rows = np.arange(len(frame.ids))[:: max(1, -(-len(frame.ids) // MOST))]
    position = frame.position[rows][:, :2]
    low, size = frame.low[:2], frame.size[:2]
    if not frame.wraps[:2].all() and len(position):  # the flock may have left an open world
        high = np.maximum(low + size, np.nanmax(position, axis=0, initial=-np.inf))
        low = np.minimum(low, np.nanmin(position, axis=0, initial=np.inf))
        size = high - low
    place = np.nan_to_num((position - low) / np.maximum(size, 1e-9))
    heading = frame.heading[rows]
    angle = np.arctan2(heading[:, 1], heading[:, 0]) / (2.0 * np.pi)
    told = np.column_stack(
        [np.clip(np.rint(place * STEPS), 0, STEPS), np.floor(np.nan_to_num(angle) * 256.0) % 256]
    )
    dots = base64.b64encode(told.astype(np.uint8).tobytes()).decode()
    return float(size[0] / max(size[1], 1e-9)), dots
