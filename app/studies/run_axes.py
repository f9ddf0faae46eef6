"""Axes of studies by their names: options, parameters, and numbers of kinds of agents.

| name | what it varies |
|---|---|
| `NAME` | an option or a parameter of all agents |
| `NAME.mean`, `NAME.spread` | of a parameter in which agents differ |
| `KIND.agents` | how many agents a kind has; 0: none |
| `KIND.NAME`, `KIND.NAME.mean`, `KIND.NAME.spread` | a parameter of a kind alone |
| `KIND.OTHER.weight`, also `radius`, `power`, `catch` | a number of a relation between two |

A kind may go by a model of its own: then its parameters are those of that model. Functions that
take the name of an axis take that model, which `AxisModels` has.

See `agents.individuals` for the distributions and `agents.kinds` for the relations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple

from pydantic import BeforeValidator

from agents import catalogue
from agents.individuals import Distribution, as_distribution, normal
from agents.kinds import ALIASES, ORDINARY, KindTable, Relation, kind_table, replace_kind
from agents.models.declare import DeclaredParameter, NumberParameter, declared
from agents.models.model import Model
from agents.spec import OPTIONS, Spec
from app.strict_table import Value
from worlds.input_error import InputError, shorten, unknown

MEAN, SPREAD = "mean", "spread"
AGENTS = "agents"
RELATION_NUMBERS = ("weight", "radius", "power", "catch")
LEAST_RADIUS, MOST_OF_RELATION = 1e-3, 1e4
"""Bounds of the numbers of a relation, where a form needs some."""
SPAN_KEYS = ("from", "to", "count", "step", "scale")
"""Of an axis between two bounds."""


class RunAxis(NamedTuple):
    """What an axis varies."""

    name: str
    """As it is written."""
    item: str
    """An option, a parameter, `agents`, or a number of a relation."""
    moment: str = ""
    """`mean` or `spread`; empty: the number itself."""
    kind: str = ""
    """Of which kind; empty: of all agents."""
    other: str = ""
    """Of a relation, the kind that it is about."""


class AxisModels(NamedTuple):
    """The models by which the agents of a run go: an axis is about a number of one of them."""

    flock: str
    kinds: Mapping[str, str] = MappingProxyType({})
    """Of each kind with a model of its own, by its name."""

    @classmethod
    def of_run(cls, spec: Spec) -> AxisModels:
        """Those of a run."""
        return cls(spec.model, {kind.name: kind.model for kind in spec.kinds if kind.model})

    @classmethod
    def of_table(cls, run: Any) -> AxisModels:
        """Those of a run as a file has it, whoever made that file; "" where it does not say one."""
        table = run if isinstance(run, Mapping) else {}
        flock, kinds = table.get("model"), table.get("kinds")
        named = {
            kind["name"]: kind["model"]
            for kind in (kinds if isinstance(kinds, list) else ())
            if isinstance(kind, Mapping)
            and isinstance(kind.get("name"), str)
            and isinstance(kind.get("model"), str)
        }
        return cls(flock if isinstance(flock, str) else "", named)

    def of_axis(self, name: str) -> str:
        """The model of the agents that an axis is about.

        >>> models = AxisModels("vem", {"loner": "gregoire-chate"})
        >>> models.of_axis("loner.eta"), models.of_axis("eta")
        ('gregoire-chate', 'vem')
        """
        axis = read_axis(name, self.flock)
        if not axis.kind and axis.item in fields_of(self.flock):
            return self.flock
        return self.kinds.get(axis.kind or axis.item, self.flock)


def fields_of(model: str) -> Mapping[str, Any]:
    """The fields of a model's parameters by name; none of a model that is unknown."""
    found = catalogue.MODELS.get(model)
    return found.parameters.model_fields if found else {}


def read_axis(name: str, model: str = "") -> RunAxis:
    """What an axis of that name is, of agents of a model.

    Whether there is such a kind is not asked.

    >>> read_axis("s.spread", "couzin").moment, read_axis("shark.s.mean", "couzin")[1:4]
    ('spread', ('s', 'mean', 'shark'))
    >>> read_axis("shark.prey.weight")
    RunAxis(name='shark.prey.weight', item='weight', moment='', kind='shark', other='flock')
    """
    first, *rest = name.split(".")
    if not rest:
        return RunAxis(name, name)
    known, last = fields_of(model), rest[-1]
    if len(rest) == 1 and last in (MEAN, SPREAD) and (first in known or last not in known):
        return RunAxis(name, first, last)
    if len(rest) == 2 and last in (MEAN, SPREAD):
        return RunAxis(name, rest[0], last, first)
    if len(rest) == 2 and last in RELATION_NUMBERS:
        return RunAxis(name, last, "", ALIASES.get(first, first), ALIASES.get(rest[0], rest[0]))
    return RunAxis(name, ".".join(rest), "", first)


def flatten_axes(axes: Any) -> Any:
    """Axes by name, also where TOML reads `s.spread = 1` as a table `spread` in a table `s`.

    >>> flatten_axes({"r": [1, 2], "s": {"mean": [2, 4]}, "shark": {"flock": {"weight": [0, 1]}}})
    {'r': [1, 2], 's.mean': [2, 4], 'shark.flock.weight': [0, 1]}
    """
    if not isinstance(axes, Mapping):
        return axes
    flat: dict[Any, Any] = {}
    for name, axis in axes.items():
        is_span = isinstance(axis, Mapping) and any(
            not isinstance(axis.get(key, {}), Mapping) for key in SPAN_KEYS
        )
        if isinstance(axis, Mapping) and axis and not is_span:
            flat |= {f"{name}.{key}": values for key, values in flatten_axes(axis).items()}
        else:
            flat[name] = axis
    return flat


type ByAxis[Kind] = Annotated[dict[str, Kind], BeforeValidator(flatten_axes)]
"""What a file says of each axis."""


# Runs with other values along axes.


def spec_with(base: Spec, values: Mapping[str, Value | Distribution]) -> Spec:
    """A run with other values of axes. Raises InputError naming the axis.

    A parameter that is given as such is one of all agents again, unless its value is the text of a
    distribution.
    """
    options = {name: value for name, value in values.items() if name in OPTIONS or name == "model"}
    models = AxisModels.of_run(base)._replace(flock=str(options.get("model", base.model)))
    axes = [read_axis(name, models.of_axis(name)) for name in values if name not in options]
    shared = {one.name: values[one.name] for one in axes if not one.moment and not one.kind}
    for axis in axes:
        whole = axis.name.removesuffix(f".{axis.moment}")
        if axis.moment and whole in values:
            raise InputError(
                f"{axis.name} is not allowed beside {whole}, which is one number of all agents: "
                f"vary {whole}.{MEAN} and {whole}.{SPREAD}"
            )
    spec = base.but(
        **options,
        parameters={**base.parameters, **shared},
        individuals={name: d for name, d in base.individuals.items() if name not in shared},
    )
    moments = {one.name: values[one.name] for one in axes if one.moment and not one.kind}
    spec = with_moments(spec, moments) if moments else spec
    of_kinds = [axis for axis in axes if axis.kind]
    return with_kind_numbers(spec, of_kinds, values) if of_kinds else spec


def with_moments(spec: Spec, moments: Mapping[str, Value | Distribution]) -> Spec:
    """A run with other means and spreads of its parameters, by axis. Raises InputError.

    A distribution keeps its kind; a plain number becomes a normal distribution once it has a
    spread.
    """
    model = catalogue.model(spec.model)
    parameters, individuals = dict(spec.parameters), dict(spec.individuals)
    wanted: dict[str, dict[str, float]] = {}
    for axis, value in moments.items():
        name, moment = axis.rsplit(".", 1)
        wanted.setdefault(name, {})[moment] = check_number(
            model, read_axis(axis, model.name), value
        )
    for name, values in wanted.items():
        try:
            if name in individuals:
                individuals[name] = individuals[name].with_moments(**values)
            elif SPREAD in values:
                mean = values.get(MEAN, value_of(spec, name))
                individuals[name] = normal(mean, values[SPREAD])
        except InputError as error:
            raise InputError(f"{name}.{next(iter(values))}: {error}") from None
        parameters[name] = individuals[name].centre if name in individuals else values[MEAN]
    return spec.but(parameters=parameters, individuals=individuals)


def check_number(model: Model, axis: RunAxis, value: Any) -> float:
    """The value of an axis over a number in which agents differ. Raises InputError naming it."""
    try:
        model.demand_individual([axis.item])
    except InputError as error:
        raise InputError(f"{axis.name}: {error}") from None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{axis.name} = {shorten(value)} is not allowed: a number is needed")
    declaration = declaration_of(model, axis.item)
    unit = "" if declaration.unit == "1" else f" {declaration.unit}"
    if axis.moment == SPREAD and value < 0.0:
        raise InputError(f"{axis.name} = {value:g}{unit} is not allowed: a spread is >= 0")
    assert isinstance(declaration, NumberParameter)  # agents can differ in nothing else
    if axis.moment != SPREAD and not declaration.low <= value <= declaration.high:
        raise InputError(f"{axis.name} = {value:g}{unit} is outside {declaration.allowed}")
    return float(value)


def with_kind_numbers(spec: Spec, axes: list[RunAxis], values: Mapping[str, Any]) -> Spec:
    """A run with other numbers of its kinds, by axis. Raises InputError naming the axis.

    Chases come first: who is chased flees as its relation says, or else as the chase does.
    """
    table = kind_table(spec.kinds, spec.to)
    for axis in axes:
        demand_kinds_of(axis, table)
    for axis in sorted(axes, key=lambda one: table.of(one.kind, one.other).deed != "chase"):
        value = values[axis.name]
        try:
            if axis.other:
                relation = replace(relation_of(table, axis), **{axis.item: value})
                table = table.with_relation(axis.kind, axis.other, relation)
                continue
            kind = table.kind(axis.kind)
            if axis.item == AGENTS:
                is_whole = isinstance(value, float) and value.is_integer()
                agents = int(value) if is_whole else value
                table = table.with_kind(replace_kind(kind, agents=agents))
                continue
            number = value_for_kind(spec, table, axis, value)
            table = table.with_kind(kind.with_parameters({axis.item: number}))
        except InputError as error:
            text = str(error)
            raise InputError(
                text if text.startswith(axis.name) else f"{axis.name}: {text}"
            ) from None
    return spec.but(kinds=table.kinds, to=table.to)


def value_for_kind(spec: Spec, table: KindTable, axis: RunAxis, value: Any) -> Any:
    """The number or the distribution that an axis gives a kind of its parameter. Or InputError."""
    model = model_of_kind(spec, table, axis.kind)
    given = None if axis.moment else as_distribution(value)
    if given is not None:
        model.demand_individual([axis.item])
        return given
    number = check_number(model, axis, value)
    if not axis.moment:
        return number
    before = own_value(spec, table, axis)
    if isinstance(before, Distribution):
        return before.with_moments(**{axis.moment: number})
    return number if axis.moment == MEAN else normal(float(before), number)


def own_value(spec: Spec, table: KindTable, axis: RunAxis) -> Any:
    """The number or the distribution that a kind has of a parameter: its own, or that of all."""
    kind, shared = table.kind(axis.kind), spec.individuals.get(axis.item)
    if axis.item in kind.parameters:
        return kind.parameters[axis.item]
    if kind.model:
        return model_of_kind(spec, table, axis.kind).parameters.model_fields[axis.item].default
    return value_of(spec, axis.item) if shared is None else shared


def model_of_kind(spec: Spec, table: KindTable, name: str) -> Model:
    """The model by which a kind goes: its own, or that of the flock."""
    return catalogue.model(table.kind(name).model or spec.model)


def demand_kinds_of(axis: RunAxis, table: KindTable) -> None:
    """Raise InputError for an axis over kinds that there are not."""
    if not table.kinds:
        raise InputError(f"{axis.name} is not allowed: this run has no kinds of agents")
    if not axis.other and axis.kind in (ORDINARY, *ALIASES):
        raise InputError(f"{axis.name} is not allowed: write {axis.name.partition('.')[2]}")
    for name in (axis.kind, axis.other) if axis.other else (axis.kind,):
        if name not in table.names:
            names = table.names if axis.other else table.names[1:]
            raise InputError(f"{axis.name}: {unknown('kind', name, names)}")


def relation_of(table: KindTable, axis: RunAxis) -> Relation:
    """The relation that an axis varies. Raises InputError for one without such a number."""
    relation = table.of(axis.kind, axis.other)
    if relation.deed not in ("chase", "flee"):
        raise InputError(
            f"{axis.kind} has the relation {relation.deed} to {axis.other}, without a "
            f"{axis.item}: chase and flee have one"
        )
    return relation


# What a run has of an axis, and what an axis may have.


def declaration_of(model: Model, name: str) -> DeclaredParameter:
    """The declaration of a parameter that the model has."""
    return next(one for one in declared(model.parameters) if one.name == name)


def value_of(spec: Spec, name: str) -> Any:
    """What a run has of an axis.

    Of a parameter in which agents differ it is the text of the distribution. Raises InputError for
    what is none.
    """
    if name in OPTIONS:
        return getattr(spec, name)
    axis = read_axis(name, AxisModels.of_run(spec).of_axis(name))
    if axis.kind:
        return value_of_kind(spec, axis)
    found: Distribution | None = spec.individuals.get(axis.item)
    if axis.moment == SPREAD:
        return found.spread if found else 0.0
    if found is not None:
        return found.centre if axis.moment else found.to_text()
    model = catalogue.model(spec.model)
    if axis.item not in spec.parameters and axis.item in model.parameters.model_fields:
        return model.parameters.model_fields[axis.item].default
    return spec.parameters[axis.item]


def value_of_kind(spec: Spec, axis: RunAxis) -> Any:
    """What a run has of an axis over a kind's number. Raises InputError."""
    table = kind_table(spec.kinds, spec.to)
    demand_kinds_of(axis, table)
    if axis.other:
        try:
            number = getattr(relation_of(table, axis), axis.item)
        except InputError as error:
            raise InputError(f"{axis.name}: {error}") from None
        if number is None:
            raise InputError(f"{axis.name} has no number in this run: give the relation one")
        return number
    if axis.item == AGENTS:
        return table.kind(axis.kind).agents
    try:
        model_of_kind(spec, table, axis.kind).demand_individual([axis.item])
    except InputError as error:
        raise InputError(f"{axis.name}: {error}") from None
    value = own_value(spec, table, axis)
    if not isinstance(value, Distribution):
        return 0.0 if axis.moment == SPREAD else value
    if axis.moment:
        return value.centre if axis.moment == MEAN else value.spread
    return value.to_text()


def numeric_axes(spec: Spec) -> list[RunAxis]:
    """What of a run can be an axis of numbers: parameters, agents, then what its kinds have."""
    names = (one.name for one in number_parameters(spec.model))
    own = (axis for name in names for axis in moment_axes(name, spec.individuals.get(name)))
    return [*own, RunAxis(AGENTS, AGENTS), *kind_axes(spec)]


def number_parameters(model: str) -> list[NumberParameter]:
    """The parameters of a model that are numbers with a range; none of a model that is unknown."""
    found = catalogue.MODELS.get(model)
    listed = declared(found.parameters) if found else ()
    return [one for one in listed if isinstance(one, NumberParameter)]


def moment_axes(item: str, own: Distribution | None, kind: str = "") -> Iterator[RunAxis]:
    """The axes over a parameter: its number, or the mean and the spread of what agents draw."""
    has_moments = own is not None and own.kind in ("normal", "lognormal", "uniform")
    for moment in ("",) if own is None else (MEAN, SPREAD) if has_moments else ():
        yield RunAxis(".".join(filter(None, (kind, item, moment))), item, moment, kind)


def kind_axes(spec: Spec) -> Iterator[RunAxis]:
    """The axes over numbers of a run's kinds: agents, parameters, then relations."""
    table = kind_table(spec.kinds, spec.to)
    for kind in table.kinds:
        yield RunAxis(f"{kind.name}.{AGENTS}", AGENTS, "", kind.name)
        model = model_of_kind(spec, table, kind.name)
        shared = {} if kind.model else spec.individuals
        for one in number_parameters(model.name):
            own = kind.parameters.get(one.name, shared.get(one.name))
            if one.name in model.individual:
                drawn = own if isinstance(own, Distribution) else None
                yield from moment_axes(one.name, drawn, kind.name)
    for (name, other), relation in table.relations.items():
        for item in RELATION_NUMBERS if relation.deed in ("chase", "flee") else ():
            is_given = item != "power" or relation.power is not None
            if is_given and (item != "catch" or relation.deed == "chase"):
                yield RunAxis(f"{name}.{other}.{item}", item, "", name, other)


def axis_parameter(model: str, name: str) -> NumberParameter | None:
    """The declared number that an axis is about; None for an option, agents, or a relation."""
    axis = read_axis(name, model)
    found = (one for one in number_parameters(model) if one.name == axis.item and not axis.other)
    return next(found, None)


def is_whole_axis(model: str, name: str) -> bool:
    """Whether an axis has whole numbers only."""
    axis = read_axis(name, model)
    if axis.other or axis.moment:
        return False
    if axis.item == AGENTS:
        return True
    fields = catalogue.MODELS[model].parameters.model_fields
    return axis.item in fields and fields[axis.item].annotation is int


def allowed_span(model: str, name: str, most_agents: float) -> tuple[float, float]:
    """The least and the largest value of an axis. Raises InputError for what is none.

    Whether a run has such a kind is not asked: `spec_with` does.
    """
    axis = read_axis(name, model)
    if axis.item == AGENTS and not axis.moment:
        return (0.0 if axis.kind else 1.0), most_agents
    if axis.other:
        return (LEAST_RADIUS if axis.item == "radius" else 0.0), MOST_OF_RELATION
    found = axis_parameter(model, name)
    if found is None:
        known = [one.name for one in number_parameters(model)]
        raise unknown("axis", name, [*known, AGENTS])
    if axis.kind or axis.moment:
        try:
            catalogue.model(model).demand_individual([axis.item])
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
    low, high = found.bounds
    return (0.0, high - low) if axis.moment == SPREAD else (low, high)


def axis_label(
    model: str, name: str, words: Callable[[DeclaredParameter], str] = lambda one: one.name
) -> str:
    """What stands along an axis that is no plain option or parameter, with the unit; else "".

    `words`: what the parameter is called, by default its name.

    >>> axis_label("couzin", "s.spread"), axis_label("couzin", "s")
    ('spread of s / length/s', '')
    >>> axis_label("couzin", "shark.s"), axis_label("couzin", "shark.flock.radius")
    ('s of shark / length/s', 'radius of shark to flock / length')
    """
    axis = read_axis(name, model)
    if not axis.moment and not axis.kind:
        return ""
    found = axis_parameter(model, name)
    if found is None and axis.item not in (AGENTS, *RELATION_NUMBERS):
        return ""
    parts = [axis.moment, axis.item if found is None else words(found)]
    text = " of ".join(filter(None, (*parts, axis.kind)))
    unit = axis_unit(model, name)
    text += f" to {axis.other}" if axis.other else ""
    return text if unit == "1" else f"{text} / {unit}"


def axis_unit(model: str, name: str) -> str:
    """The unit of an axis; 1 for a pure number, and for what is unknown."""
    axis, found = read_axis(name, model), axis_parameter(model, name)
    if found is not None:
        return found.unit
    return "length" if axis.other and axis.item in ("radius", "catch") else "1"
