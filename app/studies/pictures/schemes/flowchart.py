"""The algorithm as a chart, with the share of agents that takes each way."""

from __future__ import annotations

from typing import Any

from app.studies.experiment import Experiment
from app.studies.pictures.boxes import explain
from app.studies.pictures.schemes.scheme_marks import INK, ZONE_COLOURS
from app.studies.verdicts.verdict import Verdict, of

BLOCK, FILL, ASKS = "#7b5ea7", "#f4f6f9", "#fdf6e3"
HIGH, STEP = 0.62, 1.25
"""Height of a box, and from one to the next, in units of the chart."""
MIDDLE, RIGHT, EDGE = (0.0, 2.3), (5.6, 1.6), 7.7
"""The two columns of boxes: middle and half the width; and where ways lead down on the right."""


def draw_flowchart(figure: Any, experiment: Experiment, made: list[Verdict], seed: int) -> None:  # noqa: ARG001
    """Draw the chart of the first row, its ways marked with the means of its runs."""
    label = experiment.cases[0].label
    share = {
        one.measure.name: one.summary.mean
        for measure in {one.measure.name for one in made}
        for one in of(made, measure)
        if one.case.label == label and one.summary.runs
    }
    avoids = share.get("obstacle", 0.0) > 0.0
    figure.set_size_inches(10.4, 9.4 if avoids else 8.6)
    axes = figure.subplots()
    draw_chart(axes, share, avoids)
    runs = max(one.summary.runs for one in made)
    explain(
        figure, [],
        f"per cent: of agents times looks of {runs} runs of {label}, how many went that way; "
        "questions are asked from the top down;\n(3.9) to (3.12) are one another's alternatives"
        + ("; an obstacle's push is added to what they give (the thesis puts it first)" if avoids
           else ""),
    )  # fmt: skip


def draw_chart(axes: Any, share: dict[str, float], avoids: bool) -> None:
    """Draw boxes from the top down, and ways between them."""
    seen = 100.0 - share["nobody"]
    left = seen - share["repelled"]
    box(axes, MIDDLE, 0.0, "random places, headings and speeds", FILL, INK)
    down(axes, 0.0)
    box(axes, MIDDLE, -STEP, "look around: who is within $d_a$ and in view?", ASKS, INK)
    down(axes, -STEP)
    steps = [
        ("anyone noticed?", f"no: {share['nobody']:.0f} %", "keep the heading", INK,
         f"yes: {seen:.0f} %"),
        ("anyone in zor?", f"yes: {share['repelled']:.0f} %", "(3.9) away from them",
         ZONE_COLOURS[0], f"no: {left:.0f} %"),
        ("only in zoo?", f"yes: {share['aligned']:.0f} %", "(3.10) align", ZONE_COLOURS[1],
         f"no: {left - share['aligned']:.0f} %"),
        ("only in zoa?", f"yes: {share['attracted']:.0f} %", "(3.11) go there", ZONE_COLOURS[2],
         f"no: {share['both']:.0f} %"),
    ]  # fmt: skip
    y = -2.0 * STEP
    for question, way, answer, colour, rest in steps:
        box(axes, MIDDLE, y, question, ASKS, INK)
        across(axes, y, way, colour)
        box(axes, RIGHT, y, answer, FILL, colour)
        path(axes, [(RIGHT[0] + RIGHT[1], y), (EDGE, y)])
        down(axes, y, rest)
        y -= STEP
    box(axes, MIDDLE, y, "(3.12) the mean of both", FILL, BLOCK)
    path(axes, [(EDGE, -2.0 * STEP), (EDGE, y - 0.5 * STEP), (0.0, y - 0.5 * STEP)])
    down(axes, y)
    y -= STEP
    if avoids:
        box(axes, MIDDLE, y, "an obstacle ahead, within $Q^*$?", ASKS, INK)
        across(axes, y, f"yes: {share['obstacle']:.0f} %", BLOCK)
        box(axes, RIGHT, y, "(4.2) add its push (4.1)", FILL, BLOCK)
        down(axes, y, f"no: {100.0 - share['obstacle']:.0f} %")
        corner = y - 0.72 * STEP
        path(axes, [(RIGHT[0], y - 0.5 * HIGH), (RIGHT[0], corner), (0.0, corner)])
        y -= STEP
    box(axes, MIDDLE, y, "turn by at most $\\theta_{max}\\,\\tau$, fly for $\\tau$", FILL, INK)
    back, side = -MIDDLE[1] - 0.7, -MIDDLE[1]
    path(axes, [(side, y), (back, y), (back, -STEP), (side, -STEP)], arrow=True)
    axes.text(back - 0.15, 0.5 * (y - STEP), "next tick", rotation=90, ha="right", va="center")
    axes.set(xlim=(back - 0.6, EDGE + 0.3), ylim=(y - 0.6, 0.6), xticks=[], yticks=[])
    axes.grid(visible=False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def box(
    axes: Any, column: tuple[float, float], y: float, words: str, fill: str, colour: str
) -> None:
    """A box with words in a column (middle, half its width)."""
    from matplotlib.patches import FancyBboxPatch

    x, half = column
    shape = "round,pad=0,rounding_size=0.12"
    axes.add_patch(
        FancyBboxPatch((x - half, y - 0.5 * HIGH), 2.0 * half, HIGH, shape, facecolor=fill,
                       edgecolor=colour, linewidth=1.3, zorder=3)
    )  # fmt: skip
    axes.text(x, y, words, ha="center", va="center", color=colour, fontsize=10, zorder=5)


def path(axes: Any, corners: list[tuple[float, float]], arrow: bool = False) -> None:
    """A way along corners, that ends in an arrow or in another way."""
    axes.plot(*zip(*corners, strict=True), color=INK, linewidth=1.1, zorder=1)
    if arrow:
        axes.annotate(
            "", corners[-1], corners[-2], zorder=2,
            arrowprops={"arrowstyle": "-|>", "color": INK, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip


def down(axes: Any, y: float, words: str = "") -> None:
    """A way from the box at y of the middle to the one below it, with its share."""
    path(axes, [(0.0, y - 0.5 * HIGH), (0.0, y - STEP + 0.5 * HIGH)], arrow=True)
    if words:
        axes.text(0.12, y - 0.46 * STEP, words, ha="left", va="center", color=INK, fontsize=9)


def across(axes: Any, y: float, words: str, colour: str) -> None:
    """A way from a question to its answer on the right, with its share above it."""
    begin, end = MIDDLE[1], RIGHT[0] - RIGHT[1]
    path(axes, [(begin, y), (end, y)], arrow=True)
    axes.text(0.5 * (begin + end), y + 0.08, words, ha="center", va="bottom", color=colour,
              fontsize=9.5)  # fmt: skip
