"""Steps of a scene that is a lesson: a sentence and a control each, and what the reader predicts.

A prediction is judged by the reader's own run: it goes for some ticks, and the mean of one
observable over the last half of them says which of the choices the run shows.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any

from pydantic import AfterValidator, ConfigDict, Field, ValidationError, model_validator

from agents.catalogue import model as find_model
from agents.models.declare import NumberParameter, checked, declared
from agents.observables.catalogue import OBSERVABLES
from app.strict_table import StrictTable
from worlds.input_error import InputError, demand_line, first_input_error, shorten, unknown

MOST_STEPS = 12
MOST_TICKS = 20_000
"""Of a step's run: at a thousand ticks a second a reader waits for 20 seconds."""
PREDICTION = ("choices", "measure", "ticks", "bounds")
"""What goes with `ask`: all of these, or none."""
ONE_LINE = AfterValidator(demand_line)


class SceneStep(StrictTable):
    """One step, as it stands in the file: `[[steps]]`.

    What it names (parameters, an observable) is checked by `read_steps`, which knows the model.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)

    say: Annotated[str, Field(min_length=1, max_length=240), ONE_LINE]
    """What to know, or what to do: one sentence."""
    control: str = ""
    """The parameter whose slider stands with the step; empty: none."""
    ask: Annotated[str, Field(max_length=200), ONE_LINE] = ""
    """What the reader predicts, a question; empty: nothing."""
    choices: list[Annotated[str, Field(min_length=1, max_length=60), ONE_LINE]] = Field(
        default=[], max_length=4
    )
    """Answers, in the order in which the measure grows."""
    measure: str = ""
    """The observable that the run is judged by."""
    ticks: int = Field(default=0, ge=0, le=MOST_TICKS)
    """How long the run is, from its start."""
    bounds: list[float] = Field(default=[])
    """Between one choice and the next, in the unit of the measure: a mean that is on a bound or
    above it shows the later choice."""
    set: dict[str, float] = Field(default={})
    """Parameters that the step's run begins with; the others are those of the scene."""

    @model_validator(mode="after")
    def _is_whole(self) -> SceneStep:
        if not self.ask:
            extra = [key for key in (*PREDICTION, "set") if getattr(self, key)]
            if extra:
                raise ValueError(f"{extra[0]} is given without ask: what does the reader predict?")
            return self
        missing = [key for key in PREDICTION if not getattr(self, key)]
        if missing:
            raise ValueError(f"{missing[0]} is missing: ask needs {', '.join(PREDICTION)}")
        if self.ticks < 2:
            raise ValueError(f"ticks = {self.ticks} is not allowed: at least 2")
        return self

    @model_validator(mode="after")
    def _parts_choices(self) -> SceneStep:
        if not self.ask:
            return self
        if not 2 <= len(set(self.choices)) == len(self.choices):
            raise ValueError(f"choices = {self.choices} is not allowed: 2 to 4 different answers")
        needed = len(self.choices) - 1
        if len(self.bounds) != needed:
            raise ValueError(
                f"bounds = {self.bounds} is not allowed: {len(self.choices)} choices need {needed}"
            )
        if any(low >= high for low, high in pairwise(self.bounds)):
            raise ValueError(f"bounds = {self.bounds} is not allowed: each is above the one before")
        return self

    @property
    def first_measured_tick(self) -> int:
        """The tick from which the measure counts: the first of the last half."""
        return self.ticks // 2 + 1

    def choice_of(self, mean: float) -> str:
        """The choice that a run shows, by the mean of its measure.

        >>> step = SceneStep(say="Look.", ask="?", choices=["less", "more"], measure="polarisation",
        ...                  ticks=10, bounds=[0.5])
        >>> step.choice_of(0.49), step.choice_of(0.5)
        ('less', 'more')
        """
        return self.choices[sum(mean >= bound for bound in self.bounds)]

    def describe(self) -> str:
        """The step in words, for who reads the lesson without its page."""
        words = self.say if not self.control else f"{self.say} [{self.control}]"
        if not self.ask:
            return words
        start = "".join(f", {name} = {value:g}" for name, value in self.set.items())
        return (
            f"{words} {self.ask} {' / '.join(self.choices)} ({self.ticks} ticks{start}: mean "
            f"{self.measure} of ticks {self.first_measured_tick} to {self.ticks}, "
            f"bounds {', '.join(f'{bound:g}' for bound in self.bounds)})"
        )

    def values(self) -> dict[str, Any]:
        """The step as its file and a page have it, without what it does not say."""
        return {key: value for key, value in self.model_dump().items() if value}


def read_steps(
    value: Any, model_name: str, run: Mapping[str, Any], origin: str
) -> tuple[SceneStep, ...]:
    """The steps of a scene of a model; `run`: the parameters of its run that it names.

    Raises InputError naming the step, the value and what is allowed.
    """
    if not isinstance(value, list) or len(value) > MOST_STEPS:
        raise InputError(
            f"steps = {shorten(value)} is no list of at most {MOST_STEPS} tables ({origin})"
        )
    steps = []
    for number, fields in enumerate(value, 1):
        place = f"step {number}, {origin}"
        try:
            step = SceneStep.model_validate(fields)
        except ValidationError as error:
            raise first_input_error(error, f"step {number}", origin) from None
        demand_control(step, model_name, place)
        demand_values(step, model_name, run, place)
        demand_measure(step, page_observables(), place)
        steps.append(step)
    return tuple(steps)


def demand_control(step: SceneStep, model_name: str, place: str) -> None:
    """Raise InputError for a control that is no slider of the model."""
    sliders = number_parameters(model_name)
    if step.control and step.control not in sliders:
        raise unknown("control", step.control, sliders, place)


def demand_values(step: SceneStep, model_name: str, run: Mapping[str, Any], place: str) -> None:
    """Raise InputError for values of the step's run that no slider can have."""
    model, sliders = find_model(model_name), number_parameters(model_name)
    for name, value in step.set.items():
        if name not in sliders:
            raise unknown("parameter", name, sliders, place)
        low, high = sliders[name].proposed
        if not low <= value <= high:
            raise InputError(
                f"set.{name} = {value:g} is not allowed: its slider goes from {low:g} to {high:g} "
                f"({place})"
            )
    parameters = checked(model.parameters, {**run, **step.set}, place)
    # A page refuses sliders whose zones change places; a run that begins so would be another one.
    radii = [zone.radius(parameters) for zone in model.rule.zones]
    if step.set and radii != sorted(radii):
        raise InputError(f"set = {step.set} is not allowed: zones keep their order ({place})")


def demand_measure(step: SceneStep, known: Collection[str], place: str) -> None:
    """Raise InputError for a measure that is none of those known."""
    if step.measure and step.measure not in known:
        raise unknown("measure", step.measure, known, place)


def number_parameters(model_name: str) -> dict[str, NumberParameter]:
    """The parameters of a model that a slider can set."""
    parameters = declared(find_model(model_name).parameters)
    return {each.name: each for each in parameters if isinstance(each, NumberParameter)}


def page_observables() -> list[str]:
    """The observables that a page can compute."""
    return [name for name, observable in OBSERVABLES.items() if observable.compiled is not None]


def demand_in_page(steps: Sequence[SceneStep], manifest: Mapping[str, Any], origin: str) -> None:
    """Raise InputError for a step that the page of this flock cannot take, by what it has."""
    movable = [slider["name"] for slider in manifest["parameters"] if slider["slots"]]
    measures = [measure["name"] for measure in manifest["measures"]]
    for number, step in enumerate(steps, 1):
        place = f"step {number}, {origin}"
        for name in filter(None, (step.control, *step.set)):
            if name not in movable:
                raise InputError(
                    f"{name} cannot be changed in a page of this flock: "
                    f"steps may have {', '.join(movable)} ({place})"
                )
        demand_measure(step, measures, place)
