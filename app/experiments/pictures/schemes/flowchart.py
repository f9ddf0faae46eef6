"""The algorithm as a chart, with the share of agents that takes each way."""

from __future__ import annotations

from typing import Any

from app.experiments.experiment import Experiment
from app.experiments.pictures.boxes import explain
from app.experiments.pictures.schemes.marks import INK, ZONE_COLOURS, word
from app.experiments.verdicts.verdict import Verdict, of

BLOCK, FILL, ASKS = "#7b5ea7", "#f4f6f9", "#fdf6e3"
WIDE, HIGH = 3.0, 0.62
"""Of a box, in units of the chart."""


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
    farther = seen - share["repelled"]
    rows = [("random places, headings and speeds", FILL, INK),
            ("look around: who is within d_a and in view?", ASKS, INK)]  # fmt: skip
    y = 0.0
    for words, fill, colour in rows:
        box(axes, 0.0, y, words, fill, colour)
        y -= 1.25
        down(axes, 0.0, y + 1.25, y)
    steps = [
        ("anyone noticed?", f"no: {share['nobody']:.0f} %", "keep the heading", INK, seen),
        ("anyone in zor?", f"yes: {share['repelled']:.0f} %", "(3.9) away from them",
         ZONE_COLOURS[0], farther),
        ("only in zoo?", f"yes: {share['aligned']:.0f} %", "(3.10) align", ZONE_COLOURS[1],
         farther - share["aligned"]),
        ("only in zoa?", f"yes: {share['attracted']:.0f} %", "(3.11) go there", ZONE_COLOURS[2],
         share["both"]),
    ]  # fmt: skip
    for question, way, answer, colour, left in steps:
        box(axes, 0.0, y, question, ASKS, INK)
        across(axes, y, way, colour)
        box(axes, 5.1, y, answer, FILL, colour)
        y -= 1.25
        down(axes, 0.0, y + 1.25, y, f"{left:.0f} %")
    box(axes, 0.0, y, "(3.12) the mean of both", FILL, BLOCK)
    join = y - 0.62
    axes.plot([7.2, 7.2], [-2.5, join], color=INK, linewidth=1.1, zorder=1)
    for k in range(4):
        axes.plot(
            [5.1 + 0.5 * WIDE, 7.2], [-2.5 - 1.25 * k] * 2, color=INK, linewidth=1.1, zorder=1
        )
    axes.plot([7.2, 0.0], [join, join], color=INK, linewidth=1.1, zorder=1)
    last = y
    y -= 1.25
    down(axes, 0.0, last, y)
    if avoids:
        box(axes, 0.0, y, "an obstacle ahead within Q*?", ASKS, INK)
        across(axes, y, f"yes: {share['obstacle']:.0f} %", BLOCK)
        box(axes, 5.1, y, "(4.2) add its push (4.1)", FILL, BLOCK)
        axes.plot([5.1, 5.1], [y - 0.5 * HIGH, y - 0.72], color=INK, linewidth=1.1, zorder=1)
        axes.plot([5.1, 0.0], [y - 0.72, y - 0.72], color=INK, linewidth=1.1, zorder=1)
        y -= 1.25
        down(axes, 0.0, y + 1.25, y, f"{100.0 - share['obstacle']:.0f} %", 0.2)
    box(axes, 0.0, y, "turn by at most theta_max tau, fly for tau", FILL, INK)
    axes.plot([-0.5 * WIDE - 0.55, -3.4], [y, y], color=INK, linewidth=1.1, zorder=1)
    axes.plot([-3.4, -3.4], [y, -1.25], color=INK, linewidth=1.1, zorder=1)
    axes.annotate("", (-0.5 * WIDE - 0.62, -1.25), (-3.4, -1.25), zorder=1,
                  arrowprops={"arrowstyle": "-|>", "color": INK, "shrinkA": 0, "shrinkB": 0})  # fmt: skip
    axes.text(-3.55, 0.5 * (y - 1.25), "next tick", rotation=90, ha="right", va="center", color=INK)
    axes.set(xlim=(-4.1, 7.5), ylim=(y - 0.6, 0.6), xticks=[], yticks=[])
    axes.grid(visible=False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def box(axes: Any, x: float, y: float, words: str, fill: str, colour: str) -> None:
    """A box with words about a place."""
    axes.text(
        x, y, words, ha="center", va="center", color=colour, fontsize=10, zorder=5,
        bbox={"boxstyle": "round,pad=0.55", "facecolor": fill, "edgecolor": colour,
              "linewidth": 1.2},
    )  # fmt: skip


def down(
    axes: Any, x: float, above: float, below: float, words: str = "", near: float = 0.5
) -> None:
    """A way from a box to the one below it, with its share."""
    axes.annotate(
        "", (x, below + 0.5 * HIGH), (x, above - 0.5 * HIGH), zorder=1,
        arrowprops={"arrowstyle": "-|>", "color": INK, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip
    if words:
        at = (x, below + 0.5 * HIGH + near * (above - below - HIGH))
        word(axes, at, f"no: {words}", INK, (9, 0), 9.0, ha="left")  # type: ignore[arg-type]


def across(axes: Any, y: float, words: str, colour: str) -> None:
    """A way from a question to its answer on the right, with its share."""
    axes.annotate(
        "", (5.1 - 0.5 * WIDE + 0.1, y), (1.0, y), zorder=1,
        arrowprops={"arrowstyle": "-|>", "color": INK, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip
    word(axes, (2.6, y), words, colour, (0, 0), 9.5)  # type: ignore[arg-type]
