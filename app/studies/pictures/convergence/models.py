"""Convergence times of models: a panel per size of flock, measured beside published."""

from __future__ import annotations

from typing import Any

from app.studies.pictures.boxes import WORDS, box, explain
from app.studies.verdicts.verdict import Verdict

MEASURED = "#2166ac"
DIFFERS = "#b07d12"
PUBLISHED = "#3c434b"
WIDTH = 0.36


def draw_models(figure: Any, made: list[Verdict]) -> None:
    """Draw the panels."""
    sizes = sorted({one.case.agents for one in made})
    figure.set_size_inches(4.3 * len(sizes) + 0.6, 5.2)
    panels = figure.subplots(1, len(sizes), sharey=True, squeeze=False)[0]
    for axes, agents in zip(panels, sizes, strict=True):
        rows = [one for one in made if one.case.agents == agents]
        for x, one in enumerate(rows):
            row = one.published
            colour = DIFFERS if one.word == "differs" else MEASURED
            box(axes, x - 0.21, one.values, colour, WIDTH)
            if row:
                published(axes, x + 0.21, row.mean, row.quartiles)
        axes.set_yscale("log")
        axes.set_title(f"N = {agents}")
        axes.set_xticks(range(len(rows)), [one.case.spec.model.upper() for one in rows])
        axes.tick_params(axis="x", length=0, labelsize=9)
        axes.set_xlim(-0.6, len(rows) - 0.4)
    panels[0].set_ylabel("$k_{con}$ / ticks")
    signs_below(figure, any(r.published for r in made))


def published(axes: Any, x: float, mean: float | None, quartiles: tuple | None) -> None:
    """Draw the published quartiles as an open box with the mean as a diamond."""
    if quartiles:
        low, middle, high = quartiles
        half = WIDTH / 2
        axes.fill_between([x - half, x + half], low, high, facecolor="#ffffff", edgecolor=PUBLISHED)
        axes.plot([x - half, x + half], [middle, middle], color=PUBLISHED, linewidth=2.2)
    if mean is not None:
        axes.plot([x], [mean], marker="D", markersize=4.5, color=PUBLISHED, linestyle="none")


def signs_below(figure: Any, with_published: bool) -> None:
    """Say what is what, below the panels."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    signs: list[Any] = [Patch(facecolor=MEASURED + "40", edgecolor=MEASURED, label="measured")]
    if with_published:
        signs += [
            Patch(facecolor=DIFFERS + "40", edgecolor=DIFFERS, label="measured, differs"),
            Patch(facecolor="white", edgecolor=PUBLISHED, label="published quartiles"),
            Line2D([], [], marker="D", color=PUBLISHED, linestyle="none", label="published mean"),
        ]
    explain(figure, signs, WORDS)
