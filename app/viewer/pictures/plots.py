"""Curves below a film: observables over its time, drawn as far as it has come."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from agents.models.model import Model
from agents.observables.catalogue import OBSERVABLES
from agents.observables.observable import Range
from agents.snapshot import Snapshot
from app.worlds.colours import INK, PALE
from worlds.input_error import InputError, unknown

TALL = 1.55
"""Inches that they take."""
LEFT, RIGHT, BELOW, ABOVE = 0.75, 0.3, 0.5, 0.3
"""Inches around a plot."""
COLOUR = "#2f6fde"


class Plots:
    """Observables from time `first` to time `last`. Raises InputError for what is no curve."""

    def __init__(self, names: Sequence[str], first: float, last: float):
        for name in names:
            if name not in OBSERVABLES:
                raise unknown("observable", name, OBSERVABLES)
            if OBSERVABLES[name].over or OBSERVABLES[name].is_table:
                raise InputError(f"--plot {name} is not one number at each tick")
        self.names, self.ends = list(names), (first, max(last, first + 1e-9))
        self.times: list[float] = []
        self.values: dict[str, list[float]] = {name: [] for name in self.names}
        self.lines: list[Any] = []

    def draw(self, figure: Any, model: Model) -> None:
        """Make the axes along the lower edge of a figure."""
        wide, tall = figure.get_size_inches()
        each = (wide - RIGHT) / len(self.names)
        self.lines = []
        for k, name in enumerate(self.names):
            axes = figure.add_axes(
                ((k * each + LEFT) / wide, BELOW / tall, (each - LEFT) / wide,
                 (TALL - BELOW - ABOVE) / tall)
            )  # fmt: skip
            one = OBSERVABLES[name]
            unit = "" if one.unit == "1" else f" / {model.in_units(one.unit)}"
            axes.set_title(f"{name.replace('-', ' ')}{unit}", loc="left", fontsize=9.5, color=INK)
            axes.set_xlabel(f"time / {model.body.unit}", fontsize=9)
            axes.tick_params(labelsize=8.5, length=3, color=PALE, labelcolor=INK)
            axes.spines[["left", "bottom"]].set(visible=True, color=PALE)
            axes.set_xlim(*self.ends)
            if is_share(name):
                axes.set_ylim(0.0, 1.02)
            (line,) = axes.plot([], [], color=COLOUR, linewidth=1.6)
            self.lines.append(line)
        self.update()

    def look(self, now: Snapshot) -> bool:
        """Measure the flock; whether the axes have changed, and not only the curves."""
        seen = now.measurable()
        self.times.append(now.elapsed)
        for name in self.names:
            self.values[name].append(float(OBSERVABLES[name].measure(seen)))
        return self.update()

    def update(self) -> bool:
        """Bring the curves up to date; whether an axis has had to grow."""
        grown = False
        for name, line in zip(self.names, self.lines, strict=False):
            values = np.array(self.values[name])
            line.set_data(self.times, values)
            known = values[np.isfinite(values)]
            low, high = line.axes.get_ylim()
            outside = len(known) and (known.min() < low or known.max() > high)
            if not is_share(name) and (outside or len(known) == 1):
                room = 0.25 * max(float(np.ptp(known)), 0.05 * abs(known[0]), 1e-9)
                line.axes.set_ylim(known.min() - room, known.max() + room)
                grown = True
        return grown


def is_share(name: str) -> bool:
    """Whether an observable lies between 0 and 1."""
    one = OBSERVABLES[name].range
    return isinstance(one, Range) and one.is_share
