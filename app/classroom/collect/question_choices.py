"""What a teacher may ask: the parameters and the measures of a scene, and questions ready-made."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.models.slider_range import is_wide
from agents.observables.catalogue import OBSERVABLES
from agents.observables.observable import Range
from agents.spec import CompleteSpec
from app.classroom.collect.question import Question, question_of
from app.classroom.collect.run_cost import look_radius
from app.studies.run_axes import (
    AGENTS,
    AxisModels,
    RunAxis,
    axis_parameter,
    axis_unit,
    is_whole_axis,
    number_parameters,
    numeric_axes,
    read_axis,
    value_of,
)
from app.viewer.gallery.scene_steps import SceneStep
from app.viewer.lab.sweeps.sweep_request import allowed, axis_symbol, axis_title, proposed_span
from app.viewer.measuring.observable_format import observable_words
from worlds.input_error import InputError

How = Literal["final", "over", "until"]
"""At the end of a run, over ticks at its end, or how long until a condition holds."""
SUGGESTED = 11
"""Values of a parameter."""


@dataclass(frozen=True)
class ParameterChoice:
    """A parameter that a question may be about."""

    name: str
    title: str
    symbol: str
    """As text."""
    unit: str
    """1 for a pure number."""
    low: float
    high: float
    whole: bool
    """Whether it has whole numbers only."""
    now: float
    """Its value in the scene."""
    suggested: tuple[float, ...]
    """Values over the range where something is to be seen."""


@dataclass(frozen=True)
class MeasureChoice:
    """An observable that may be measured."""

    name: str
    title: str
    """Its name in words."""
    description: str
    unit: str
    low: float | None
    """None where there is no least value that goes for any flock."""
    high: float | None
    how: tuple[How, ...]


def parameters_of(spec: CompleteSpec) -> tuple[ParameterChoice, ...]:
    """The parameters of a scene's run that a question may be about, then `agents`, then the numbers
    of its kinds."""
    return tuple(chosen(spec, axis) for axis in numeric_axes(spec) if has_number(spec, axis))


def has_number(spec: CompleteSpec, axis: RunAxis) -> bool:
    """Whether a run has a number along an axis: a relation may leave a radius to the rule."""
    try:
        return isinstance(value_of(spec, axis.name), int | float)
    except InputError:
        return False


def chosen(spec: CompleteSpec, axis: RunAxis) -> ParameterChoice:
    """What a question may be about, as a form has it."""
    model = AxisModels.of_run(spec).of_axis(axis.name)
    low, high = allowed(model, axis.name)
    one, whole = axis_parameter(model, axis.name), is_whole_axis(model, axis.name)
    if axis.name == AGENTS:
        around = max(10.0, spec.agents / 4), min(high, 4.0 * spec.agents)
        suggested = spread(*around, count=5, whole=True, log=True)
    else:
        least, most = proposed_span(spec, axis, look_radius(spec))
        suggested = spread(least, most, SUGGESTED, whole, is_wide(least, most))
    symbol = axis_symbol(model, axis.name)
    words = "Agents" if one is None else one.words
    title = axis_title(model, axis.name, words).partition(",")[0]
    unit, now = axis_unit(model, axis.name), float(value_of(spec, axis.name))
    return ParameterChoice(axis.name, title, symbol, unit, low, high, whole, now, suggested)


def spread(
    low: float, high: float, count: int, whole: bool = False, log: bool = False
) -> tuple[float, ...]:
    """So many values from low to high, in few figures; fewer where whole numbers are rare.

    >>> spread(0.0, 1.0, 5), spread(1, 100, 3, True, True)
    ((0.0, 0.25, 0.5, 0.75, 1.0), (1.0, 10.0, 100.0))
    """
    made = (np.geomspace if log else np.linspace)(low, high, count).tolist()
    figures = [float(round(one)) if whole else float(f"{one:.4g}") for one in made]
    return tuple(sorted({min(max(one, low), high) for one in figures}))


def measures_of(spec: CompleteSpec) -> tuple[MeasureChoice, ...]:
    """What may be measured of a scene's run, what tells most of its model first."""
    flock, model = Flock(spec), MODELS[spec.model]
    there = [one for one in OBSERVABLES.values() if isinstance(one.range, Range)]
    offered = [one for one in there if one.applies(flock)]
    first = [*model.tells, *(one.name for one in offered)]
    offered.sort(key=lambda one: first.index(one.name))
    made = []
    for one in offered:
        assert isinstance(one.range, Range)
        how: tuple[How, ...] = ("final", "over", "until") if one.over is None else ("over",)
        ends = one.range.low, one.range.high
        low, high = (end if math.isfinite(end) else None for end in ends)
        unit = model.in_units(one.unit)
        made.append(
            MeasureChoice(one.name, observable_words(one.name), one.title, unit, low, high, how)
        )
    return tuple(made)


@dataclass(frozen=True)
class PreparedQuestion:
    """A question that is ready for a scene."""

    name: str
    lesson: str
    """What it is for, in a sentence."""
    question: Question


PAPERS = 0.9984
"""Consistency that Liu et al. 2021 wait for, without noise; it holds for 60 ticks."""
WITH_NOISE = 0.99


OF_STEPS = "steps"
"""The name of the question that the steps of a scene ask which is no lesson of ours."""


def order_against_noise(spec: CompleteSpec) -> tuple[str, dict[str, Any]] | None:
    """How order is lost, for a model whose noise turns headings."""
    noise = next(
        (
            one
            for one in number_parameters(spec.model)
            if one.noise and one.name in ("eta", "sigma")
        ),
        None,
    )
    if noise is None:
        return None
    values = chosen(spec, read_axis(noise.name)).suggested
    return "Each noise makes its own order: together they show where order is lost", {
        "title": "Order against noise",
        "parameter": noise.name,
        "measure": {"observe": "polarisation", "over": 100},
        "ticks": 500,
        "values": list(values),
    }


def until_all_agree(spec: CompleteSpec) -> dict[str, Any] | None:
    """Measure and ticks of a question after how long a flock that is led takes to agree."""
    model = MODELS[spec.model]
    if not model.rule.converges or "p2" not in model.parameters.model_fields:
        return None
    bound = WITH_NOISE if spec.parameters.get("eta", 0.0) else PAPERS
    return {
        "parameter": "p2",
        "measure": {"until": f"consistency >= {bound:g}", "hold": 60},
        "ticks": 2000,
    }


def who_leads(spec: CompleteSpec) -> tuple[str, dict[str, Any]] | None:
    """How fast word of the one who knows spreads with the weight from layer to layer."""
    asked = until_all_agree(spec)
    if asked is None:
        return None
    return (
        "One agent knows the way: how much does it help to listen to those nearer to it?",
        asked
        | {
            "title": "Who leads? Ticks until all agree against p2",
            "values": [1.0, 1.25, 1.5, 2.0, 3.0, 5.0, 10.0, 50.0],
        },
    )


def field_of_view(spec: CompleteSpec) -> tuple[str, dict[str, Any]] | None:
    """What becomes of a flock whose agents see less of the others: of its ring, or of its order."""
    rule = MODELS[spec.model].rule
    view = rule.view or "fov"
    one = next((one for one in number_parameters(spec.model) if one.name == view), None)
    if one is None:
        return None
    asked = {"parameter": view, "ticks": 1000}
    if rule.view:
        return "How much of the others must each see for a school to go round in a ring?", asked | {
            "title": "Ring against the field of view",
            "measure": {"observe": "angular-momentum", "over": 100},
            "values": [60.0, 120.0, 180.0, 210.0, 240.0, 270.0, 300.0, 360.0],
        }
    return "How much of the others must each see for the flock to fly as one?", asked | {
        "title": "Order against the field of view",
        "measure": {"observe": "polarisation", "over": 100},
        "values": list(spread(max(one.low or 0.0, 60.0), 360.0, 7)),
    }


def beat_the_paper(spec: CompleteSpec) -> tuple[str, dict[str, Any]] | None:
    """Students look for the weights with which their flock agrees soonest."""
    asked = until_all_agree(spec)
    if asked is None:
        return None
    return (
        "Choose p1 and p2 so that all agree sooner than with the paper's 0.1 and 5; hand in as "
        "often as you like",
        asked
        | {"title": "Find the weights that beat the paper's", "free": ["p1"], "counts": "all"},
    )


MAKERS: dict[str, Callable[[CompleteSpec], tuple[str, dict[str, Any]] | None]] = {
    "order-against-noise": order_against_noise,
    "who-leads": who_leads,
    "field-of-view": field_of_view,
    "beat-the-paper": beat_the_paper,
}


def of_steps(spec: CompleteSpec, steps: Sequence[SceneStep]) -> tuple[str, dict[str, Any]] | None:
    """What the steps of a scene ask about their first slider: all of its range, by the class."""
    step = next((step for step in steps if step.ask and step.controls), None)
    if step is None:
        return None
    known = {one.name: one for one in number_parameters(spec.model)}
    parameter = known.get(step.controls[0])
    if parameter is None:
        return None
    measure = observable_words(step.measure)
    return f"{step.ask} The class takes all of the range", {
        "title": f"{measure.capitalize()} against {parameter.words.lower()}",
        "parameter": parameter.name,
        "measure": {"observe": step.measure, "over": step.ticks - step.first_measured_tick + 1},
        "ticks": step.ticks,
        "values": list(chosen(spec, read_axis(parameter.name)).suggested),
    }


def ready_for(
    spec: CompleteSpec, first: str = "", steps: Sequence[SceneStep] = ()
) -> tuple[PreparedQuestion, ...]:
    """The questions that are ready for a scene: those whose parameter its model has.

    The one called `first` stands first, which is what its `steps` ask if it is called for no other;
    one that its flock is too large for is not among them.
    """
    made: list[PreparedQuestion] = []
    makers = dict(MAKERS)
    if steps and first not in MAKERS:
        first = first or OF_STEPS
        makers[first] = partial(of_steps, steps=steps)
    for name, maker in sorted(makers.items(), key=lambda one: one[0] != first):
        found = maker(spec)
        if found is None:
            continue
        lesson, values = found
        try:
            made.append(PreparedQuestion(name, lesson, question_of(values, spec, values["title"])))
        except InputError:
            continue
    return tuple(made)
