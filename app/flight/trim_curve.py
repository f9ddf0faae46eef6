"""Trims over speed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from agents.flight.trim import Trim, trim
from app.flight.request import SPEED, Request
from app.flight.trim_report import as_value
from worlds.input_error import InputError


def swept(
    asked: Request, speeds: list[float], at: Callable[[float], None]
) -> tuple[list[dict[str, Any]], list[float]]:
    """Values of the trims at speeds (m/s, rising), and the speeds without a level flight.

    Each is searched from its neighbour nearer to the usual speed. Raises InputError if there is no
    flight at all.
    """
    middle = min(speeds, key=lambda speed: abs(speed - SPEED))
    order = [one for one in speeds if one >= middle]
    order += [one for one in reversed(speeds) if one < middle]
    found: dict[float, Trim] = {}
    rows: dict[float, dict[str, Any]] = {}
    missing = []
    for done, speed in enumerate(order):
        near = min(found, key=lambda other: abs(other - speed), default=None)

        def share(part: float, done: int = done) -> None:
            at((done + part) / len(order))

        try:
            found[speed] = trim(
                asked.aircraft,
                speed,
                frequency=asked.frequency,
                twist=asked.twist,
                near=None if near is None else found[near],
                at=share,
            )
        except InputError:
            missing.append(speed)
            continue
        rows[speed] = as_value(found[speed])
    if not rows:
        raise InputError(
            f"no level flight was found at any speed of {', '.join(f'{one:g}' for one in speeds)}"
            " m/s: try other speeds, or another frequency or twist"
        )
    return [rows[speed] for speed in sorted(rows)], sorted(missing)
