"""Checks of what browsers send, before it goes to the control loop, which checks again."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from agents.models.declare import checked, describe
from agents.models.model import Model
from app.live.operating.flock_driver import NOT_SIMULATED
from worlds.input_error import InputError, unknown

LONGEST = 60
"""Characters of a value that are shown."""
PAGE = "the page"


def shown(value: object) -> str:
    """A value in a message, cut short.

    >>> shown("x" * 100)
    "'xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx..."
    """
    try:
        text = repr(value)
    except Exception:  # whatever it is, it can be refused
        return f"a {type(value).__name__}"
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."


def number(name: str, value: object) -> float:
    """A finite number. Raises InputError."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{name} = {shown(value)} is not allowed: it must be a number ({PAGE})")
    try:
        found = float(value)
    except OverflowError:
        found = math.inf
    if not math.isfinite(found):
        raise InputError(f"{name} = {found} is not allowed: it must be finite ({PAGE})")
    return found


def whole_number(name: str, value: object, most: int) -> int:
    """A whole number from 0 to `most`. Raises InputError."""
    found = number(name, value)
    if not found.is_integer() or not 0 <= found <= most:
        raise InputError(f"{name} = {found:g} is outside 0 to {most}, whole numbers ({PAGE})")
    return int(found)


def word(kind: str, value: object, known: Iterable[str]) -> str:
    """One of the words that are offered. Raises InputError."""
    offered = list(known)
    if not isinstance(value, str) or value not in offered:
        raise unknown(kind, value[:LONGEST] if isinstance(value, str) else value, offered, PAGE)
    return value


def parameter_value(model: Model, values: Mapping[str, Any], name: object, value: object) -> Any:
    """The value that a parameter takes beside those that are set. Raises InputError."""
    offered = [one for one in model.parameters.model_fields if one not in NOT_SIMULATED]
    known = word("parameter", name, offered)
    kind = describe(known, model.parameters.model_fields[known]).kind
    if kind == "number":
        value = number(known, value)
    elif not isinstance(value, bool if kind == "switch" else str):
        raise InputError(f"{known} = {shown(value)} is not allowed ({PAGE})")
    elif isinstance(value, str):
        value = value[:LONGEST]
    return getattr(checked(model.parameters, dict(values) | {known: value}, PAGE), known)
