"""The picture of a question: every result, mean and interval, and the curve of a sweep beside them.

It takes some tenths of a second and sets the style of matplotlib meanwhile: for a process, not for
a thread beside others that draw.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any, Literal, get_args

from app.classroom.collect.class_curve import ClassCurve
from app.classroom.collect.collection import Collection
from app.classroom.collect.hand_in import Point
from app.classroom.collect.question import Question
from app.classroom.collect.result_groups import ResultGroup
from app.figure import LOOK, save_figure
from app.studies.sweeps.pictures.mean_lines import CENSORED, COLOURS, FAILED
from app.viewer.panels.dials import plain
from worlds.input_error import unknown

Format = Literal["svg", "png", "pdf"]
FORMATS: tuple[Format, ...] = get_args(Format)
CLASS, CURVE = COLOURS[0], COLOURS[6]
FOOT = 0.02
"""Where on the height of the picture runs are marked in which it did not happen."""


def picture(collection: Collection, kind: str, curve: ClassCurve | None = None) -> bytes:
    """The picture as SVG, PNG or PDF; the same results make the same bytes. Raises InputError."""
    if kind not in FORMATS:
        raise unknown("kind of picture", kind, FORMATS)
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with matplotlib.rc_context(LOOK):  # type: ignore[arg-type]
        figure: Any = Figure(figsize=(7.2, 4.8), layout="constrained")
        FigureCanvasAgg(figure)
        draw(figure.subplots(), collection, curve)
        title = f"{collection.question.title}\n{collection.told()}"
        figure.suptitle(title, x=0.01, ha="left", wrap=True, parse_math=False)
        drawn = io.BytesIO()
        save_figure(figure, drawn, kind)
    return drawn.getvalue()


def draw(axes: Any, collection: Collection, curve: ClassCurve | None) -> None:
    """Draw the curve, then the results, then their means on top."""
    question, counted = collection.question, collection.counted
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
    axes.set_xlabel(labelled(question), parse_math=False)
    unit = "" if question.result_unit in ("1", "ticks") else f" ({question.result_unit})"
    axes.set_ylabel(question.result_words + unit, parse_math=False, wrap=True)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=9)


def labelled(question: Question) -> str:
    """What stands along the axis of the parameter."""
    one = question.declared
    if one is None:
        return "agents"
    unit = "" if one.unit == "1" else f" ({one.unit})"
    return f"{one.words} {plain(one.symbol)}{unit}"


def draw_curve(axes: Any, curve: ClassCurve) -> None:
    """A line with its 95 % band."""
    there = [group for group in curve.groups if group.runs]
    places = [group.value for group in there]
    like = f", {curve.differs[0]}" if curve.differs else ""
    words = f"sweep {curve.name}, {curve.runs} runs{like}"
    axes.plot(places, [group.mean for group in there], color=CURVE, lw=1.2, label=text(words))
    low = [group.mean - group.half for group in there]
    high = [group.mean + group.half for group in there]
    axes.fill_between(places, low, high, color=CURVE, alpha=0.18, linewidth=0)


def draw_points(axes: Any, points: Sequence[Point], face: str, words: str) -> None:
    """Results, one by one."""
    there = [one for one in points if one.result is not None]
    if there:
        axes.plot(
            [one.value for one in there], [one.result for one in there], "o", color=CLASS,
            markerfacecolor=face, markersize=4.5, alpha=0.6, zorder=4, linestyle="", label=words,
        )  # fmt: skip


def draw_means(axes: Any, groups: Sequence[ResultGroup]) -> None:
    """Means with their 95 % intervals."""
    if groups:
        axes.errorbar(
            [group.value for group in groups],
            [group.mean for group in groups],
            yerr=[group.half for group in groups],
            fmt="_", color=COLOURS[1], markersize=9, markeredgewidth=1.6, elinewidth=1.2,
            capsize=3, linestyle="", label="mean and 95 % interval", zorder=2.5,
        )  # fmt: skip


def draw_absent(axes: Any, points: Sequence[Point]) -> None:
    """Mark, at the foot, where it did not happen or a run failed."""
    for status, sign, colour, words in (
        ("gave-up", "v", CENSORED, "it did not happen here"),
        ("failed", "x", FAILED, "runs failed here"),
    ):
        places = sorted({point.value for point in points if point.status == status})
        if places:
            foot = axes.get_xaxis_transform()
            style = {"linestyle": "", "clip_on": False, "transform": foot}
            axes.plot(places, [FOOT] * len(places), marker=sign, color=colour, label=words, **style)


def text(words: str) -> str:
    """Words of which nothing is taken for mathematics."""
    return words.replace("$", r"\$")
