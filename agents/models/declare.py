"""How rules and bodies declare themselves, and their parameters with symbol, unit and range.

Sliders, command-line options, checks, error messages and documentation are all read from these
declarations; nothing about a rule is written twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic.fields import FieldInfo

from agents.kinds import Kind, as_kinds
from agents.models.slider_range import Range, demand_proposed, range_around
from agents.models.tries import LessonStep
from worlds.compilation import LoopDispatcher
from worlds.input_error import InputError, unknown


def parameter(
    default: Any,
    description: str,
    *,
    symbol: str,
    source: str,
    low: float | None = None,
    high: float | None = None,
    unit: str = "1",
    step: float | None = None,
    noise: bool = False,
    words: str = "",
    proposed: Range | None = None,
) -> Any:
    """A parameter's declaration: default, range [low, high], unit, symbol and source.

    `words` are what a slider is called, two or three; without them it bears the parameter's name.
    Booleans and choices (`Literal`) have no range. `proposed` is the part of the range that a
    slider spans, where something is to be seen; a range above 0 of more than two decades is spanned
    by its logarithm. Without it one is made around the default. `step` is the slider's. `noise`
    says that it is the strength of something random, which 0 takes away. Raises ValueError for a
    proposed range that is not within the range or does not hold the default.
    """
    if proposed is not None:
        if low is None or high is None:
            raise ValueError(f"proposed = {proposed} is given without a range: give low and high")
        demand_proposed(proposed, default, low, high)
    return Field(
        default,
        ge=low,
        le=high,
        description=description,
        json_schema_extra={
            "symbol": symbol,
            "unit": unit,
            "source": source,
            "step": step,
            "noise": noise,
            "words": words,
            "proposed": proposed,  # type: ignore[dict-item]
        },
    )


class Parameters(BaseModel):
    """Parameters of a rule or a body. Unknown names and values out of range are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


@dataclass(frozen=True)
class DeclaredParameter:
    """One parameter as a viewer, a command line or a page of documentation needs it."""

    name: str
    symbol: str
    unit: str
    description: str
    source: str
    default: Any
    kind: Literal["number", "switch", "choice"]
    low: float | None
    high: float | None
    step: float | None
    choices: tuple[str, ...]
    noise: bool
    words: str
    proposed: Range | None
    """What a slider spans of it; None of what is no number."""

    @property
    def allowed(self) -> str:
        """What values are allowed, in words: `[0, 6.283] rad`, `on or off`, `one of a, b`."""
        if self.kind == "switch":
            return "true or false"
        if self.kind == "choice":
            return "one of " + ", ".join(self.choices)
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"[{self.low:g}, {self.high:g}]{unit}"


@dataclass(frozen=True)
class NumberParameter(DeclaredParameter):
    """A number with a range: what a slider sets and a sweep varies."""

    low: float
    high: float
    proposed: Range

    @property
    def bounds(self) -> Range:
        """The least and the largest value that are allowed."""
        return self.low, self.high


@cache
def declared(model: type[Parameters]) -> tuple[DeclaredParameter, ...]:
    """The declared parameters of a model, in order."""
    return tuple(describe(name, field) for name, field in model.model_fields.items())


def describe(name: str, field: FieldInfo) -> DeclaredParameter:
    """One field of a parameter model as a `DeclaredParameter`."""
    extra = field.json_schema_extra
    assert isinstance(extra, dict), f"{name} is not made with parameter()"
    low = next((m.ge for m in field.metadata if hasattr(m, "ge")), None)
    high = next((m.le for m in field.metadata if hasattr(m, "le")), None)
    choices: tuple[str, ...] = ()
    kind: Literal["number", "switch", "choice"] = "number"
    if field.annotation is bool:
        kind = "switch"
    elif get_origin(field.annotation) is Literal:
        kind, choices = "choice", get_args(field.annotation)
    proposed: Any = extra["proposed"]
    if proposed is None and low is not None and high is not None:
        proposed = range_around(field.default, low, high, extra["step"])  # type: ignore[arg-type]
    is_ranged = kind == "number" and low is not None and high is not None
    values: dict[str, Any] = {
        "name": name,
        "symbol": str(extra["symbol"]),
        "unit": str(extra["unit"]),
        "description": field.description or "",
        "source": str(extra["source"]),
        "default": field.default,
        "kind": kind,
        "low": low,
        "high": high,
        "step": extra["step"],
        "choices": choices,
        "noise": bool(extra["noise"]),
        "words": str(extra["words"] or name.replace("_", " ")),
        "proposed": proposed,
    }
    return NumberParameter(**values) if is_ranged else DeclaredParameter(**values)


def checked(
    model: type[Parameters],
    values: dict[str, Any],
    origin: str = "",
    other_names: Iterable[str] = (),
) -> Parameters:
    """The values as a parameter model.

    Raises InputError naming the parameter, its value, what is allowed and `origin`, where it came
    from. `other_names`: what else may stand beside parameters, and is suggested for a wrong name.
    """
    location = f" ({origin})" if origin else ""
    for name in values:
        if name not in model.model_fields:
            raise unknown("parameter", name, model.model_fields, origin, other_names)
    try:
        return model(**values)
    except ValidationError as error:
        name = str(error.errors()[0]["loc"][0])
        declaration = describe(name, model.model_fields[name])
        unit = (
            ""
            if declaration.unit == "1" or declaration.kind != "number"
            else f" {declaration.unit}"
        )
        raise InputError(
            f"{name} = {values[name]!r}{unit} is outside {declaration.allowed}{location}"
            if declaration.kind == "number" and isinstance(values[name], int | float)
            else f"{name} = {values[name]!r} is not allowed: it must be "
            f"{declaration.allowed}{location}"
        ) from None


def as_floats(parameters: Parameters) -> dict[str, float]:
    """Parameters as the compiled code has them: a switch as 0 or 1, a choice as its index."""
    fields = type(parameters).model_fields
    numbers = {}
    for name, value in parameters:
        choices = get_args(fields[name].annotation) if isinstance(value, str) else ()
        numbers[name] = float(choices.index(value) if choices else value)
    return numbers


Wished = Literal["heading", "acceleration", "velocity"]
"""What a rule may wish for and a body take."""


Symmetry = Literal["shift", "rotation", "mirror"]
ALL_ALIKE: tuple[Symmetry, ...] = ("shift", "rotation", "mirror")
"""What space has no preferred place, direction or side for."""


TOPICS = ("biology", "physics", "robotics", "crowds", "classroom")
"""What rules are sorted by, beside what they are."""


@dataclass(frozen=True)
class Zone:
    """A zone around an agent, from the one before it outwards to a radius."""

    name: str
    radius: Callable[[Any], float]
    """Outer radius (length) from the parameters."""
    all_round: bool = False
    """Whether agents outside of the field of view are noticed there too."""


OF_RULES = (
    "perceive",
    "decide",
    "term",
    "answer",
    "show",
    "remember",
    "prepare",
    "weigh",
    "explain",
)
OF_BODIES = ("move", "measure", "touches", "passes", "explain")
"""The compiled functions of a rule, and of a body."""


def demand_compiled(title: str, part: Any, names: Sequence[str]) -> None:
    """Raise TypeError if a function of a rule or a body is not made with `compiled`."""
    for name in names:
        function = getattr(part, name)
        if function is not None and not isinstance(function, LoopDispatcher):
            raise TypeError(f"{title}: {name} is not @compiled")


@dataclass(frozen=True)
class Rule:
    """What an agent wants: one file, one declaration. `decide` reads like the paper."""

    name: str
    title: str
    summary: str
    """One or two sentences for a person who chooses a model."""
    equation: str
    """The equation in LaTeX, for the documentation."""
    source: str
    """Where it is from, in words; papers are cited by how `agents.models.sources` names them."""
    parameters: type[Parameters]
    decide: Callable
    """Compiled: (me, near, surroundings, p) -> Wish."""
    term: Callable | None = None
    """Compiled: (me, other, p) -> the terms of a pair, for a rule that is a sum over pairs."""
    answer: Callable | None = None
    """Compiled: (me, sums, surroundings, p) -> Wish, from the sums of those terms. It may write
    `me.memory`. `agents.rules.terms.sums.of_pairs` says how it is given boundary points."""
    sums: int = 0
    """How many terms a pair has."""
    by_lanes: bool = False
    """Whether `answer` takes eight agents at once."""
    wish: Wished = "heading"
    """What `decide` answers; a body takes one kind of wish."""
    reach: str = "r"
    """Name of the parameter that is the largest distance at which agents notice each other."""
    bound: str = ""
    """Name of the parameter that does not count where the nearest are neighbours, whatever their
    distance; by default `reach`."""
    together: str = ""
    """Name of the parameter within which agents are of one group; by default `reach`."""
    dimensions: tuple[int, ...] = (2, 3)
    signals: tuple[str, ...] = ()
    """What agents tell each other beside position and heading; rows of `near.signal`."""
    show: Callable | None = None
    """Compiled: (me, p, out). Signals that follow from the agent's own state."""
    remember: Callable | None = None
    """Compiled: (me, near, p, out). Signals for the next tick."""
    memory: tuple[str, ...] = ()
    """What an agent keeps to itself, in the order of `me.memory`; 0 at the start."""
    written: tuple[str, ...] = ()
    """Of its memory, what each tick writes before it is read: files without it are read as well."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Units of its signals and its memory by name, of points and vectors NAME_x, NAME_y, ... by
    NAME; what has none is a pure number."""
    words: Mapping[str, str] = field(default_factory=dict)
    """What people call these, by the same names, in few words; what is 1 or 0 as a question."""
    places: tuple[str, ...] = ()
    """Points in that memory, NAME_x and NAME_y of each; an agent heads for the last of them."""
    places_while: str = ""
    """Which of the memory is 1.0 while these points count."""
    kinds: tuple[str, ...] = ()
    """The kinds of agents that it knows: those of `me.kind` 1, 2, ... in this order, 0 being an
    ordinary agent. A flock has them, with agents or without."""
    hunters: str = ""
    """The signal that is 1.0 for agents that hunt the others."""
    perceive: Callable | None = None
    """Compiled: (me, near, surroundings, p). Brings `me.memory` up to date, before `decide`."""
    prepare: Callable | None = None
    """Compiled: (flock, space, grid, slots, p, tick). What needs the whole flock, once a tick."""
    weigh: Callable | None = None
    """Compiled: (me, near, p, out). How much it listens to each of the block; None: 1 each."""
    forces: tuple[str, ...] = ()
    """The terms that a wished acceleration or velocity is the sum of."""
    explain: Callable | None = None
    """Compiled: (me, near, surroundings, p, out). The forces one by one, out (len(forces), 3)."""
    sees_obstacles: bool = False
    """Whether the rule steers clear of obstacles and solid edges; else agents bounce off them."""
    sifts: bool = False
    """Whether those within reach shall be picked out first where there are many: a gain for a rule
    that goes over its neighbours more than once, or whose term is dear; else a loss."""
    sees_points: bool = False
    """Whether `near` shall hold the boundary points of obstacles within reach."""
    zones: tuple[Zone, ...] = ()
    """Where it does what, from the inside out."""
    view: str = ""
    """Name of the parameter that is the full angle (deg) of its field of view."""
    informed: int = 0
    """Information agents unless the user says otherwise."""
    led: bool = True
    """Whether there may be information agents."""
    noise: Literal["", "angular", "vectorial"] = ""
    """The kind of noise that is part of its definition; empty: what the run says."""
    checked: str = ""
    """The published fact that it is checked against, with the number and the command."""
    bibtex: str = ""
    """Entries of its own, for a source that `agents.models.sources` does not have."""
    converges: bool = False
    """Whether the flock is meant to converge to the information agent's heading."""
    symmetries: tuple[Symmetry, ...] = ALL_ALIKE
    """What makes no difference to agents in empty space, noise apart: `agents.conformance`."""
    tags: tuple[str, ...] = ()
    """Words by which somebody may look for it: topics of `agents.models.declare.TOPICS`, and what
    it is known by elsewhere."""
    tries: tuple[LessonStep, ...] = ()
    """What there is to try with it: three things that a newcomer may do and see."""
    form: Literal["birds", "fish"] = "birds"
    """What its source is about, and so what its agents are drawn as: birds are darts in the
    plane."""

    def __post_init__(self) -> None:
        title = f"rule {self.name!r}"
        demand_compiled(title, self, OF_RULES)
        if not isinstance(self.kinds, tuple):
            raise TypeError(f"{title}: kinds = {self.kinds!r} is no tuple of names")
        try:
            as_kinds([Kind(name, 0) for name in self.kinds])
        except InputError as error:
            raise TypeError(f"{title}: {error}") from None


@dataclass(frozen=True)
class Vehicle:
    """What makes a body a car: which of its signals are what; empty where it has no such signal.

    Its size is that of its parameters `length` and `width`, if it has them.
    """

    length: float = 0.22
    """Of the body of one without that parameter, m."""
    width: float = 0.12
    fresh: str = ""
    """1.0 until it has moved once; its other signals count from then on."""
    steering: str = ""
    """Angle of its front wheels, rad, to the left positive."""
    pace: str = ""
    """Speed, m/s."""
    stuck: str = ""
    """Time for which it has not got on, s; below 0 while it backs out for that."""
    wheel: str = ""
    """The command sent last: angle of the wheels, rad. A real car can obey a body that has it."""
    throttle: str = ""
    """The command sent last: share of full throttle."""


def one_tick(parameters: Parameters) -> float:  # noqa: ARG001 - the signature of `Body.lasts`
    """Time is counted in ticks."""
    return 1.0


@dataclass(frozen=True)
class Body:
    """How an agent can move: turns what is wanted into the next position."""

    name: str
    title: str
    source: str
    parameters: type[Parameters]
    move: Callable
    """Compiled: (me, near, surroundings, want, p, out) -> Moved; `out` receives its signals."""
    by_lanes: bool = False
    """Whether `move` takes eight agents at once, and so has no `if` that asks about one."""
    takes: Wished = "heading"
    """What it is given to follow: a rule's wish."""
    signals: tuple[str, ...] = ()
    """What bodies tell each other; they follow the rule's signals."""
    size: str = ""
    """Name of the parameter that is its diameter; a point by default."""
    touches: Callable | None = None
    """Compiled: (me, near, surroundings, p) -> 1.0 where it touches another agent, 2.0
    where it touches what is solid, else 0.0; an agent that touches something crashes. None: it is
    a point."""
    measures: tuple[str, ...] = ()
    """What is measured of each agent within the pass."""
    measure: Callable | None = None
    """Compiled: (me, near, p, out). Measures it, on the flock as the tick finds it."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Units of its signals and of what is measured, as those of a rule."""
    words: Mapping[str, str] = field(default_factory=dict)
    """What people call these."""
    begins: Callable[[Any, Any], Any] | None = None
    """(p, chance) -> an agent's speed at the start, from a number uniform in [0, 1); of an array
    those of many. None: 0."""
    speed: Callable[[Any], float] | None = None
    """The speed at which all its agents go while nothing is in their way, from the parameters: they
    have it from tick 0 on, whatever speeds a start hands them. None: speeds are free."""
    deafens: bool = False
    """Whether its last signal is 1.0 for agents whose heading counts and 0.0 for others."""
    sees_obstacles: bool = False
    """Whether it keeps clear of obstacles and solid edges, whatever the rule wants."""
    stops: bool = False
    """Whether it stops where a step would take it into a solid that the rule or the body sees; else
    it slides along."""
    passes: Callable | None = None
    """Compiled: (p) -> whether it goes through what is solid, as the words of its paper have it.
    None: never."""
    passes_with: str = ""
    """The setting with which it does, such as `guard = false`."""
    stride: Callable[[Any], float] | None = None
    """How far from what is solid it starts at least, from the parameters: as far as it may go in
    the first tick. None: half its `size`."""
    sight: str = ""
    """Name of the parameter that is how far it notices obstacles; by default the rule's `reach`."""
    forces: tuple[str, ...] = ()
    """The terms that its velocity is the sum of."""
    explain: Callable | None = None
    """Compiled: (me, near, surroundings, p, out). The forces one by one, out (len(forces), 3)."""
    lasts: Callable[[Any], float] = one_tick
    """The time that a tick stands for, from the parameters."""
    unit: str = "ticks"
    """Unit of that time."""
    symmetries: tuple[Symmetry, ...] = ALL_ALIKE
    """What makes no difference to it in empty space, noise apart."""
    vehicle: Vehicle | None = None
    """What there is to a car; None: it is none."""
    family: str = ""
    """With which models it is listed: vicsek, mission, aircraft, else as its rule is."""

    def __post_init__(self) -> None:
        demand_compiled(f"body {self.name!r}", self, OF_BODIES)
