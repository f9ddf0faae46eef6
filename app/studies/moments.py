"""Axes of studies that are the mean or the spread of a parameter in which agents differ.

`s.spread = 0.5` has each agent draw its own `s` with that spread about the mean of the run, and
`s.mean` moves the mean; see `agents.individuals` for the distributions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, NamedTuple

from pydantic import BeforeValidator

from agents import catalogue
from agents.individuals import Distribution, normal
from agents.models.declare import DeclaredParameter, NumberParameter, declared
from agents.models.model import Model
from agents.spec import OPTIONS, Spec
from app.strict_table import Value
from worlds.input_error import InputError, shorten

MEAN, SPREAD = "mean", "spread"


class MomentAxis(NamedTuple):
    """The mean or the spread of a parameter."""

    parameter: str
    moment: str


def moment_axis(name: str) -> MomentAxis | None:
    """What an axis of that name is; None for one that is no mean and no spread.

    >>> moment_axis("s.spread"), moment_axis("s")
    (MomentAxis(parameter='s', moment='spread'), None)
    """
    parameter, _, moment = name.rpartition(".")
    return MomentAxis(parameter, moment) if parameter and moment in (MEAN, SPREAD) else None


def flatten_moments(axes: Any) -> Any:
    """Axes by name, also where TOML reads `s.spread = 1` as a table `spread` in a table `s`.

    >>> flatten_moments({"r": [1, 2], "s": {"mean": [2, 4], "spread": [0, 1]}})
    {'r': [1, 2], 's.mean': [2, 4], 's.spread': [0, 1]}
    """
    if not isinstance(axes, Mapping):
        return axes
    flat: dict[Any, Any] = {}
    for name, axis in axes.items():
        if isinstance(axis, Mapping) and axis and axis.keys() <= {MEAN, SPREAD}:
            flat |= {f"{name}.{moment}": values for moment, values in axis.items()}
        else:
            flat[name] = axis
    return flat


type ByAxis[Kind] = Annotated[dict[str, Kind], BeforeValidator(flatten_moments)]
"""What a file says of each axis."""


def spec_with(base: Spec, values: Mapping[str, Value | Distribution]) -> Spec:
    """A run with other options, parameters, means and spreads. Raises InputError.

    A parameter that is given as such is one of all agents again, unless its value is the text of a
    distribution.
    """
    moments = {name: value for name, value in values.items() if moment_axis(name)}
    options = {name: value for name, value in values.items() if name in OPTIONS or name == "model"}
    shared = {
        name: value for name, value in values.items() if name not in moments and name not in options
    }
    for axis in moments:
        parameter = axis.rpartition(".")[0]
        if parameter in shared:
            raise InputError(
                f"{axis} is not allowed beside {parameter}, which is one number of all agents: "
                f"vary {parameter}.{MEAN} and {parameter}.{SPREAD}"
            )
    spec = base.but(
        **options,
        parameters={**base.parameters, **shared},
        individuals={name: d for name, d in base.individuals.items() if name not in shared},
    )
    return with_moments(spec, moments) if moments else spec


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
        wanted.setdefault(name, {})[moment] = check_moment(model, axis, value)
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


def check_moment(model: Model, axis: str, value: Value | Distribution) -> float:
    """The value of an axis that is a mean or a spread. Raises InputError naming the axis."""
    name, moment = axis.rsplit(".", 1)
    try:
        model.demand_individual([name])
    except InputError as error:
        raise InputError(f"{axis}: {error}") from None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{axis} = {shorten(value)} is not allowed: a number is needed")
    declaration = declaration_of(model, name)
    unit = "" if declaration.unit == "1" else f" {declaration.unit}"
    if moment == SPREAD and value < 0.0:
        raise InputError(f"{axis} = {value:g}{unit} is not allowed: a spread is >= 0")
    assert isinstance(declaration, NumberParameter)  # agents can differ in nothing else
    if moment == MEAN and not declaration.low <= value <= declaration.high:
        raise InputError(f"{axis} = {value:g}{unit} is outside {declaration.allowed}")
    return float(value)


def declaration_of(model: Model, name: str) -> DeclaredParameter:
    """The declaration of a parameter that the model has."""
    return next(one for one in declared(model.parameters) if one.name == name)


def value_of(spec: Spec, axis: str) -> Any:
    """What a run has of an axis: of an option, a parameter, a mean or a spread.

    Of a parameter in which agents differ it is the text of the distribution. Raises InputError for
    what is none.
    """
    if axis in OPTIONS:
        return getattr(spec, axis)
    moment = moment_axis(axis)
    name = moment.parameter if moment else axis
    found: Distribution | None = spec.individuals.get(name)
    if moment and moment.moment == SPREAD:
        return found.spread if found else 0.0
    if found is not None:
        return found.centre if moment else found.to_text()
    model = catalogue.model(spec.model)
    if name not in spec.parameters and name in model.parameters.model_fields:
        return model.parameters.model_fields[name].default
    return spec.parameters[name]


def moment_label(
    model: str, axis: str, name: Callable[[DeclaredParameter], str] = lambda one: one.name
) -> str:
    """What stands along an axis of a mean or a spread, with the unit; "" for any other.

    `name`: what the parameter is called, by default its name.

    >>> moment_label("couzin", "s.spread"), moment_label("couzin", "s")
    ('spread of s / length/s', '')
    """
    moment, found = moment_axis(axis), catalogue.MODELS.get(model)
    if moment is None or found is None or moment.parameter not in found.individual:
        return ""
    declaration = declaration_of(found, moment.parameter)
    unit = "" if declaration.unit == "1" else f" / {declaration.unit}"
    return f"{moment.moment} of {name(declaration)}{unit}"
