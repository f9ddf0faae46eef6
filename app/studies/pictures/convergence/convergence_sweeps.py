"""Mean convergence time over the values of a parameter: a panel per sweep, a line per size."""

from __future__ import annotations

from typing import Any

from app.studies.pictures.boxes import explain
from app.studies.verdicts.verdict import Verdict, sweeps_of

COLOURS = ("#7fb3d5", "#2166ac", "#0b2545", "#b07d12", "#c0392b")
MARKERS = ("o", "s", "^", "D", "v")
SYMBOLS = {"p1": "$p_1$", "p2": "$p_2$"}
LINEAR_TO = 0.01
"""The logarithmic axis is linear up to here where it has to show 0."""


def draw_sweeps(figure: Any, made: list[Verdict]) -> None:
    """Draw the panels."""
    from matplotlib.ticker import LogLocator, ScalarFormatter

    found = sweeps_of(made)
    sweeps = list({id(sweep): sweep for sweep, _, _ in found}.values())
    figure.set_size_inches(5.2 * len(sweeps), 4.8)
    panels = figure.subplots(1, len(sweeps), squeeze=False)[0]
    for axes, sweep in zip(panels, sweeps, strict=True):
        lines = [(agents, points) for one, agents, points in found if one is sweep]
        for k, (agents, points) in enumerate(lines):
            axes.errorbar(
                [float(p.case.value or 0.0) for p in points],
                [p.summary.mean for p in points],
                yerr=[2.0 * p.summary.standard_error for p in points],
                color=COLOURS[k % len(COLOURS)],
                marker=MARKERS[k % len(MARKERS)],
                markersize=5,
                linewidth=1.6,
                capsize=2.5,
                label=f"N = {agents}",
            )
        values = [float(value) for value in sweep.values]
        axes.set_xscale("symlog" if min(values) <= 0.0 else "log", **linear(values))
        axes.set_xticks(values, [f"{value:g}" for value in values], fontsize=9)
        axes.set_xlabel(SYMBOLS.get(sweep.parameter, sweep.parameter))
        fixed = ", ".join(f"{SYMBOLS.get(p, p)} = {v:g}" for p, v in sweep.fixed.items())
        axes.set_title(f"{SYMBOLS.get(sweep.parameter, sweep.parameter)}, with {fixed}")
        if steep(lines):
            axes.set_yscale("log")
            axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axes.yaxis.set_major_formatter(ScalarFormatter())
        axes.minorticks_off()
    panels[0].set_ylabel("mean $k_{con}$ / ticks")
    explain(figure, panels[0].get_legend_handles_labels()[0], "bars: two standard errors")


def steep(lines: list[tuple[int, list[Verdict]]]) -> bool:
    """Whether the means of any line span so much that a logarithmic axis shows them better."""
    means = [[p.summary.mean for p in points] for _, points in lines]
    return any(max(line) > 4.0 * min(line) for line in means)


def linear(values: list[float]) -> dict[str, float]:
    """The linear part of the axis, where 0 is among the values."""
    return {"linthresh": LINEAR_TO, "linscale": 0.5} if min(values) <= 0.0 else {}
