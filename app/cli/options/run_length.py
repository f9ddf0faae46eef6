"""How long a run lasts: `--ticks`, or `--seconds` for models that count time in seconds."""

from __future__ import annotations

import math
from typing import Annotated

import typer

from app.settings import check_whole_number
from worlds.input_error import InputError

Ticks = Annotated[int | None, typer.Option("--ticks", help="Ticks that are run. \\[default: 100]")]
Seconds = Annotated[
    float | None,
    typer.Option(
        "--seconds", help="Instead of --ticks: time that is run, of a model that counts seconds."
    ),
]
ROUNDING = 1e-9
"""Share of a tick by which a time may be off and yet be whole ticks."""
MOST_SECONDS = 1e6


def demand_one_length(
    ticks: int | None, seconds: float | None, last: int | None = None, least: int = 0
) -> None:
    """Raise InputError if several options say how long it lasts, or for a length that is none.

    `last` is --to, where a command has it; `least` ticks are needed.
    """
    lengths = {"ticks": ticks, "seconds": seconds, "to": last}
    names = [name for name, value in lengths.items() if value is not None]
    if len(names) > 1:
        raise InputError(
            f"--{names[0]} and --{names[1]} exclude each other: both say how long it lasts"
        )
    low = "(" if least else "["
    if seconds is not None and not (0.0 <= seconds < MOST_SECONDS and (seconds or not least)):
        raise InputError(f"--seconds {seconds:g} is outside {low}0, 1e6)")
    check_whole_number("--ticks", ticks, least)


def ticks_asked(
    ticks: int | None, seconds: float | None, model: str, unit: str, dt: float
) -> int | None:
    """The ticks of a length, of a model whose tick is `dt` of a unit: so many that it is reached.

    None if neither is given. Raises InputError for seconds of a model that counts ticks.

    >>> ticks_asked(None, 0.25, "reynolds", "s", 0.1), ticks_asked(None, 0.3, "reynolds", "s", 0.1)
    (3, 3)
    """
    if seconds is None:
        return ticks
    if unit != "s":
        raise InputError(
            f"--seconds {seconds:g} is not allowed: {model} counts {unit}, give --ticks"
        )
    return math.ceil(seconds / dt - ROUNDING)
