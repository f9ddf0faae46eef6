"""Order over noise, a line for each model and size, and what else was measured beside it.

Rows beside the sweeps are drawn over their density; where all have one density, as boxes.
"""

from __future__ import annotations

from typing import Any

from app.studies.pictures.boxes import WORDS, box, explain
from app.studies.verdicts.verdict import Verdict, of, sweeps_of

COLOURS = ("#2166ac", "#b07d12", "#1f9d63", "#c0392b", "#0b2545", "#7a4ea3")
MARKERS = ("s", "+", "x", "^", "o", "D")
WIDTH = 0.4
SYMBOLS = {"eta": "$\\eta$", "order": "order", "binder": "Binder cumulant $G$"}


def draw_ordering(figure: Any, made: list[Verdict]) -> None:
    """A panel for each measure and model of the sweeps, and one for the rows."""
    measures = list(dict.fromkeys(one.measure.name for one in made))
    swept = [(sweep.model, name) for name in measures for sweep, _, _ in sweeps_of(of(made, name))]
    shown = list(dict.fromkeys(swept))
    rows = [one for one in of(made, measures[0]) if one.case.row and one.case.spec.size]
    number = len(shown) + bool(rows)
    lines = 1 if number < 4 else 2
    figure.set_size_inches(5.4 * (number / lines), 4.4 * lines + 0.4)
    panels = list(figure.subplots(lines, -(-number // lines), squeeze=False).ravel())
    for axes, (model, name) in zip(panels, shown, strict=False):
        draw_sweeps(axes, [one for one in of(made, name) if one.case.spec.model == model])
        axes.set_ylabel(SYMBOLS.get(name, name))
        if len({one for one, _ in shown}) > 1:
            axes.set_title(model, loc="left")
    if shown:
        explain(figure, panels[0].get_legend_handles_labels()[0], "bars: two standard errors")
    if rows and len({round(density(row), 6) for row in rows}) > 1:
        draw_densities(panels[-1], rows)
    elif rows:
        draw_boxes(panels[-1], rows)
        explain(figure, [], WORDS)


def draw_sweeps(axes: Any, made: list[Verdict]) -> None:
    """A line for each size of flock."""
    for k, (sweep, agents, points) in enumerate(sweeps_of(made)):
        draw_line(axes, k, [float(p.case.value or 0.0) for p in points], points, f"N = {agents}")
        axes.set_xlabel(SYMBOLS.get(sweep.parameter, sweep.parameter))
    if min(one.summary.mean for one in made) < 0.0:
        axes.axhline(0.0, color="#7a828c", linewidth=1.0)


def draw_densities(axes: Any, rows: list[Verdict]) -> None:
    """The rows over their density, a line for each model."""
    models = list(dict.fromkeys(row.case.spec.model for row in rows))
    for k, model in enumerate(models):
        points = sorted((row for row in rows if row.case.spec.model == model), key=density)
        draw_line(axes, k, [density(row) for row in points], points, model)
    if len(models) > 1:
        axes.legend()
        axes.set_xscale("log")
    axes.set_xlabel("density")
    axes.set_ylabel("order")


def draw_boxes(axes: Any, rows: list[Verdict]) -> None:
    """The runs of each row."""
    for x, row in enumerate(rows):
        box(axes, x, row.values, COLOURS[x % len(COLOURS)], WIDTH)
    axes.set_xticks(range(len(rows)), [row.case.label for row in rows])
    axes.set_ylabel("order")


def density(row: Verdict) -> float:
    """Agents per unit of area or volume."""
    spec = row.case.spec
    sides = spec.size if isinstance(spec.size, tuple) else (spec.size or 1.0,) * (spec.dim or 2)
    volume = 1.0
    for side in sides:
        volume *= side
    return spec.count / volume


def draw_line(axes: Any, k: int, x: list[float], points: list[Verdict], label: str) -> None:
    """Means with two standard errors."""
    axes.errorbar(
        x,
        [p.summary.mean for p in points],
        yerr=[2.0 * p.summary.standard_error for p in points],
        color=COLOURS[k % len(COLOURS)],
        marker=MARKERS[k % len(MARKERS)],
        markersize=5,
        linewidth=1.3,
        capsize=2.5,
        label=label,
    )
