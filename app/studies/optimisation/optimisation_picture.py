"""How a search has gone: every point that it has tried, the best so far, and the front."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from app.figure import ENDINGS, NAMED, new_figure, write_figure
from app.studies.charts.axis_limits import column_bounds, measure_limits
from app.studies.charts.colour_table import COLOURS, PALE
from app.studies.charts.mean_line import draw_missing, interval_sides
from app.studies.optimisation.evaluations import EvaluatedPoint
from app.studies.optimisation.optimisation_result import OptimisationResult
from app.studies.optimisation.study import SearchGoal, Study
from app.studies.search import TITLES
from worlds.file_writer import demand_writable
from worlds.number_text import counted

TRIED, BEST, DEFAULT = PALE, COLOURS[0], COLOURS[1]


def draw(
    study: Study,
    course: list[EvaluatedPoint],
    answer: OptimisationResult,
    path: Path,
    overwrite: bool = True,
) -> None:
    """Draw the convergence, and of two objectives the front: PNG, SVG or PDF. Raises InputError."""
    demand_writable("picture", path, overwrite, ENDINGS)
    with new_figure(NAMED) as figure:
        goals = study.goals
        figure.set_size_inches(7.2, 4.6 if len(goals) == 1 else 2.9 * len(goals) + 3.6)
        rows = len(goals) + (len(goals) > 1)
        ratios = [1.0] * len(goals) if len(goals) == 1 else [1.5, *[1.0] * len(goals)]
        panels = figure.subplots(rows, squeeze=False, height_ratios=ratios)[:, 0]
        if len(goals) > 1:
            draw_front(panels[0], study, course, answer)
        for k, goal in enumerate(goals):
            draw_course(panels[k - len(goals)], goal, k, course, answer)
        algorithm = TITLES[study.file.search.algorithm]
        caption = f"{algorithm}, {counted(answer.evaluations, 'point')} of {answer.seeds} seeds"
        figure.suptitle(f"{study.title}\n{caption}", x=0.01, ha="left", wrap=True)
        write_figure(figure, path)


def draw_course(
    panel: Any, goal: SearchGoal, k: int, course: list[EvaluatedPoint], answer: OptimisationResult
) -> None:
    """Draw what each point is worth in the order of the search, and the best so far."""
    numbers = np.arange(1, len(course) + 1)
    chosen = answer.best[0] if len(answer.best) == 1 else None
    values = np.array([point.means[k] if point.is_good else np.nan for point in course])
    panel.plot(numbers, values, "o", color=TRIED, markersize=4, label="a point, mean of the seeds")
    reached = np.isfinite(values)
    if reached.any():
        running = np.fmin.accumulate(goal.sign * values)
        panel.step(numbers, goal.sign * running, where="post", color=BEST, label="best so far")
    bad = numbers[~reached]
    draw_missing(panel, bad.tolist(), (), ("not allowed, or without a value", ""))
    searched = answer.default.on_search[k]
    if searched is not None:
        panel.axhline(searched, color=DEFAULT, linewidth=1.0, label="the default, same seeds")
    drawn_values = [*values[reached], *([] if searched is None else [searched])]
    ends: list[float] = []
    for point, colour, words in (
        (answer.default, DEFAULT, "default"),
        (chosen, COLOURS[2], "best"),
    ):
        mean = point.means[k] if point is not None else None
        if mean is not None:
            panel.errorbar(
                [1.04 * len(course) + 1], [mean.value],
                yerr=interval_sides([mean.value], [mean.interval]), fmt="D",
                color=colour, markersize=5, capsize=3, label=f"the {words}, fresh seeds",
            )  # fmt: skip
            drawn_values.append(mean.value)
            ends += mean.interval
    if is_wide(values[reached]):
        panel.set_yscale("log")
    else:
        panel.set_ylim(*measure_limits(drawn_values, column_bounds(goal.column), ends))
    panel.set_xlabel("points evaluated")
    panel.set_ylabel(f"{goal.name} ({goal.aim} wanted)")
    if k == 0:
        panel.legend(fontsize=9)


def is_wide(values: np.ndarray) -> bool:
    """Whether a few values are so much larger than the others that these would be one line."""
    return values.size > 0 and values.min() > 0.0 and values.max() > 5.0 * np.median(values)


def draw_front(
    panel: Any, study: Study, course: list[EvaluatedPoint], answer: OptimisationResult
) -> None:
    """Draw the first two objectives against each other, with the front on fresh seeds."""
    first, second = study.goals[:2]
    tried = np.array([point.means[:2] for point in course if point.is_good]).reshape(-1, 2)
    panel.plot(*tried.T, "o", color=TRIED, markersize=4, label="points of the search")
    tried_points: list[list[float]] = tried.T.tolist()
    ends: list[list[float]] = [[], []]
    for points, colour, sign, words in (
        (answer.best, BEST, "o-", "the front, fresh seeds"),
        ([answer.default], DEFAULT, "D", "the default, fresh seeds"),
    ):
        means = [point.means[:2] for point in points]
        known_means = [
            [mean for mean in row if mean is not None] for row in means if None not in row
        ]
        if known_means:
            x, y = ([row[k].value for row in known_means] for k in (0, 1))
            across, up = ([row[k].interval for row in known_means] for k in (0, 1))
            for k, at, sides in ((0, x, across), (1, y, up)):
                tried_points[k] += at
                ends[k] += [end for interval in sides for end in interval]
            panel.errorbar(
                x, y, xerr=interval_sides(x, across), yerr=interval_sides(y, up), fmt=sign,
                color=colour, markersize=5, linewidth=1.0, elinewidth=0.8, label=words,
            )  # fmt: skip
    for k, goal, put_scale, put_limits in (
        (0, first, panel.set_xscale, panel.set_xlim),
        (1, second, panel.set_yscale, panel.set_ylim),
    ):
        if is_wide(tried[:, k]):
            put_scale("log")
        else:
            put_limits(*measure_limits(tried_points[k], column_bounds(goal.column), ends[k]))
    panel.grid(axis="both")
    panel.set_xlabel(f"{first.name} ({first.aim} wanted)")
    panel.set_ylabel(f"{second.name} ({second.aim} wanted)")
    panel.legend(fontsize=9)
