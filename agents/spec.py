"""A run as a value: all that says which run to make; from words and TOML, and back."""

from __future__ import annotations

import platform
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeGuard, Unpack, get_args

import numpy as np
import tomlkit
from pydantic import (
    BeforeValidator,
    Field,
    PlainSerializer,
    PlainValidator,
    ValidationError,
    ValidationInfo,
)

from agents.conditions import Conditions
from agents.individuals import Distribution, split_individuals
from agents.kinds import Kind, Relation, as_kinds, as_relation, kind_table
from agents.option import Option, distance, from_, option, whole_number
from worlds.input_error import InputError, needed, shorten, unknown
from worlds.text_file import read_text, toml
from worlds.world import World, box

if TYPE_CHECKING:
    from agents.flock_words import SpecWords

DEFAULT = "hwvem"
"""The model of a run that names none."""
LARGEST_SEED = 2**63 - 1


def several(size: Any) -> TypeGuard[Sequence[float]]:
    """Whether a size is one per axis."""
    return isinstance(size, list | tuple | np.ndarray)


def sides(size: Any) -> float | tuple[float, ...]:
    """The side of a box, or one per axis. Raises InputError."""
    return box(len(size), size) if several(size) else box(1, size)[0]


def dimensions(value: Any) -> int:
    """2 or 3. Raises InputError."""
    if isinstance(value, bool) or value not in (2, 3):
        raise InputError(f"dim = {shorten(value)} is not allowed: a world has 2 or 3 dimensions")
    return int(value)


def name(value: Any, info: ValidationInfo) -> str:
    """A name. Raises InputError."""
    if not isinstance(value, str):
        raise InputError(f"{info.field_name} = {shorten(value)} is not a name")
    return value


def distributions(value: Any) -> dict[str, Distribution]:
    """Distributions by the names of parameters. Raises InputError."""
    if not isinstance(value, Mapping):
        raise InputError(f"individuals = {shorten(value)} is not allowed: names are needed")
    return split_individuals(value)[1]


def values_of(named: Mapping[str, Distribution | Relation]) -> dict[str, Any]:
    """Distributions or relations as TOML and JSON have them."""
    return {name: one.to_value() for name, one in named.items()}


def values_of_kinds(kinds: Sequence[Kind]) -> list[dict[str, Any]]:
    """Kinds as TOML and JSON have them."""
    return [kind.to_value() for kind in kinds]


def relations(value: Any) -> dict[str, Relation]:
    """Relations by the names of kinds. Raises InputError."""
    if not isinstance(value, Mapping):
        raise InputError(f"to = {shorten(value)} is not allowed: names of kinds are needed")
    return {str(name): as_relation(one) for name, one in value.items()}


def name_or_world(value: Any, info: ValidationInfo) -> str | World:
    """A world, or the name of one. Raises InputError."""
    return value if isinstance(value, World) else name(value, info)


class Options(Conditions):
    """How the agents of a run begin and act; None: as the model has it.

    An option that is declared here is a word of `Flock`, an option of `flockscope run` and `lab`, a
    key of specs and of rows and sweeps of experiments, and a control of the panel Setup.
    """

    informed: Annotated[int, from_(0)] | None = option(
        "Informed",
        "Information agents: they know the heading to take, or the path of the mission",
        kind=int,
        most=100,
    )
    activation: Literal["synchronous", "random", "sequential"] = option(
        "Turns",
        "Who decides when: all on the same instant, or one after the other as in NetLogo",
        "synchronous",
        words={"synchronous": "all at once", "random": "random order", "sequential": "one by one"},
        also=("schedule", "scheduler", "update"),
    )
    noise: Literal["angular", "vectorial"] = option(
        "Noise",
        "What eta means. Angular: an angle is added to the heading. Vectorial: a vector is added "
        "to the mean heading. A model whose paper defines its noise keeps that",
        "angular",
        words={"angular": "angular", "vectorial": "vectorial"},
    )
    spacing: Annotated[float, BeforeValidator(distance)] | None = option(
        "Spacing",
        "At the start, least distance between two agents and of an agent to obstacles and walls "
        "(length); 0 as in the paper: nobody starts inside an obstacle",
        kind=float,
        most=100.0,
        step=0.1,
    )

    @property
    def chosen(self) -> dict[str, Any]:
        """The options that are not as they are by default."""
        return self.model_dump(include=set(Options.model_fields), exclude_defaults=True)


class Spec(Options):
    """A run as it is asked for: by a command line, a TOML file, a script or a panel.

    What is None is as the model, or its world, has it; a seed is drawn then. `Flock(spec)` begins
    the run, `flock.spec` is a `CompleteSpec`, which leaves nothing open. `start = "given"` marks a
    run that began from a user's arrays: its spec describes it, but only a saved state can begin it
    again. Raises InputError.

    >>> Spec("vem", agents=30, size=5.0).agents
    30
    """

    model: Annotated[str, PlainValidator(name)]
    agents: Annotated[int, from_(0)] | None = option(
        "Agents",
        "Ordinary agents; information agents come on top",
        kind=int,
        step=10,
        also=(
            "n",
            "N",
            "n_agents",
            "num_agents",
            "number_of_agents",
            "population",
            "population_size",
            "num_boids",
            "turtles",
        ),
    )
    seed: Annotated[int, from_(0, LARGEST_SEED)] | None = option(
        "Seed", "Same seed, same run", kind=int, also=("random_seed",)
    )
    size: Annotated[float | tuple[float, ...], BeforeValidator(sides)] | None = option(
        "Side",
        "Side of the world, or one per axis (length). A world with obstacles or a mission has its "
        "own; any other has the density of the paper",
        kind=float,
        step=0.5,
        also=(
            "width",
            "height",
            "side",
            "L",
            "box_size",
            "world_size",
            "x_max",
            "max_pxcor",
            "world_width",
        ),
    )
    dim: Annotated[int, BeforeValidator(dimensions)] | None = option(
        "Dimension",
        "2 or 3: plane or space; a world built in space has no other",
        kind=int,
        also=("dimensions", "ndim"),
    )
    """As many as there are sides, where `size` has several."""
    world: Annotated[str | World, PlainValidator(name_or_world)] | None = option(
        "World",
        "A built-in world or a TOML file: what stands in it, what happens at its edges, and where "
        "the flock is to go. A model is at home in one of its own",
        also=("torus", "edges", "boundary", "periodic", "environment", "topology", "wrap"),
    )
    start: Literal["random", "given"] = "random"
    parameters: dict[str, Any] = Field(default_factory=dict)
    """Of the rule and the body; the model checks them. One that is given as a distribution, or as a
    list of each agent's number, comes into `individuals`; here stands its mean then."""
    individuals: Annotated[
        dict[str, Distribution], PlainValidator(distributions), PlainSerializer(values_of)
    ] = Field(default_factory=dict)
    """The parameters that differ from agent to agent, as `agents.individuals.Distribution`."""
    layout: dict[str, Any] | None = None
    """The world itself, where it is none of the built-in ones."""
    versions: dict[str, str] = Field(default_factory=dict)
    """Of what the numbers depend on."""

    kinds: Annotated[
        tuple[Kind, ...], PlainValidator(as_kinds), PlainSerializer(values_of_kinds)
    ] = ()
    """Kinds of agents beside the ordinary ones, on top of `agents`."""
    to: Annotated[dict[str, Relation], PlainValidator(relations), PlainSerializer(values_of)] = (
        Field(default_factory=dict)
    )
    """What the ordinary agents do about other kinds, by their names."""

    def __init__(self, model: Any = DEFAULT, **words: Unpack[SpecWords]) -> None:
        values: dict[str, Any] = {**words}
        if isinstance(values.get("parameters"), Mapping):
            shared, individuals = split_individuals(values["parameters"])
            if individuals:
                earlier = distributions(values.get("individuals", {}))
                values |= {"parameters": shared, "individuals": earlier | individuals}
        size = values.get("size")
        if (
            values.get("dim") is None
            and isinstance(size, list | tuple | np.ndarray)
            and len(size) > 1
        ):
            values["dim"] = len(size)
        try:
            super().__init__(**{"model": model, **values})
        except ValidationError as error:
            raise input_error_of(error.errors()[0]) from None
        if self.agents is not None and self.start == "random":
            whole_number("agents", self.agents, 1)
        kind_table(self.kinds, self.to)
        if self.is_late and self.activation != "synchronous":
            raise InputError(
                f"activation = {self.activation!r} is not allowed where messages take time or are "
                "inexact (delay, jitter, lost, place_error): agents then decide all at once"
            )

    def __eq__(self, other: object) -> bool:
        """Whether it is the same run; how much of it has been checked to be there is no matter."""
        return dict(self) == dict(other) if isinstance(other, Spec) else NotImplemented

    @property
    def count(self) -> int:
        """All agents, information agents and those of all kinds among them."""
        return (self.agents or 0) + (self.informed or 0) + self.count_of_kinds

    @property
    def count_of_kinds(self) -> int:
        """All agents of kinds beside the ordinary one."""
        return sum(kind.agents for kind in self.kinds)

    @property
    def models(self) -> tuple[str, ...]:
        """The names of all models that its agents go by, the flock's own the first."""
        of_kinds = (kind.model for kind in self.kinds if kind.model)
        return tuple(dict.fromkeys((self.model, *of_kinds)))

    def but(self, **changes: Any) -> Spec:
        """The same run with some things changed. Raises InputError."""
        return Spec(**{**dict(self), **changes})

    def relating(self, kind: str, other: str, relation: Any) -> Spec:
        """The same run with another relation of a kind to another. Raises InputError."""
        table = kind_table(self.kinds, self.to).with_relation(kind, other, relation)
        return self.but(kinds=table.kinds, to=table.to)

    def taking(self, **words: Any) -> Spec:
        """The same run with options that are not None, and parameters: all other words."""
        if not words:
            return self
        options = {key: words.pop(key) for key in OPTIONS if key in words}
        given_options = {key: value for key, value in options.items() if value is not None}
        individuals = {name: d for name, d in self.individuals.items() if name not in words}
        return self.but(
            **given_options, parameters={**self.parameters, **words}, individuals=individuals
        )

    @property
    def all_parameters(self) -> dict[str, Any]:
        """The parameters by name, those that differ from agent to agent as distributions."""
        return {**self.parameters, **self.individuals}

    def with_parameters(self, parameters: Mapping[str, Any], **changes: Any) -> Self:
        """The same run with these parameters and no others, numbers or distributions.

        `changes`: of what else. Raises InputError.
        """
        values = {**dict(self), **changes}
        return type(self)(**values | {"parameters": dict(parameters), "individuals": {}})

    def to_toml(self) -> str:
        """The spec as TOML; floats are written so that they come back to the bit."""
        spec = self
        if isinstance(self.world, World):
            spec = self.but(world=self.world.name, layout=self.world.to_layout())
        implied = {"dim"} if isinstance(spec.size, tuple) else set()
        implied |= {key for key in Conditions.model_fields if key not in self.chosen}
        values = spec.model_dump(mode="json", exclude_none=True, exclude=implied)
        values["parameters"] |= values.pop("individuals")
        values = {key: one for key, one in values.items() if one or key not in ("kinds", "to")}
        return tomlkit.dumps({key: values[key] for key in KEYS if key in values})

    @classmethod
    def from_toml(cls, text: str, origin: str = "TOML text") -> Spec:
        """A spec from TOML. Raises InputError naming the line or the key that is wrong."""
        return cls.from_values(toml(text, origin), origin)

    @classmethod
    def from_values(cls, values: Mapping[str, Any], origin: str) -> Spec:
        """A spec from a dictionary. Raises InputError naming the key that is wrong."""
        for key in values:
            if key not in (*KEYS, "individuals"):
                raise unknown("key", key, KEYS, origin)
        if "model" not in values:
            raise InputError(f"model is missing ({origin})")
        try:
            return cls(**values)
        except InputError as error:
            raise InputError(f"{error} ({origin})") from None

    @classmethod
    def read(cls, path: str | Path) -> Spec:
        """A spec from a TOML file. Raises InputError."""
        return cls.from_toml(read_text(f"spec {str(path)!r}", path), str(path))

    def demand_complete(self, origin: str) -> CompleteSpec:
        """The same run, of which nothing may be open, its size neither. Raises InputError."""
        for key in ("agents", "informed", "seed", "world", "size", "dim"):
            if getattr(self, key) is None:
                raise InputError(f"{key} is missing ({origin})")
        return CompleteSpec(**dict(self))


class CompleteSpec(Spec):
    """A run that can be made: the same one gives the same numbers, to the bit, on the same machine.

    `agents.flock_world.complete_spec` makes it of a `Spec`, and `flock.spec` is one. Its size alone
    may be None: the world's own then, or by the number of agents such that the density is the
    model's. Raises InputError.
    """

    agents: Annotated[int, from_(0)]
    informed: Annotated[int, from_(0)]
    seed: Annotated[int, from_(0, LARGEST_SEED)]
    dim: Annotated[int, BeforeValidator(dimensions)]
    world: Annotated[str | World, PlainValidator(name_or_world)]

    def with_values(self, **changes: Any) -> CompleteSpec:
        """The same run with some values changed, none of them opened but the size.

        Raises InputError.
        """
        return CompleteSpec(**{**dict(self), **changes})

    def but(self, **changes: Any) -> Spec:
        """The same run with some things changed: open again where None stands for one of them.

        Raises InputError.
        """
        is_opened = any(changes.get(key, "") is None for key in CLOSED)
        return super().but(**changes) if is_opened else self.with_values(**changes)


CLOSED = tuple(CompleteSpec.__annotations__)
"""What a complete run cannot leave open."""
FIRST = ("model", "agents", "informed", "seed", "world", "size", "dim")
ACTS = ("activation", "noise", "spacing")
KEYS = tuple(
    key for key in dict.fromkeys([*FIRST, *ACTS, *Spec.model_fields]) if key != "individuals"
)
"""Keys of a spec, in the order in which they are written."""
_EXTRAS: dict[str, Any] = {key: Spec.model_fields[key].json_schema_extra for key in KEYS}
OPTIONS: dict[str, Option] = {key: extra["option"] for key, extra in _EXTRAS.items() if extra}
"""What a person may choose of a run beside its model, by name."""


def input_error_of(fault: Any) -> InputError:
    """What pydantic found wrong with a spec, in our words."""
    error = fault.get("ctx", {}).get("error")
    if isinstance(error, InputError):
        return error
    key = ".".join(str(part) for part in fault["loc"])
    if fault["type"] == "extra_forbidden":
        return unknown("option", key, OPTIONS)
    if fault["type"] == "literal_error":
        if not isinstance(fault["input"], str):
            return InputError(f"{key} = {shorten(fault['input'])} is not a name")
        return unknown(key, fault["input"], get_args(Spec.model_fields[key].annotation))
    return InputError(f"{key} = {shorten(fault['input'])} is not allowed: {needed(fault)}")


RANDOM_NUMBERS = "2"
"""What a seed gives: another number where the same seed gives another run. 2: hashes give starts,
random orders and gusts; 1: NumPy's generator did."""


def versions() -> dict[str, str]:
    """Versions of what the numbers depend on."""
    own = {"python": platform.python_version(), "random-numbers": RANDOM_NUMBERS}
    return own | package_versions()


@cache
def package_versions() -> dict[str, str]:
    """Versions of packages: to read them takes milliseconds each time."""
    return {name: version(name) for name in ("flockscope", "mesa", "numba", "numpy")}


def changed_versions(
    written: Mapping[str, str], now: Mapping[str, str]
) -> Iterator[tuple[str, str, str]]:
    """The name of each version that is not as it was written, what it was, and what it is now.

    What was written before there were versions of random numbers has their first. What is not
    written, as in a spec made by hand, has not changed.
    """
    if written:
        written = {"random-numbers": "1"} | dict(written)
    for name, before in written.items():
        if name in now and now[name] != before:
            yield name, before, now[name]
