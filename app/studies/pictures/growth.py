"""How measures go with the number of agents, on logarithmic scales: a line for each label."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.pictures.boxes import came, explain
from app.studies.verdicts.verdict import Verdict, of

COLOURS = ("#2166ac", "#c0392b", "#1b7837", "#e08214")


def draw_growth(figure: Any, made: list[Verdict]) -> None:
    """A panel for each measure, with the slope of each line."""
    names = list(dict.fromkeys(one.measure.name for one in made if not one.measure.words))
    labels = list(dict.fromkeys(one.case.label for one in made))
    figure.set_size_inches(4.6 * len(names) + 0.4, 4.4)
    for axes, name in zip(figure.subplots(1, len(names), squeeze=False)[0], names, strict=True):
        for label, colour in zip(labels, COLOURS * len(labels), strict=False):
            rows = [one for one in of(made, name) if one.case.label == label]
            n = np.array([one.case.agents for one in rows])
            mean = np.array([one.summary.mean for one in rows])
            slope = np.polyfit(np.log(n), np.log(mean), 1)[0]
            words = f"{label}: $N^{{{slope:.2f}}}$"
            axes.plot(n, mean, "o-", color=colour, linewidth=1.8, markersize=5, label=words)
            for row in rows:
                there = came(row.values)
                axes.plot(np.full(there.size, row.case.agents), there, ".", color=colour, alpha=0.3)
        first = of(made, name)[0]
        unit = "" if first.unit == "1" else f" / {first.unit}"
        axes.set_xscale("log")
        axes.set_yscale("log")
        sizes = sorted({one.case.agents for one in made})
        axes.set_xticks(sizes, [str(n) for n in sizes])
        axes.minorticks_off()
        axes.set_xlabel("N")
        axes.set_ylabel(f"{first.measure.symbol}{unit}")
        axes.set_title(first.measure.title, loc="left")
        axes.legend()
    explain(figure, [], "circles: means, dots: runs; the power is that of the line of best fit")
