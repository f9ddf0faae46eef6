"""Choose the range that a slider proposes: narrow, around the default, within what is allowed."""

from __future__ import annotations

import math
from typing import Any

Range = tuple[float, float]
WIDE = 6.0
"""A range that ends within so many times the default is narrow enough."""
FACTOR = 4.0
"""A range that is made goes on to so many times the default."""
SCALE = 5.0
"""A default so many times as large is of another scale."""
STEPS = 200
"""The most steps of a slider whose default is no measure of anything: 0, or below."""
ROUNDING = 1e-9
DECADES = 2
"""A range above 0 that spans more decades than these is looked at by its logarithm."""


def round_down(value: float) -> float:
    """The largest of 1, 2, 5, 10, 20, ... and of 0.5, 0.2, 0.1, ... that is not above a value > 0.

    >>> round_down(0.07), round_down(49.0), round_down(20.0)
    (0.05, 20.0, 20.0)
    """
    power = math.floor(math.log10(value)) - 1
    steps = (float(f"{digit}e{power + shift}") for shift in range(3) for digit in (1, 2, 5))
    return max(step for step in steps if step <= value * (1.0 + ROUNDING))


def round_up(value: float) -> float:
    """The least of them that is not below a value > 0.

    >>> round_up(0.07), round_up(49.0), round_up(20.0)
    (0.1, 50.0, 20.0)
    """
    power = math.floor(math.log10(value)) - 1
    steps = (float(f"{digit}e{power + shift}") for shift in range(4) for digit in (1, 2, 5))
    return min(step for step in steps if step >= value * (1.0 - ROUNDING))


def is_wide(low: float, high: float) -> bool:
    """Whether a range is above 0 and spans more than two decades.

    >>> is_wide(0.01, 10.0), is_wide(0.1, 10.0), is_wide(0.0, 10.0)
    (True, False, False)
    """
    return low > 0.0 and high / low > 10.0**DECADES * (1.0 + ROUNDING)


def range_around(default: float, low: float, high: float, step: float | None = None) -> Range:
    """A narrow range around a default, within [low, high].

    >>> range_around(0.03, 0.0, 1.0, 0.005), range_around(4.0, 0.01, 100.0, 0.1)
    ((0.0, 0.2), (0.2, 20.0))
    """
    if low < 0.0:
        return low, high
    if default <= 0.0:
        step = step or high / STEPS
        narrow = high - low <= STEPS * step * (1.0 + ROUNDING)
        return low, high if narrow else min(high, round_up(STEPS / 2 * step))
    top = high if high <= WIDE * default else min(high, round_up(FACTOR * default))
    return (max(low, round_down(default / 10.0)) if is_wide(low, top) else low), top


def fits_default(proposed: Range | None, default: Any, other: Any) -> bool:
    """Whether a range that is proposed around a default will do around another one.

    It does not for another scale, such as that of a flock a tenth as large.
    """
    if proposed is None or isinstance(other, bool | str):
        return False
    within = proposed[0] <= other <= proposed[1]
    return within and (default == 0.0 or 1.0 / SCALE < other / default < SCALE)


def demand_proposed(proposed: Range, default: float, low: float, high: float) -> None:
    """Raise ValueError unless a range is one, within [low, high], with the default in it."""
    bottom, top = proposed
    if not (low <= bottom < top <= high and bottom <= default <= top and math.isfinite(top)):
        raise ValueError(
            f"proposed = ({bottom:g}, {top:g}) is no range within [{low:g}, {high:g}] with the "
            f"default {default:g} in it"
        )
