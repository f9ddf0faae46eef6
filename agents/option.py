"""Declare an option of a run: its title and help for a person, and which values it may have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pydantic import BeforeValidator, Field, ValidationInfo

from worlds.input_error import InputError, shorten

MOST = 10**15
"""The largest count, unless there is a reason for a smaller one."""


@dataclass(frozen=True)
class Option:
    """How a person chooses an option of a run, on a command line and in a panel."""

    title: str
    help: str
    kind: type = str
    """Of its value: bool, int, float or str."""
    words: Mapping[str, str] = field(default_factory=dict)
    """Of an option with choices: what each is called."""
    least: float = 0
    """The least number that a panel offers, and the largest."""
    most: float = 0
    step: float = 1
    """From one number to the next in a panel."""
    unit: str = ""
    """Of a number: `time`, `length`, `length/time`, or what it is in every model."""
    also: tuple[str, ...] = ()
    """What other tools call it: who writes that is told its name."""


def option(title: str, help: str, default: Any = None, kind: type = str, **more: Any) -> Any:
    """A field of a spec that a person may choose; None is as the model, or its world, has it."""
    return Field(default, json_schema_extra={"option": Option(title, help, kind, **more)})  # type: ignore[dict-item]


def whole_number(name: str, value: Any, least: int, most: int = MOST) -> int:
    """`value` as a whole number in [least, most]. Raises InputError."""
    right = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not right or value < least:
        raise InputError(
            f"{name} = {shorten(value)} is not allowed: a whole number >= {least} is needed"
        )
    if value > most:
        raise InputError(f"{name} = {shorten(value)} is not allowed: the largest is {most}")
    return int(value)


def from_(least: int, most: int = MOST) -> BeforeValidator:
    """What checks a whole number in [least, most]."""
    return BeforeValidator(lambda value, info: whole_number(info.field_name, value, least, most))


def distance(value: Any, info: ValidationInfo) -> float:
    """A length >= 0. Raises InputError."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not 0.0 <= value < float("inf"):
        raise InputError(
            f"{info.field_name} = {shorten(value)} is not allowed: a finite number >= 0 is needed"
        )
    return float(value)


def between(least: float, most: float, unit: str = "") -> BeforeValidator:
    """What checks a finite number in [least, most]."""

    def number(value: Any, info: ValidationInfo) -> float:
        right = isinstance(value, int | float | np.number) and not isinstance(value, bool)
        if not right or not least <= value <= most:
            raise InputError(
                f"{info.field_name} = {shorten(value)} is not allowed: a number in "
                f"[{least:g}, {most:g}]{unit and ' ' + unit} is needed"
            )
        return float(value)

    return BeforeValidator(number)
