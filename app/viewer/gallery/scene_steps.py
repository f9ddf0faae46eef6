"""Steps of a scene that is a lesson: a sentence, a control or two, and what the reader predicts.

A prediction is judged by the reader's own run: it goes for some ticks, and the mean of one
observable over the last half of them, or its difference from that of an earlier step, says which of
the choices the run shows.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any

from pydantic import AfterValidator, ConfigDict, Field, ValidationError, model_validator

from agents.catalogue import model as find_model
from agents.individuals import moved
from agents.kinds import kind_table
from agents.models.declare import NumberParameter, checked, declared
from agents.observables.catalogue import OBSERVABLES
from agents.spec import CompleteSpec
from app.strict_table import StrictTable
from app.viewer.gallery.step_pictures import demand_picture, picture_address
from worlds.input_error import InputError, demand_line, first_input_error, shorten, unknown

MOST_STEPS = 12
MOST_TICKS = 20_000
"""Of a step's run: at a thousand ticks a second a reader waits for 20 seconds."""
MOST_CONTROLS = 2
MOST_CHOICES = 4
MOST_AGENTS = 20_000
"""Of a step's run: as many as a page may have."""
PREDICTION = ("choices", "measure", "ticks", "bounds")
"""What goes with `ask`: all of these, or none."""
OF_PREDICTION = (*PREDICTION, "kind", "set", "than", "shows", "why")
"""What means nothing without `ask`."""
RUN_OPTIONS = ("agents", "delay")
"""Options of a run that a step may set, beside parameters."""
ONE_LINE = AfterValidator(demand_line)


class SceneStep(StrictTable):
    """One step, as it stands in the file: `[[steps]]`.

    What it names (parameters, an observable) is checked by `read_steps`, which knows the model.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)

    say: Annotated[str, Field(min_length=1, max_length=240), ONE_LINE]
    """What to know, or what to do: one sentence."""
    picture: str = ""
    """Stands with the sentence: the name of a picture of the gallery, or one in itself, as an
    address `data:image/webp;base64,` (or png, jpeg); empty: none."""
    controls: Annotated[list[str], Field(max_length=MOST_CONTROLS)] = Field(default=[])
    """The parameters whose sliders stand with the step."""
    watch: str = ""
    """The observable whose curve stands first; empty: the measure of the prediction, if any."""
    ask: Annotated[str, Field(max_length=200), ONE_LINE] = ""
    """What the reader predicts, a question; empty: nothing."""
    choices: list[Annotated[str, Field(min_length=1, max_length=60), ONE_LINE]] = Field(
        default=[], max_length=MOST_CHOICES
    )
    """Answers, in the order in which the measure grows."""
    measure: str = ""
    """The observable that the run is judged by."""
    kind: Annotated[str, Field(max_length=32)] = ""
    """The kind of agents of which it is measured, by its name; empty: of all."""
    ticks: int = Field(default=0, ge=0, le=MOST_TICKS)
    """How long the run is, from its start."""
    bounds: list[float] = Field(default=[])
    """Between one choice and the next, in the unit of the measure: a mean that is on a bound or
    above it shows the later choice."""
    than: int = Field(default=0, ge=0, le=MOST_STEPS)
    """The earlier step whose mean is taken off before it is compared; 0: none."""
    set: dict[str, float] = Field(default={})
    """Parameters, also those of a kind of agents (`KIND.PARAMETER`), and options of `RUN_OPTIONS`,
    that the step's run begins with; the others are those of the scene."""
    shows: str = ""
    """The choice that the scene's own run shows; empty: not said."""
    why: Annotated[str, Field(max_length=240), ONE_LINE] = ""
    """What is told after a run that shows it, a sentence."""

    @model_validator(mode="before")
    @classmethod
    def _reads_one_control(cls, values: Any) -> Any:
        """Files of before have `control`, a name or nothing."""
        if not isinstance(values, Mapping) or "control" not in values:
            return values
        if "controls" in values:
            raise ValueError("control and controls are both given: leave control out")
        others = {key: value for key, value in values.items() if key != "control"}
        name = values["control"]
        return others | {"controls": [name] if name != "" else []}

    @model_validator(mode="after")
    def _is_whole(self) -> SceneStep:
        if not self.ask:
            extra = [key for key in OF_PREDICTION if getattr(self, key)]
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
        if self.shows and self.shows not in self.choices:
            raise ValueError(f"shows = {self.shows!r} is not allowed: one of {self.choices}")
        if self.why and not self.shows:
            raise ValueError("why is given without shows: after which choice is it told?")
        return self

    @property
    def first_measured_tick(self) -> int:
        """The tick from which the measure counts: the first of the last half."""
        return self.ticks // 2 + 1

    @property
    def shown_observable(self) -> str:
        """The observable whose curve stands first; empty: as before."""
        return self.watch or self.measure

    def choice_of(self, mean: float) -> str:
        """The choice that a run shows, by the mean of its measure, less that of the step `than`.

        >>> step = SceneStep(say="Look.", ask="?", choices=["less", "more"], measure="polarisation",
        ...                  ticks=10, bounds=[0.5])
        >>> step.choice_of(0.49), step.choice_of(0.5)
        ('less', 'more')
        """
        return self.choices[sum(mean >= bound for bound in self.bounds)]

    @property
    def described_measure(self) -> str:
        """What is measured, and of which kind of agents if not of all."""
        return f"{self.measure} of {self.kind}" if self.kind else self.measure

    def describe(self) -> str:
        """The step in words, for who reads the lesson without its page."""
        words = f"{self.say} [{', '.join(self.controls)}]" if self.controls else self.say
        if not self.ask:
            return words
        start = "".join(f", {name} = {value:g}" for name, value in self.set.items())
        less = f" less that of step {self.than}" if self.than else ""
        return (
            f"{words} {self.ask} {' / '.join(self.choices)} ({self.ticks} ticks{start}: mean "
            f"{self.described_measure} of ticks {self.first_measured_tick} to {self.ticks}{less}, "
            f"bounds {', '.join(f'{bound:g}' for bound in self.bounds)})"
        )

    def values(self) -> dict[str, Any]:
        """The step as its file and a page have it, without what it does not say."""
        return {key: value for key, value in self.model_dump().items() if value}

    def in_page(self) -> SceneStep:
        """The same as a page has it: what is measured of a kind is a measure of its own."""
        return self.model_copy(update={"measure": self.described_measure, "kind": ""})

    def page_values(self) -> dict[str, Any]:
        """The same for a page, which has no other file: the picture is in it."""
        values = self.in_page().values()
        return values | {"picture": picture_address(self.picture)} if self.picture else values


def read_steps(value: Any, spec: CompleteSpec, origin: str) -> tuple[SceneStep, ...]:
    """The steps of a scene with this run.

    Raises InputError naming the step, the value and what is allowed.
    """
    if not isinstance(value, list) or len(value) > MOST_STEPS:
        raise InputError(
            f"steps = {shorten(value)} is no list of at most {MOST_STEPS} tables ({origin})"
        )
    steps: list[SceneStep] = []
    for number, fields in enumerate(value, 1):
        place = f"step {number}, {origin}"
        try:
            step = SceneStep.model_validate(fields)
        except ValidationError as error:
            raise first_input_error(error, f"step {number}", origin) from None
        demand_picture(step.picture, place)
        demand_controls(step, spec.model, place)
        demand_values(step, spec, place)
        demand_measure(step, step_observables(spec), place)
        demand_kind(step, spec, place)
        demand_earlier(step, steps, place)
        steps.append(step)
    return tuple(steps)


def lesson_key(steps: Sequence[SceneStep]) -> str:
    """A short text that is the same for the same steps, wherever they were read; empty for none."""
    if not steps:
        return ""
    text = json.dumps([step.values() for step in steps], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def demand_controls(step: SceneStep, model_name: str, place: str) -> None:
    """Raise InputError for a control that is no slider of the model, or is there twice."""
    sliders = number_parameters(model_name)
    for name in step.controls:
        if name not in sliders:
            raise unknown("control", name, sliders, place)
    if len(set(step.controls)) < len(step.controls):
        raise InputError(f"controls = {step.controls} is not allowed: each once ({place})")


def demand_values(step: SceneStep, spec: CompleteSpec, place: str) -> None:
    """Raise InputError for values that no slider can have, or that no run can begin with."""
    model, sliders = find_model(spec.model), number_parameters(spec.model)
    kinds = [kind.name for kind in spec.kinds]
    for name, value in step.set.items():
        if name in RUN_OPTIONS:
            continue
        kind, _, own = name.rpartition(".")
        if kind and kind not in kinds:
            raise unknown("kind", kind, kinds, place)
        if own not in sliders:
            raise unknown("parameter", own, [*sliders, *RUN_OPTIONS], place)
        low, high = sliders[own].proposed
        if not low <= value <= high:
            raise InputError(
                f"set.{name} = {value:g} is not allowed: its slider goes from {low:g} to {high:g} "
                f"({place})"
            )
    if "agents" in step.set:
        demand_agents(step.set["agents"], spec, place)
    parameters = checked(model.parameters, {**spec.parameters, **own_parameters(step)}, place)
    # A page refuses sliders whose zones change places; a run that begins so would be another one.
    radii = [zone.radius(parameters) for zone in model.rule.zones]
    if own_parameters(step) and radii != sorted(radii):
        raise InputError(f"set = {step.set} is not allowed: zones keep their order ({place})")
    try:
        step_spec(spec, step)
    except InputError as refusal:
        raise InputError(f"set = {step.set} is not allowed: {refusal} ({place})") from None


def demand_kind(step: SceneStep, spec: CompleteSpec, place: str) -> None:
    """Raise InputError for a kind of agents to measure that the run does not have."""
    names = kind_table(spec.kinds, spec.to).names
    if step.kind and step.kind not in names:
        raise unknown("kind", step.kind, names, place)


def demand_agents(value: float, spec: CompleteSpec, place: str) -> None:
    """Raise InputError for a number of agents that the scene cannot have, or whose world would not
    keep its size."""
    if value != int(value) or not 1 <= value <= MOST_AGENTS:
        raise InputError(
            f"set.agents = {value:g} is not allowed: a whole number from 1 to {MOST_AGENTS} "
            f"({place})"
        )
    if spec.size is None:
        raise InputError(
            f"set.agents = {value:g} needs a size of the run: [run] has no size, and the world "
            f"would grow with the number of agents ({place})"
        )


def demand_earlier(step: SceneStep, before: Sequence[SceneStep], place: str) -> None:
    """Raise InputError for a step to compare with that is no earlier one with the same measure."""
    if not step.than:
        return
    measured = step.described_measure
    alike = [k for k, other in enumerate(before, 1) if other.described_measure == measured]
    if step.than not in alike:
        which = ", ".join(map(str, alike)) or "none"
        raise InputError(
            f"than = {step.than} is not allowed: an earlier step that measures {measured} "
            f"({which}; {place})"
        )


def own_parameters(step: SceneStep) -> dict[str, float]:
    """The parameters of the ordinary agents that a step sets."""
    return {
        name: value
        for name, value in step.set.items()
        if name not in RUN_OPTIONS and "." not in name
    }


def step_spec(spec: CompleteSpec, step: SceneStep) -> CompleteSpec:
    """The run of a step: the scene's, with what the step sets. Raises InputError.

    Where agents differ it is their centre that is set, as by a slider.
    """
    options: dict[str, Any] = {name: step.set[name] for name in RUN_OPTIONS if name in step.set}
    if "agents" in options:
        options["agents"] = int(options["agents"])
    parameters = spec.all_parameters
    for name, value in own_parameters(step).items():
        parameters[name] = moved(parameters.get(name), value)
    if any("." in name for name in step.set):
        options["kinds"] = tuple(
            kind.with_parameters(
                {
                    own: moved(kind.parameters.get(own), value)
                    for name, value in step.set.items()
                    for of, _, own in [name.rpartition(".")]
                    if of == kind.name
                }
            )
            for kind in spec.kinds
        )
    return spec.with_parameters(parameters, **options)


def demand_measure(step: SceneStep, known: Collection[str], place: str) -> None:
    """Raise InputError for a measure, or what is watched, that is none of those known."""
    for key in ("measure", "watch"):
        name = getattr(step, key)
        if name and name not in known:
            raise unknown(key, name, known, place)


def number_parameters(model_name: str) -> dict[str, NumberParameter]:
    """The parameters of a model that a slider can set."""
    parameters = declared(find_model(model_name).parameters)
    return {each.name: each for each in parameters if isinstance(each, NumberParameter)}


def step_observables(spec: CompleteSpec) -> list[str]:
    """The observables that a step can measure: those of a page that runs by itself, and where
    agents differ all that are a number at one tick."""
    if not spec.kinds and not spec.individuals:
        return page_observables()
    return [
        name
        for name, observable in OBSERVABLES.items()
        if not observable.is_table and observable.over is None
    ]


def page_observables() -> list[str]:
    """The observables that a page can compute."""
    return [name for name, observable in OBSERVABLES.items() if observable.compiled is not None]


def demand_in_page(steps: Sequence[SceneStep], manifest: Mapping[str, Any], origin: str) -> None:
    """Raise InputError for a step that the page of this flock cannot take, by what it has."""
    movable = {
        slider["name"]: (slider["low"], slider["high"])
        for slider in manifest["parameters"]
        if slider["slots"] or "of" in slider
    }
    measures = [measure["name"] for measure in manifest["measures"]]
    for number, step in enumerate(steps, 1):
        place = f"step {number}, {origin}"
        for name in (*step.controls, *step.set):
            if name == "agents" and manifest["start"] is not None:
                continue
            if name not in movable:
                raise InputError(
                    f"{name} cannot be changed in a page of this flock: "
                    f"steps may have {', '.join(movable)} ({place})"
                )
            low, high = movable[name]
            if not low <= step.set.get(name, low) <= high:
                raise InputError(
                    f"set.{name} = {step.set[name]:g} is not allowed: in a page of this flock it "
                    f"goes from {low:g} to {high:g} ({place})"
                )
        demand_measure(step.in_page(), measures, place)
