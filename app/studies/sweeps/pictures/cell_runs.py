"""The runs of a sweep for a picture: cell by cell, with what has no value counted beside."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from app.strict_table import Value
from app.studies.runs.database import BROKEN
from app.studies.runs.store_reader import StoreReader
from app.studies.sweeps.replicates import half_width
from app.studies.sweeps.sweep_file import Condition
from app.studies.sweeps.sweep_table import axes_of, measured
from worlds.input_error import InputError, unknown


@dataclass
class CellRuns:
    """The runs of a cell."""

    axes: dict[str, Value]
    number: int
    """Of its cell in the store."""
    values: list[float] = field(default_factory=list)
    """Of the runs that came to an end and have one."""
    seeds: list[int] = field(default_factory=list)
    """Of the same runs."""
    gave_up: int = 0
    broken: int = 0

    @property
    def mean(self) -> float:
        """Of the values; nan without any."""
        return sum(self.values) / len(self.values) if self.values else math.nan

    @property
    def half(self) -> float:
        """Half of the 95 % interval of the mean; nan below two values, and of equal ones."""
        return half_width(self.values)


def groups_of(
    kept: StoreReader, observable: str | None, where: str = ""
) -> tuple[str, list[CellRuns]]:
    """The observable that is shown, the first by default, and the cells with runs. Or
    InputError."""
    columns, axes = measured(kept), axes_of(kept)
    if not columns:
        raise InputError("there is nothing with one value for each run: export the series instead")
    name = columns[0] if observable is None else observable
    if name not in columns:
        raise unknown("observable", name, columns, str(kept.folder))
    condition = Condition(where, axes) if where else None
    groups = {
        number: CellRuns(
            {axis: cell["axes"][axis] for axis in axes if axis in cell["axes"]}, number
        )
        for number, cell in kept.cells.items()
    }
    for cell, seed, status, *_, value in kept.runs([name]):
        group = groups[cell]
        if status in BROKEN:
            group.broken += 1
        elif status == "gave-up":
            group.gave_up += 1
        elif value is not None:
            group.values.append(float(value))
            group.seeds.append(seed)
    kept_groups = [
        group
        for group in groups.values()
        if (group.values or group.gave_up or group.broken)
        and (condition is None or condition.holds(group.axes))
    ]
    if not kept_groups:
        raise InputError(f"there is no run to draw yet ({kept.folder})")
    return name, kept_groups


def is_number(value: Any) -> bool:
    """Whether a value has a place along an axis."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def values_of(groups: Sequence[CellRuns], axis: str) -> list[Value]:
    """The values that an axis takes, each once: numbers rising, words as they come."""
    found = list(dict.fromkeys(group.axes[axis] for group in groups if axis in group.axes))
    return sorted(found) if all(map(is_number, found)) else found


def varied(groups: Sequence[CellRuns]) -> list[str]:
    """The axes that take more than one value, the one with most values first."""
    names = list(dict.fromkeys(name for group in groups for name in group.axes))
    counts = {name: len(values_of(groups, name)) for name in names}
    return sorted((name for name in names if counts[name] > 1), key=lambda name: -counts[name])


def label(axes: dict[str, Value]) -> str:
    """Axes with their values, for a legend.

    >>> label({"agents": 100, "eta": 0.5})
    'agents = 100, eta = 0.5'
    """
    return ", ".join(
        f"{name} = {value:g}" if is_number(value) else f"{name} = {value}"
        for name, value in axes.items()
    )
