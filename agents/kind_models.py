"""Models that kinds of agents have of their own: their parameters, and whether they fit a flock.

Such a kind moves by its own rule and body in the same ticks of the same world. The others see of it
what all agents show, its place, its heading and its speed; so nothing else may pass between them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from agents import catalogue
from agents.individuals import Distribution, split_individuals
from agents.kinds import Kind, KindTable
from agents.models.declare import Parameters, checked
from agents.models.model import Model
from agents.spec import Options
from worlds.input_error import InputError, shorten


@dataclass(frozen=True)
class KindModel:
    """The model that a kind has of its own."""

    number: int
    """Of the kind."""
    kind: Kind
    model: Model
    parameters: Parameters
    """What its agents share; of what differs among them the mean."""

    @property
    def own_numbers(self) -> dict[str, Any]:
        """Of the kind's parameters those that may differ among its agents."""
        return {
            name: value
            for name, value in self.kind.parameters.items()
            if name in self.model.individual
        }


@lru_cache(maxsize=256)
def parameters_of_kind(model: Model, values: tuple[tuple[str, type, Any], ...]) -> Parameters:
    """The parameters of a kind's own model; of values their types, too. Raises InputError."""
    shared, individuals = split_individuals({name: value for name, _, value in values})
    model.demand_individual(individuals)
    return checked(model.parameters, shared)


def kind_model(number: int, kind: Kind) -> KindModel:
    """The own model of a kind that has one. Raises InputError."""
    model = catalogue.model(kind.model)
    values = tuple(
        # 1 and True are one key of a cache, and not one parameter.
        (name, type(value), value)
        for name, value in kind.parameters.items()
        if not (isinstance(value, Distribution) and value.is_by_hand)
    )
    for name, _, value in values:
        if not isinstance(value, Distribution | str | int | float | np.number):
            raise InputError(f"{name} = {shorten(value)} is not allowed: a number is needed")
    return KindModel(number, kind, model, parameters_of_kind(model, values))


def kind_models(kinds: KindTable) -> tuple[KindModel, ...]:
    """The own models of all kinds that have one. Raises InputError."""
    return tuple(kind_model(number, kind) for number, kind in kinds.with_model.items())


def own_columns(model: Model, models: Sequence[KindModel]) -> tuple[str, ...]:
    """The parameters that the columns of `Arrays.own` hold: those of a flock's model, then those
    that the models of its kinds have beside them."""
    names = [model.individual, *(one.model.individual for one in models)]
    return tuple(dict.fromkeys(name for some in names for name in some))


def shared_numbers(
    model: Model, parameters: Parameters, kinds: KindTable, kind: np.ndarray
) -> np.ndarray:
    """What agents of these kinds (N,) have of all own columns (N, Q), where none has its own: what
    its model's agents share, nan of what that model has not."""
    models = kind_models(kinds)
    columns = own_columns(model, models)
    own = np.full((len(kind), len(columns)), np.nan)
    own[:, : len(model.individual)] = [
        float(getattr(parameters, name)) for name in model.individual
    ]
    for one in models:
        rows = kind == one.number
        own[rows] = np.nan
        for name in one.model.individual:
            own[rows, columns.index(name)] = float(getattr(one.parameters, name))
    return own


def evaluate_parameters(
    function: Callable[[Any], Any],
    model: Model,
    parameters: Parameters,
    columns: Mapping[str, np.ndarray],
    count: int,
) -> np.ndarray:
    """What a function of a model's parameters gives for each of so many agents, (N,).

    `columns`: the parameters that differ among them, by name, (N,) each.
    """
    names = sorted(model.parameters_read(function) & columns.keys() & set(model.individual))
    if not names:
        return np.full(count, float(function(parameters)))
    table = np.column_stack([columns[name] for name in names])
    rows, inverse = np.unique(table, axis=0, return_inverse=True)
    values = [
        float(function(parameters.model_copy(update=dict(zip(names, row, strict=True)))))
        for row in rows.tolist()
    ]
    return np.array(values, float)[inverse.reshape(-1)]


def reason_against(model: Model) -> str:
    """Why a model can be none of several in one flock, in few words; empty where it can be one."""
    rule, body = model.rule, model.body
    if model.name in catalogue.PLAYED:
        return "it is played and not run"
    if model.signals:
        return f"its agents tell signals ({', '.join(model.signals[:2])})"
    if rule.memory:
        return f"its agents remember ({', '.join(rule.memory[:2])})"
    if body.touches is not None:
        return "its agents can crash"
    if body.measures:
        return f"it measures its agents within a tick ({', '.join(body.measures[:2])})"
    return ""


def describe_known_kinds(model: Model) -> str:
    """Why a model cannot be that of a kind, though its flocks may have kinds with others."""
    if not model.rule.kinds:
        return ""
    return f"its rule knows kinds of agents of its own flocks ({', '.join(model.rule.kinds)})"


def demand_kind_models(
    model: Model,
    parameters: Parameters,
    kinds: KindTable,
    options: Options | None = None,
    dim: int | None = None,
) -> None:
    """Raise InputError for a kind whose own model does not fit a flock of a model.

    `options`, `dim`: how the flock acts and in how many dimensions, where that is known.
    """
    if not kinds.with_model:
        return
    kind_of_first = next(iter(kinds.with_model.values()))
    about = f"kind {kind_of_first.name}: a model of its own ({kind_of_first.model}) is not allowed"
    if reason := reason_against(model):
        raise InputError(f"{about} in a flock of {model.name}: {reason}")
    if options is not None and options.activation != "synchronous":
        raise InputError(
            f"{about} with activation = {options.activation}: agents of several models act all on "
            "the same instant"
        )
    if options is not None and options.is_late:
        raise InputError(
            f"{about} where messages take time or are inexact (delay, jitter, lost, place_error)"
        )
    for kind in kinds.with_model.values():
        other = catalogue.model(kind.model)
        reason = reason_against(other) or describe_known_kinds(other)
        if not reason and dim is not None and dim not in other.dimensions:
            allowed = " and ".join(f"{d}-D" for d in other.dimensions)
            reason = f"it is defined in {allowed}, and this world is {dim}-D"
        if not reason:
            reason = unlike_units(model, other)
        if reason:
            raise InputError(f"kind {kind.name}: model = {kind.model} is not allowed: {reason}")
    for one in kind_models_named(kinds):
        at = f"kind {one.kind.name}: model = {one.model.name} is not allowed"
        if one.model.nearest(one.parameters):
            raise InputError(
                f"{at}: its neighbours are the nearest, whatever their distance: set "
                "neighbours=metric"
            )
        ticks = float(model.body.lasts(parameters)), float(one.model.body.lasts(one.parameters))
        if ticks[0] != ticks[1]:
            names = sorted(one.model.parameters_read(one.model.body.lasts))
            unit = model.body.unit
            raise InputError(
                f"{at}: its tick is {ticks[1]:g} {unit} and the flock's {ticks[0]:g} {unit}"
                + (f": set {' or '.join(names)}" if names else "")
            )


def fitting_models(
    model: Model, parameters: Parameters, options: Options, dim: int
) -> tuple[str, ...]:
    """The names of other models that a kind of a flock may have as they are by default."""
    names = []
    for name in catalogue.MODELS:
        table = KindTable((Kind("fitting", 1, model=name),), {})
        with suppress(InputError):
            demand_kind_models(model, parameters, table, options, dim)
            names.append(name)
    return tuple(name for name in names if name != model.name)


def kind_models_named(kinds: KindTable) -> list[KindModel]:
    """The own models of kinds. Raises InputError naming the kind whose parameters are wrong."""
    models = []
    for number, kind in kinds.with_model.items():
        try:
            models.append(kind_model(number, kind))
        except InputError as error:
            raise InputError(f"kind {kind.name}: {error} (model {kind.model})") from None
    return models


def unlike_units(model: Model, other: Model) -> str:
    """In which unit another model counts what this one counts in another; empty where in none."""
    for what, mine, theirs in (
        ("time", model.body.unit, other.body.unit),
        ("length", model.in_units("length"), other.in_units("length")),
    ):
        if mine != theirs:
            return f"its unit of {what} is {theirs}, and that of {model.name} {mine}"
    return ""
