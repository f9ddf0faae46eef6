"""Convergence times with and without something: pairs of boxes for each size of flock."""

from __future__ import annotations

from typing import Any

from app.studies.pictures.boxes import WORDS, box, explain
from app.studies.verdicts.verdict import Verdict, name

COLOURS = ("#c0392b", "#2166ac", "#3c434b", "#b07d12")
"""With in red and without in blue, as the paper's figure 6."""
STEP = 0.34


def draw_pairs(figure: Any, made: list[Verdict]) -> None:
    """Draw the boxes, one group per size of flock."""
    from matplotlib.patches import Patch

    figure.set_size_inches(7.2, 5.0)
    axes = figure.subplots()
    cases = [one.case for one in made]
    sizes = sorted({case.agents for case in cases})
    values = list(dict.fromkeys(case.value for case in cases))
    colour = dict(zip(values, COLOURS, strict=False))
    for one in made:
        case = one.case
        k = values.index(case.value)
        x = sizes.index(case.agents) + STEP * (k - (len(values) - 1) / 2)
        box(axes, x, one.values, colour[case.value], 0.8 * STEP)
    axes.set_xticks(range(len(sizes)), [f"N = {n}" for n in sizes])
    axes.tick_params(axis="x", length=0)
    axes.set_xlim(-0.6, len(sizes) - 0.4)
    axes.set_ylim(bottom=0)
    axes.set_ylabel("$k_{con}$ / ticks")
    parameter = cases[0].sweep.parameter.replace("_", " ") if cases[0].sweep else ""
    signs = [
        Patch(facecolor=colour[v] + "40", edgecolor=colour[v], label=f"{parameter} {name(v)}")
        for v in values
    ]
    explain(figure, signs, WORDS)
