"""The parameters that a fit looks for, and the values that it tries of each."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.models.declare import NumberParameter, declared
from agents.models.model import Model
from agents.models.slider_range import is_wide, round_up
from worlds.input_error import InputError, shorten, unknown

VALUES = {1: 41, 2: 16, 3: 8, 4: 6}
"""Values of each of so many parameters, about, where nobody says how many."""
MOST_CELLS = 20_000
"""Cells of a grid at most."""


@dataclass(frozen=True)
class FittedParameter:
    """A parameter in question, and the values that are tried of it."""

    name: str
    unit: str
    values: tuple[float, ...]
    """Rising."""
    is_floor: bool
    """Whether nothing is below the least of them, as below a length of 0."""
    is_ceiling: bool
    """Whether nothing is above the largest, as above a view of 360 deg."""

    @property
    def range(self) -> tuple[float, float]:
        """The least and the largest value tried."""
        return self.values[0], self.values[-1]


def split_request(request: str) -> tuple[str, str]:
    """The name of `NAME` or `NAME=LOW:HIGH:STEPS`, and the rest.

    >>> split_request("dr_o"), split_request("dr_o=0:15:16")
    (('dr_o', ''), ('dr_o', '0:15:16'))
    """
    name, _, span = (part.strip() for part in request.partition("="))
    return name, span


def fitted_parameters(
    models: Sequence[Model], requests: Sequence[str]
) -> dict[str, tuple[FittedParameter, ...]]:
    """For each model, by name, those of the parameters that are asked for which it has.

    `requests`: each `NAME`, whose range is the one that the model proposes for sliders, or
    `NAME=LOW:HIGH:STEPS`. Raises InputError for a name that no model has, or that is no number.
    """
    names = [split_request(request)[0] for request in requests]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"parameter {name!r} is given twice")
        if not any(name in model.parameters.model_fields for model in models):
            known = dict.fromkeys(
                field for model in models for field in model.parameters.model_fields
            )
            raise unknown("parameter", name, known, ", ".join(model.name for model in models))
    return {model.name: _parameters_of(model, requests) for model in models}


def _parameters_of(model: Model, requests: Sequence[str]) -> tuple[FittedParameter, ...]:
    declarations = {declaration.name: declaration for declaration in declared(model.parameters)}
    pairs = [split_request(request) for request in requests]
    own = [(name, span) for name, span in pairs if name in declarations]
    parameters = tuple(
        _parameter(model, declarations[name], span, VALUES.get(len(own), 4)) for name, span in own
    )
    cells = math.prod(len(parameter.values) for parameter in parameters)
    if cells > MOST_CELLS:
        raise InputError(
            f"a grid of {cells} cells is not allowed: the largest has {MOST_CELLS}; ask for fewer "
            "parameters, or for fewer values with NAME=LOW:HIGH:STEPS"
        )
    return parameters


def _parameter(model: Model, declaration: Any, span: str, about: int) -> FittedParameter:
    name = declaration.name
    if not isinstance(declaration, NumberParameter):
        raise InputError(
            f"{name} of {model.name} is {declaration.allowed}: only numbers are fitted"
        )
    values = _read_span(declaration, span) if span else default_values(declaration, about)
    return FittedParameter(
        name,
        declaration.unit,
        values,
        is_floor=values[0] == 0.0 == declaration.low,
        is_ceiling=values[-1] == 360.0 == declaration.high and declaration.unit == "deg",
    )


def default_values(declaration: NumberParameter, about: int) -> tuple[float, ...]:
    """About so many round values over the range that a slider spans, or its logarithm."""
    low, high = declaration.proposed
    if is_wide(low, high):
        return tuple(float(f"{value:.3g}") for value in np.geomspace(low, high, about))
    step = round_up((high - low) / (about - 1))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return tuple(float(f"{k * step:.12g}") for k in range(first, last + 1))


def _read_span(declaration: NumberParameter, span: str) -> tuple[float, ...]:
    """The values of `LOW:HIGH:STEPS`, so many with both ends. Raises InputError."""
    name = declaration.name
    try:
        first, last, number = span.split(":")
        low, high, steps = float(first), float(last), int(number)
    except ValueError:
        raise InputError(
            f"{name} = {shorten(span)} is not of the form NAME=LOW:HIGH:STEPS, as {name}="
            f"{declaration.low:g}:{declaration.high:g}:11"
        ) from None
    if not (low < high and 2 <= steps <= MOST_CELLS):
        raise InputError(
            f"{name}={span} is not allowed: LOW < HIGH and 2 to {MOST_CELLS} STEPS are needed"
        )
    if not declaration.low <= low < high <= declaration.high:
        raise InputError(f"{name}={span} is outside {declaration.allowed}")
    return tuple(float(f"{value:.12g}") for value in np.linspace(low, high, steps))


def grid(parameters: Sequence[FittedParameter]) -> Iterator[Mapping[str, float]]:
    """Every combination of values, the last parameter changing first."""
    names = [parameter.name for parameter in parameters]
    for values in itertools.product(*(parameter.values for parameter in parameters)):
        yield dict(zip(names, values, strict=True))
