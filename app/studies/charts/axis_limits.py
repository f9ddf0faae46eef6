"""Where the axes of charts end: never beyond what a quantity can be.

All charts ask `measure_limits` for what is measured and `parameter_limits` for what is varied:
those of sweeps, searches and classes, and the plot that the page of a class draws by itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from agents.observables.catalogue import OBSERVABLES
from agents.observables.observable import Range
from app.studies.measure import COUNT, UNBOUNDED, MeasureBounds
from app.studies.run_axes import AGENTS, SPREAD, axis_parameter, read_axis

Limits = tuple[float, float]
TICKS = "k"
"""The column of the ticks until runs stop."""
ROOM = 0.04
"""Of an axis, before the first value of a parameter and after the last, and around what is beyond
its bounds."""


def observable_of(column: str) -> str:
    """The observable that a column is of; nothing for a measure of somebody's own.

    >>> observable_of("polarisation-over-50"), observable_of("k")
    ('polarisation', '')
    """
    name = column.partition("-over-")[0]
    return name if name in OBSERVABLES else ""


def column_bounds(column: str) -> MeasureBounds:
    """What no run of a column of a sweep can be outside of, as its observable declares it.

    >>> column_bounds("polarisation-over-50")[:2], column_bounds("k")[:2], column_bounds("my.f")[:2]
    ((0.0, 1.0), (0.0, inf), (-inf, inf))
    """
    name = observable_of(column)
    value_range = OBSERVABLES[name].range if name else None
    if isinstance(value_range, Range):
        return MeasureBounds(value_range.low, value_range.high)
    return COUNT if column == TICKS else UNBOUNDED


def parameter_bounds(model: str, name: str) -> MeasureBounds:
    """What an axis of runs of a model can be, as the model declares it; unbounded if unknown.

    >>> parameter_bounds("vem", "agents")[:2], parameter_bounds("vem", "eta").low
    ((0.0, inf), 0.0)
    """
    axis = read_axis(name, model)
    if axis.item == AGENTS or axis.other or axis.moment == SPREAD:
        return COUNT
    found = axis_parameter(model, name)
    return UNBOUNDED if found is None else MeasureBounds(*found.bounds)


def measure_limits(
    values: Iterable[float], bounds: MeasureBounds = UNBOUNDED, ends: Iterable[float] = ()
) -> Limits:
    """The ends of the axis of what is measured, round numbers that seldom change while runs come.

    A share has the whole axis from 0 to 1, so that charts can be compared; what cannot be below 0
    begins there. All `values` are seen, even one that is beyond its bounds; `ends` of intervals
    only as far as the bounds go.

    >>> share = column_bounds("polarisation")
    >>> measure_limits([0.4, 0.6], share, [0.1, 1.2]), measure_limits([1.3], share)
    ((0.0, 1.0), (0.0, 1.352))
    >>> measure_limits([17.0], COUNT), measure_limits([-0.3, 0.2]), measure_limits([])
    ((0.0, 20.0), (-0.3, 0.2), (0.0, 1.0))
    """
    finite = [value for value in values if math.isfinite(value)]
    finite += [min(max(end, bounds.low), bounds.high) for end in ends if math.isfinite(end)]
    if bounds[:2] == (0.0, 1.0):
        finite += [0.0, 1.0]
    elif bounds.low == 0.0:
        finite.append(0.0)
    low, high = round_limits(finite)
    least, most = min(finite, default=low), max(finite, default=high)
    room = ROOM * (most - least)
    low = max(low, bounds.low) if least >= bounds.low else least - room
    high = min(high, bounds.high) if most <= bounds.high else most + room
    return low, high


def parameter_limits(
    values: Iterable[float], bounds: MeasureBounds = UNBOUNDED, log: bool = False
) -> Limits:
    """The ends of the axis of what is varied: its values with a little room within the bounds.

    >>> parameter_limits([0.0, 6.0], MeasureBounds(0.0, 6.2)), parameter_limits([2.0])
    ((0.0, 6.2), (1.0, 3.0))
    """
    finite = [float(value) for value in values if math.isfinite(value)]
    if not finite:
        return 0.0, 1.0
    low, high = min(finite), max(finite)
    if log:
        ratio = (high / low) ** ROOM if high > low else 2.0
        return low / ratio, min(high * ratio, max(bounds.high, high))
    room = ROOM * (high - low) or 0.5 * abs(high) or 1.0
    below = low - room
    if low >= 0.0:
        below = max(below, 0.0)
    return max(below, min(bounds.low, low)), min(high + room, max(bounds.high, high))


def round_limits(values: Iterable[float]) -> Limits:
    """Round numbers about some values.

    >>> round_limits([0.13, 0.92]), round_limits([])
    ((0.0, 1.0), (0.0, 1.0))
    """
    finite = [value for value in values if math.isfinite(value)]
    if not finite:
        return 0.0, 1.0
    low, high = min(finite), max(finite)
    if high - low < 1e-9 * max(1.0, abs(high)):
        low, high = low - 0.5 * max(abs(low), 1.0), high + 0.5 * max(abs(high), 1.0)
    step = round_step((high - low) / 6.0)
    ends = math.floor(low / step + 1e-9) * step, math.ceil(high / step - 1e-9) * step
    return round(ends[0], 12), round(ends[1], 12)


def round_step(step: float) -> float:
    """The next of 1, 2, 2.5, 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(step))
    return next(
        factor * power
        for factor in (1.0, 2.0, 2.5, 5.0, 10.0)
        if factor * power >= step * (1.0 - 1e-9)
    )


def spans_decades(values: Iterable[float]) -> bool:
    """Whether values are spread so that a logarithmic axis shows them better."""
    rising = sorted(set(values))
    if len(rising) < 4 or rising[0] <= 0.0 or rising[-1] < 30.0 * rising[0]:
        return False
    return rising[len(rising) // 2] < 0.3 * rising[-1]
