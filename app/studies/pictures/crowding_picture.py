"""How fast crowded particles get on over their packing, beside a straight line."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.pictures.boxes import came, explain
from app.studies.verdicts.verdict import Verdict, of

DOTS, LINE = "#2166ac", "#c0392b"


def draw_crowding(figure: Any, made: list[Verdict]) -> None:
    """A dot for each run, and the line of best fit that is 1 where there is room."""
    figure.set_size_inches(7.4, 5.0)
    axes = figure.subplots()
    x = np.concatenate([came(one.values) for one in of(made, "packing")])
    y = np.concatenate([came(one.values) for one in of(made, "speed")])
    slope = float((x * (1.0 - y)).sum() / (x * x).sum())
    line = np.array([0.0, 1.15 * float(x.max())])
    axes.plot(
        line, 1.0 - slope * line, color=LINE, linewidth=1.4, label=f"1 - packing / {1 / slope:.2f}"
    )
    axes.plot(x, y, "o", color=DOTS, markersize=4.5, alpha=0.6, label="runs")
    axes.set_xlim(0.0, line[1])
    axes.set_ylim(0.0, 1.05)
    axes.set_xlabel("packing")
    axes.set_ylabel("velocity along the heading, $v / v_0$")
    axes.legend()
    explain(figure, [], "line: least squares through 1 at no packing")
