"""What students predict in the steps of a lesson, and what their own runs showed."""

from __future__ import annotations

import csv
import io
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from app.studies.sweeps.sweep_table import as_csv
from app.viewer.gallery.scene_steps import SceneStep
from worlds.file_writer import unguard_cell
from worlds.input_error import InputError, shorten, unknown

HEADS = ("student", "step", "predicted", "shown")
"""The columns of the table of predictions."""


@dataclass(frozen=True)
class LessonPrediction:
    """What a student has predicted in a step, by the places of the step's choices, from 0."""

    choice: int
    shown: int | None = None
    """What their run of the step showed; None: no run has come to its end."""


Predictions = Mapping[int, LessonPrediction]
"""Of one student, by the number of the step, from 1."""


def demand_prediction(step: SceneStep, number: int, prediction: LessonPrediction) -> None:
    """Raise InputError for a step that asks nothing, or a choice that it does not have."""
    if not step.ask:
        raise InputError(f"step = {number} is not allowed: nothing is predicted in it")
    most = len(step.choices) - 1
    for name, place in (("choice", prediction.choice), ("shown", prediction.shown)):
        if place is not None and not 0 <= place <= most:
            raise InputError(f"{name} = {place} is not allowed: 0 to {most} (step {number})")


def merge_prediction(
    step: SceneStep,
    number: int,
    prediction: LessonPrediction,
    known: LessonPrediction | None,
    shown_step: int,
) -> LessonPrediction:
    """A student's prediction of a step once another is made. Raises InputError.

    The first choice stays; a run that is made again may show another one. `shown_step`: the step
    that the teacher shows to all, beyond which nobody predicts; 0: none.
    """
    demand_prediction(step, number, prediction)
    if shown_step and number > shown_step:
        raise InputError(f"step = {number} is not allowed: the class is at step {shown_step}")
    if known is None:
        return prediction
    if known.choice != prediction.choice:
        raise InputError(f"your prediction of step {number} is made: it stays")
    return known if prediction.shown is None else prediction


def count_choices(
    steps: Sequence[SceneStep], students: Collection[Predictions]
) -> list[dict[str, Any]]:
    """Of each step what it says and asks, and by choice how many predict it, and of how many the
    run showed it."""
    counted = []
    for number, step in enumerate(steps, 1):
        made = [one[number] for one in students if number in one]
        places = range(len(step.choices))
        counted.append(
            {
                "say": step.say,
                "ask": step.ask,
                "choices": step.choices,
                "predicted": [sum(one.choice == place for one in made) for place in places],
                "shown": [sum(one.shown == place for one in made) for place in places],
            }
        )
    return counted


def prediction_columns(
    steps: Sequence[SceneStep], students: Sequence[Predictions]
) -> dict[str, list[str | None]]:
    """Two columns for each step that asks, with a row for each of `students`: the choice that was
    predicted, and the one that the run showed; None where there is none."""
    columns: dict[str, list[str | None]] = {}
    for number, step in enumerate(steps, 1):
        if not step.ask:
            continue
        made = [one.get(number) for one in students]
        for name, places in (
            ("predicted", [None if one is None else one.choice for one in made]),
            ("shown", [None if one is None else one.shown for one in made]),
        ):
            columns[f"step {number} {name}"] = [
                None if place is None else step.choices[place] for place in places
            ]
    return columns


def predictions_to_csv(steps: Sequence[SceneStep], students: Mapping[str, Predictions]) -> str:
    """A row for each prediction of each student, by name, with the choices in words."""
    rows = [
        (name, number, steps[number - 1], one)
        for name, predictions in students.items()
        for number, one in sorted(predictions.items())
    ]
    columns: list[list[Any]] = [
        [name for name, *_ in rows],
        [number for _, number, *_ in rows],
        [step.choices[one.choice] for *_, step, one in rows],
        [None if one.shown is None else step.choices[one.shown] for *_, step, one in rows],
    ]
    return as_csv(dict(zip(HEADS, columns, strict=True)))


def predictions_from_csv(
    text: str, steps: Sequence[SceneStep], names: Collection[str], origin: str
) -> dict[str, dict[int, LessonPrediction]]:
    """What `predictions_to_csv` wrote, for students of these names. Raises InputError."""
    try:
        rows = list(csv.reader(io.StringIO(text, newline=""), strict=True))
    except csv.Error as error:
        raise InputError(f"{origin} is no CSV: {error}") from None
    if not rows or tuple(rows[0]) != HEADS:
        raise InputError(f"{origin} has not the columns {', '.join(HEADS)}")
    most = len(names) * len(steps)
    if len(rows) - 1 > most:
        raise InputError(f"{origin} has {len(rows) - 1:,} rows: at most {most:,}")
    made: dict[str, dict[int, LessonPrediction]] = {}
    for place, row in enumerate(rows[1:], 1):
        at = f"{origin}, row {place}"
        if len(row) != len(HEADS):
            raise InputError(f"{at} is not as its columns")
        name, number, predicted, shown = map(unguard_cell, row)
        if name not in names:
            raise InputError(f"student = {shorten(name)} is not in the class ({at})")
        asked = {str(k): step for k, step in enumerate(steps, 1) if step.ask}
        if number not in asked:
            raise unknown("step", number, list(asked), at)
        choices = asked[number].choices
        for choice in (predicted, shown) if shown else (predicted,):
            if choice not in choices:
                raise unknown("choice", choice, choices, at)
        own = made.setdefault(name, {})
        if int(number) in own:
            raise InputError(f"step {number} of {name} is there twice ({at})")
        result = choices.index(shown) if shown else None
        own[int(number)] = LessonPrediction(choices.index(predicted), result)
    return made
