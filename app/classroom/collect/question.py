"""A question to a class: how a measure of a run goes with one parameter of it."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import tomlkit
from pydantic import ConfigDict, Field, PrivateAttr, ValidationError, model_validator

from agents.catalogue import FILES, MODELS
from agents.engine.heeding import MOST_KINDS
from agents.flock import Flock
from agents.kinds import kind_table
from agents.models.declare import DeclaredParameter
from agents.observables.catalogue import OBSERVABLES
from agents.spec import CompleteSpec, Spec
from app.classroom.collect.run_cost import MOST_TICKS, demand_cheap
from app.strict_table import StrictTable
from app.studies.run_axes import (
    AxisModels,
    axis_parameter,
    axis_unit,
    is_whole_axis,
    read_axis,
    spec_with,
    value_of,
)
from app.studies.sweeps.sweep_file import ObservableBound, Observe, comparison
from app.studies.sweeps.sweep_job import StopCondition, SweepJob, demand_number, measure_of
from app.viewer.lab.sweeps.sweep_request import allowed, axis_symbol, axis_title
from app.viewer.measuring.observable_format import observable_words as in_words
from app.viewer.run.played_kind import with_kinds_apart
from worlds.input_error import InputError, first_input_error, shorten, unknown
from worlds.text_file import toml

MOST_VALUES = 50
"""That are given to students in turn."""
MOST_FREE = 5
"""Parameters beside the one in question."""
MOST_LETTERS = 80
"""Of a title."""
Whole = Annotated[int, Field(ge=1, le=MOST_TICKS)]


class RunMeasure(StrictTable):
    """What is measured of a run: an observable, or the ticks until a condition holds."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)

    observe: str = Field(default="", max_length=100)
    """An observable, at the end of the run, or"""
    over: Whole | None = None
    """its mean over so many ticks at the end."""
    until: str = Field(default="", max_length=100)
    """A condition, such as `consistency >= 0.9984`; measured is the tick from which it held"""
    hold: Whole = 1
    """for so many ticks."""

    @model_validator(mode="after")
    def _is_one(self) -> RunMeasure:
        if bool(self.observe) == bool(self.until):
            raise ValueError("either observe or until is needed")
        if self.until and self.over is not None:
            raise ValueError("over is of what is observed, not of until")
        if self.observe and self.hold != 1:
            raise ValueError("hold is of until, not of what is observed")
        return self

    @property
    def condition(self) -> ObservableBound | None:
        """What has to hold. Raises InputError."""
        return comparison(self.until) if self.until else None

    @property
    def observable(self) -> str:
        """The observable that is looked at. Raises InputError."""
        return self.observe if self.condition is None else self.condition.name


class Question(StrictTable):
    """What a class is asked; `question_of` makes one that is checked for a scene.

    A run is made for `ticks`. `values` are given to students in turn; without any they choose.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)

    title: str = Field(min_length=1, max_length=MOST_LETTERS)
    model: str
    """Of the class's scene."""
    parameter: str
    """Of that model, `agents`, or a number of a kind: an axis, as `app.studies.run_axes` has
    them."""
    measure: RunMeasure
    ticks: Whole
    values: list[float] = Field(default_factory=list, max_length=MOST_VALUES)
    """Rising; empty: students choose."""
    free: list[str] = Field(default_factory=list, max_length=MOST_FREE)
    """Parameters that students may change too; a run that differs by others is in no mean."""
    kinds: list[str] = Field(default_factory=list, max_length=MOST_KINDS + 1)
    """Kinds of the scene that students play in turn, each with the sliders of theirs alone; empty:
    all have all sliders."""
    counts: Literal["last", "all"] = "last"
    """Of what a student hands in several times: the last result, or all."""
    _kind_models: dict[str, str] = PrivateAttr(default_factory=dict)
    """Of each kind of the scene with a model of its own; `question_of` finds them."""

    def model_of(self, name: str) -> str:
        """The model of the agents that an axis is about."""
        return AxisModels(self.model, self._kind_models).of_axis(name)

    @property
    def making(self) -> SweepJob:
        """How the sweep engine makes and measures a run of it. Raises InputError."""
        one, until = self.measure, None
        if one.condition is not None:
            until = StopCondition(one.condition, one.hold, 1)
            return SweepJob(self.ticks, (), until)
        return SweepJob(self.ticks, (measure_of(Observe(name=one.observe, over=one.over), Path()),))

    @property
    def column(self) -> str:
        """What the result is called in a table, there and in that of a sweep."""
        return self.making.columns[0]

    @property
    def declared(self) -> DeclaredParameter | None:
        """The parameter as its model declares it; None for agents and numbers of a relation."""
        return axis_parameter(self.model_of(self.parameter), self.parameter)

    @property
    def parameter_words(self) -> str:
        """What is varied, for people."""
        words = "agents" if self.declared is None else self.declared.words
        return axis_title(self.model_of(self.parameter), self.parameter, words).partition(",")[0]

    @property
    def symbol(self) -> str:
        """Of what is varied, as text."""
        return axis_symbol(self.model_of(self.parameter), self.parameter)

    @property
    def unit(self) -> str:
        """Of the parameter; 1 for a pure number."""
        return self.unit_of(self.parameter)

    @property
    def result_unit(self) -> str:
        """Of the result; 1 for a pure number."""
        if self.measure.until:
            return "ticks"
        return MODELS[self.model].in_units(OBSERVABLES[self.measure.observe].unit)

    @property
    def result_words(self) -> str:
        """What is measured, for people."""
        one = self.measure
        if one.until:
            return f"ticks until {self.condition_words}"
        if OBSERVABLES[one.observe].over is not None or one.over is not None:
            return f"{in_words(one.observe)} over the last {one.over} ticks"
        return f"{in_words(one.observe)} after {self.ticks} ticks"

    @property
    def condition_words(self) -> str:
        """What has to hold, for people; nothing where nothing has to."""
        condition = self.measure.condition
        if condition is None:
            return ""
        held = f" for {self.measure.hold} ticks" if self.measure.hold > 1 else ""
        return f"{in_words(condition.name)} {condition.sign} {condition.bound:g}{held}"

    @property
    def is_whole(self) -> bool:
        """Whether the parameter has whole numbers only."""
        return is_whole_axis(self.model_of(self.parameter), self.parameter)

    @property
    def open(self) -> tuple[str, ...]:
        """What may be other than in the class's scene."""
        return (self.parameter, *self.free)

    def value_of(self, spec: CompleteSpec, name: str = "") -> float:
        """The value of the parameter in a run, or of a free one. Raises InputError without it, or
        where agents differ in it."""
        name = name or self.parameter
        model = self.model_of(name)
        axis = read_axis(name, model)
        is_own = axis_parameter(model, name) is not None
        theirs = AxisModels.of_run(spec).of_axis(name)
        if is_own and axis_parameter(theirs, name) is None:
            raise InputError(
                f"{name} is what the class is asked about, and {theirs} has no such parameter: "
                f"take {model}"
            )
        value = value_of(spec, name)
        if isinstance(value, str):
            raise InputError(
                f"{name} is what the class is asked about, and here agents differ in it "
                f"({axis.name} = {value}): give all the same"
            )
        return float(value)

    def unit_of(self, name: str) -> str:
        """The unit of a parameter by name; 1 for a pure number."""
        return axis_unit(self.model_of(name), name)

    def value_text(self, value: float) -> str:
        """A value of the parameter with its unit, for people."""
        return f"{value:g}" if self.unit == "1" else f"{value:g} {self.unit}"

    @property
    def moves_kinds(self) -> bool:
        """Whether students move numbers of kinds, for which they need sliders."""
        chosen = [*self.free, *([] if self.values else [self.parameter])]
        axes = (read_axis(name, self.model_of(name)) for name in chosen)
        return bool(self.kinds) or any(axis.kind or axis.moment for axis in axes)

    def begun_scene(self, scene: CompleteSpec) -> CompleteSpec:
        """The run that all begin with: where students play kinds, each has its own numbers.

        Raises InputError.
        """
        return complete(with_kinds_apart(scene)) if self.kinds else scene

    def with_value(self, spec: CompleteSpec, value: float) -> CompleteSpec:
        """A run with another value of the parameter. Raises InputError."""
        number: float = round(value) if self.is_whole else value
        return with_axes(spec, {self.parameter: number})

    def demand_cheap(self, spec: CompleteSpec) -> None:
        """Refuse a run that would take too long for one of a class. Raises InputError."""
        one = self.measure
        looks = self.ticks if one.until else one.over or 1
        demand_cheap(spec, self.ticks, one.observable, looks)

    def to_values(self) -> dict[str, Any]:
        """The question as JSON and TOML have it."""
        return self.model_dump(exclude_defaults=True)

    def to_toml(self) -> str:
        """The question as a file."""
        return tomlkit.dumps(self.to_values())


def with_axes(spec: CompleteSpec, values: Mapping[str, Any]) -> CompleteSpec:
    """A run with other values of axes. Raises InputError."""
    return complete(spec_with(spec, values))


def complete(spec: Spec) -> CompleteSpec:
    """A complete run of which nothing was opened."""
    assert isinstance(spec, CompleteSpec)
    return spec


def question_of(values: object, scene: CompleteSpec, origin: str = "the question") -> Question:
    """A question from a browser or a file, checked for the class's scene. Raises InputError.

    `model` is that of the scene, whether it is given or not.
    """
    if not isinstance(values, Mapping):
        raise InputError(f"{origin} = {shorten(values)} is not a table")
    if scene.model in FILES:
        raise InputError(f"{scene.model} is a model of a file: a class has those of the catalogue")
    given = {"model": scene.model, **values}
    if given["model"] != scene.model:
        raise InputError(
            f"model = {shorten(given['model'])} is not that of the scene: {scene.model} is"
            f" ({origin})"
        )
    try:
        made = Question(**given)
    except ValidationError as error:
        raise first_input_error(error, origin) from None
    except TypeError:  # keys that are no words
        raise InputError(f"{origin} has keys that are no names") from None
    try:
        return fitted(made, scene)
    except InputError as refusal:
        told = str(refusal)
        raise InputError(told if origin in told else f"{told} ({origin})") from None


def question_from_toml(text: str, scene: CompleteSpec, origin: str) -> Question:
    """A question from a file. Raises InputError."""
    return question_of(toml(text, origin), scene, origin)


def fitted(made: Question, scene: CompleteSpec) -> Question:
    """A question whose names, ranges and costs are those of a scene. Raises InputError."""
    title = clean_title(made.title)
    made._kind_models |= AxisModels.of_run(scene).kinds
    low, high = allowed(made.model_of(made.parameter), made.parameter)
    for value in made.values:
        if not low <= value <= high:
            raise InputError(f"values: {made.parameter} = {value:g} is not in [{low:g}, {high:g}]")
        if made.is_whole and value != math.floor(value):
            raise InputError(f"values: {made.parameter} = {value:g} is not a whole number")
    for name in made.free:
        allowed(made.model_of(name), name)
        if made.free.count(name) > 1 or name == made.parameter:
            raise InputError(f"free: {name} is there twice")
    demand_played(made, scene)
    values = sorted({float(value) for value in made.values})
    if len(values) == 1:
        raise InputError(f"values: one value of {made.parameter} shows nothing: give two or more")
    demand_measured(made, scene)
    checked = made.model_copy(update={"title": title, "values": values})
    for name in checked.open:
        checked.value_of(scene, name)
    for value in values or [checked.value_of(scene)]:
        checked.demand_cheap(checked.with_value(scene, value))
    return checked


def demand_played(made: Question, scene: CompleteSpec) -> None:
    """Refuse kinds to play that the scene has not, or that nobody can play. Raises InputError."""
    names = kind_table(scene.kinds, scene.to).names
    for name in made.kinds:
        if not scene.kinds:
            raise InputError(f"kinds: {name} cannot be played: the scene has no kinds of agents")
        if name not in names:
            raise InputError(f"kinds: {unknown('kind', name, names)}")
        if made.kinds.count(name) > 1:
            raise InputError(f"kinds: {name} is there twice")
    made.begun_scene(scene)


def clean_title(text: str) -> str:
    """A title on one line, without what cannot be printed. Raises InputError."""
    kept = "".join(one for one in text if one.isprintable() or one.isspace())
    title = re.sub(r"\s+", " ", kept).strip()
    if not title:
        raise InputError(f"title = {shorten(text)} has no letters")
    return title


def demand_measured(made: Question, scene: CompleteSpec) -> None:
    """Refuse what cannot be measured of a run of a scene. Raises InputError."""
    asked = made.measure
    name = asked.observable
    demand_number(name)
    one = OBSERVABLES[name]
    if asked.until and one.over is not None:
        raise InputError(f"{name} is measured over a run: no tick has it")
    if one.over is not None and (asked.over is None or asked.over < 2):
        raise InputError(f"{name} is measured over a run: over = 2 or more of its last ticks")
    if not one.applies(Flock(scene)):
        known = [key for key, other in OBSERVABLES.items() if other.applies(Flock(scene))]
        raise unknown("observable of this scene", name, known)
    for key, ticks in (("over", asked.over or 0), ("hold", asked.hold)):
        if ticks > made.ticks:
            raise InputError(f"{key} = {ticks} is more than ticks = {made.ticks}, those of a run")
    if asked.condition is not None and not math.isfinite(asked.condition.bound):
        raise InputError(f"until = {asked.until!r} needs a finite number")
    made.making.prepare()
