"""The picture of a question: every result, mean and interval, and the curve of a sweep beside them.

It takes some tenths of a second, in which no other thread draws: better in a process of its own.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any, Literal, get_args

from app.classroom.collect.class_curve import ClassCurve
from app.classroom.collect.collection import Collection
from app.classroom.collect.hand_in import Point, ResultGroup
from app.classroom.collect.question import Question
from app.figure import NAMED, new_figure, save_figure
from app.studies.charts.colour_table import COLOURS
from app.studies.charts.mean_line import draw_mean_bars, draw_mean_line, draw_missing
from app.studies.run_axes import AGENTS
from worlds.input_error import unknown

Format = Literal["svg", "png", "pdf"]
FORMATS: tuple[Format, ...] = get_args(Format)
CLASS, CURVE = COLOURS[0], COLOURS[6]


def picture(collection: Collection, kind: str) -> bytes:
    """The picture as SVG, PNG or PDF; the same results make the same bytes. Raises InputError."""
    if kind not in FORMATS:
        raise unknown("kind of picture", kind, FORMATS)
    with new_figure(NAMED) as figure:
        figure.set_size_inches(7.2, 4.8)
        draw(figure.subplots(), collection)
        title = f"{collection.question.title}\n{collection.told()}"
        figure.suptitle(title, x=0.01, ha="left", wrap=True)
        drawn = io.BytesIO()
        save_figure(figure, drawn, kind)
    return drawn.getvalue()


def draw(axes: Any, collection: Collection) -> None:
    """Draw the curve, then the results, then their means on top."""
    question, counted, curve = collection.question, collection.counted, collection.curve
    if curve is not None:
        draw_curve(axes, curve)
    for points, face, words in (
        ([one for one in counted if not one.differs], CLASS, "a result"),
        ([one for one in counted if one.differs], "none", "not of the class's scene"),
    ):
        draw_points(axes, points, face, words)
    draw_means(axes, [group for group in collection.groups() if group.runs > 1])
    draw_absent(axes, counted)
    if collection.is_log(() if curve is None else curve.values):
        axes.set_xscale("log")
    along, up = collection.axis_limits(() if curve is None else curve.groups)
    axes.set_xlim(*along)
    axes.set_ylim(*up)
    axes.set_xlabel(parameter_label(question))
    unit = "" if question.result_unit in ("1", "ticks") else f" ({question.result_unit})"
    axes.set_ylabel(question.result_words + unit, wrap=True)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=9)


def parameter_label(question: Question) -> str:
    """What stands along the axis of the parameter."""
    if question.parameter == AGENTS:
        return "agents"
    unit = "" if question.unit == "1" else f" ({question.unit})"
    return f"{question.parameter_words} {question.symbol}{unit}"


def draw_curve(axes: Any, curve: ClassCurve) -> None:
    """A line with its 95 % band."""
    like = f", {curve.differs[0]}" if curve.differs else ""
    words = f"sweep {curve.name}, {curve.runs} runs{like}"
    summaries = [group.summary for group in curve.groups]
    draw_mean_line(axes, curve.values, summaries, CURVE, words, linewidth=1.2)


def draw_points(axes: Any, points: Sequence[Point], face: str, words: str) -> None:
    """Results, one by one."""
    there = [one for one in points if one.result is not None]
    if there:
        axes.plot(
            [one.value for one in there], [one.result for one in there], "o", color=CLASS,
            markerfacecolor=face, markersize=4.5, alpha=0.6, zorder=4, linestyle="", label=words,
            clip_on=False,
        )  # fmt: skip


def draw_means(axes: Any, groups: Sequence[ResultGroup]) -> None:
    """Means with their 95 % intervals."""
    if groups:
        draw_mean_bars(
            axes, [group.value for group in groups], [group.summary for group in groups],
            COLOURS[1], "mean and 95 % interval", marker="_", markersize=9, markeredgewidth=1.6,
            elinewidth=1.2, capsize=3, linestyle="", zorder=2.5,
        )  # fmt: skip


def draw_absent(axes: Any, points: Sequence[Point]) -> None:
    """Mark, at the foot, where it did not happen or a run failed."""
    gave_up, failed = (
        [point.value for point in points if point.status == status]
        for status in ("gave-up", "failed")
    )
    draw_missing(axes, gave_up, failed, ("it did not happen here", "runs failed here"))
