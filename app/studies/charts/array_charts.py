"""Charts of arrays: values over time with how many they are of, curves, distributions, fields."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from app.studies.charts.axis_limits import measure_limits
from app.studies.charts.colour_table import COLOURS, EMPTY, PALE, RULER
from app.studies.charts.value_map import COLOUR_MAP
from app.studies.measure import UNBOUNDED, MeasureBounds

MOST_POINTS = 4000
"""Points of a line that are drawn: more are not seen, and make a file large."""
COUNT_COLOUR = RULER
SIGNED_MAP = "RdBu_r"
"""Of a field in which 0 is in the middle."""


def draw_time_series(
    axes: Any,
    time: np.ndarray,
    values: np.ndarray,
    count: np.ndarray | None = None,
    bounds: MeasureBounds = UNBOUNDED,
    level: float | None = None,
) -> None:
    """Draw values (T,) over time (T,), s, with gaps where they are NaN.

    `count` (T,): how many each value is of, on an axis of its own; `level`: a value to compare
    with. Of a long series the mean of neighbouring values is drawn.
    """
    every = -(-len(time) // MOST_POINTS)
    axes.plot(thin_out(time, every), thin_out(values, every), color=COLOURS[0], linewidth=1.1,
              gid="fs-mean", marker="." if len(time) < 3 else None)  # fmt: skip
    low, high = measure_limits(values.tolist(), bounds)
    axes.set_ylim(low, high)
    if level is not None and math.isfinite(level):
        draw_level(axes, level)
    if count is not None:
        beside = axes.twinx()
        beside.plot(thin_out(time, every), thin_out(count.astype(float), every), linewidth=0.9,
                    color=COUNT_COLOUR, drawstyle="steps-mid")  # fmt: skip
        beside.set_ylim(0.0, 1.08 * max(float(count.max(initial=1)), 1.0))
        beside.set_ylabel("individuals seen", color=COUNT_COLOUR)
        beside.grid(False)
        beside.spines["right"].set_visible(True)
        axes.set_zorder(beside.get_zorder() + 1)
        axes.patch.set_visible(False)


def thin_out(values: np.ndarray, every: int) -> np.ndarray:
    """The mean of every so many neighbouring values, those that are no numbers left out.

    >>> thin_out(np.array([1.0, 3.0, np.nan, np.nan, 5.0]), 2).tolist()
    [2.0, nan, 5.0]
    """
    if every == 1:
        return values
    parts = np.pad(values, (0, -len(values) % every), constant_values=np.nan).reshape(-1, every)
    many = np.isfinite(parts).sum(axis=1)
    sums = np.where(np.isfinite(parts), parts, 0.0).sum(axis=1)
    return np.where(many > 0, sums / np.maximum(many, 1), np.nan)


def draw_level(axes: Any, level: float) -> None:
    """Draw a value to compare with as a broken line."""
    axes.axhline(level, color=RULER, linewidth=1.0, linestyle=(0, (4, 3)))


def draw_curve(
    axes: Any,
    x: np.ndarray,
    y: np.ndarray,
    error: np.ndarray | None = None,
    level: float | None = None,
) -> None:
    """Draw points (K,) on a line, with a band of `error` (K,) on either side."""
    if error is not None:
        axes.fill_between(x, y - error, y + error, color=COLOURS[0], alpha=0.18, linewidth=0)
    axes.plot(x, y, color=COLOURS[0], marker="o", markersize=3, gid="fs-mean")
    if level is not None and math.isfinite(level):
        draw_level(axes, level)


def draw_distribution(axes: Any, edges: np.ndarray, share: np.ndarray) -> None:
    """Draw the share of values in each bin, (B,), between edges (B + 1,)."""
    axes.stairs(share, edges, fill=True, color=PALE, gid="fs-point")
    axes.stairs(share, edges, color=COLOURS[0], linewidth=1.1)
    axes.set_ylim(bottom=0.0)


def draw_points(axes: Any, x: np.ndarray, y: np.ndarray) -> None:
    """Draw pairs of values as faint dots."""
    axes.plot(x, y, "o", color=COLOURS[0], alpha=0.3, markersize=3, markeredgewidth=0,
              rasterized=len(x) > 1000)  # fmt: skip


def draw_field(
    axes: Any,
    edges: np.ndarray,
    field: np.ndarray,
    label: str,
    *,
    is_signed: bool = False,
) -> None:
    """Draw a field (B, B) over a square whose cells have these edges (B + 1,), with its colours.

    `is_signed`: with 0 in the middle of the colours. Cells without a value are grey. An arrow in
    the middle shows where the individual heads.
    """
    finite = field[np.isfinite(field)]
    most = float(np.quantile(np.abs(finite), 0.99)) if len(finite) else 1.0
    low = -(most or 1.0) if is_signed else 0.0
    mesh = axes.pcolormesh(
        edges, edges, np.ma.masked_invalid(field), cmap=SIGNED_MAP if is_signed else COLOUR_MAP,
        vmin=low, vmax=most or 1.0, rasterized=True,
    )  # fmt: skip
    axes.set_facecolor(EMPTY)
    axes.grid(False)
    axes.set_aspect("equal")
    reach = float(edges[-1])
    axes.annotate(
        "", (0.0, 0.09 * reach), (0.0, -0.09 * reach),
        arrowprops={"arrowstyle": "-|>", "color": "white", "linewidth": 1.6, "shrinkA": 0,
                    "shrinkB": 0, "path_effects": outline()},
    )  # fmt: skip
    axes.figure.colorbar(mesh, ax=axes, label=label, shrink=0.85)


def outline() -> list[Any]:
    """A dark edge about what is white, so that it is seen on every colour."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=3.2, foreground="black")]


def draw_ranking(
    axes: Any, names: list[str], values: np.ndarray, errors: np.ndarray, is_sure: np.ndarray
) -> None:
    """Draw values with their errors, largest on top, those that are not sure pale."""
    place = np.arange(len(values))[::-1]
    for sure, colour in ((True, COLOURS[0]), (False, PALE)):
        rows = is_sure == sure
        axes.errorbar(
            values[rows], place[rows], xerr=np.nan_to_num(errors[rows]), fmt="o", color=colour,
            markersize=4, linewidth=1.2, label="resolved" if sure else "not resolved",
        )  # fmt: skip
    axes.axvline(0.0, color=RULER, linewidth=1.0, linestyle=(0, (4, 3)))
    step = max(1, -(-len(names) // 25))
    axes.set_yticks(place[::step], names[::step])
    axes.set_ylim(-0.7, len(names) - 0.3)
    axes.legend(loc="lower right", fontsize=9)
