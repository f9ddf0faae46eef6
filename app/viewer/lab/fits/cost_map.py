"""The costs of a fit over its parameters as a small picture: a curve of one, a map of two."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from app.tracks.fit.fit_result import ModelFit

WIDE, TALL = 280.0, 220.0
"""Of the picture, pixels."""
LEFT, RIGHT, ABOVE, BELOW = 44.0, 8.0, 8.0, 36.0
"""Around what is drawn."""
LOW, HIGH = np.array([33.0, 113.0, 181.0]), np.array([222.0, 235.0, 247.0])
"""Colours of the least cost and of the largest, sRGB bytes."""
BEST, REGION = "#e4572e", "#e4572e"
FIGURE = 'font-size="10" fill="currentColor"'


def cost_map(fit: ModelFit) -> str:
    """An SVG of the costs at the first window: the region outlined, the best marked.

    Empty for a fit of no parameter. Of more than two parameters the first two are shown, at the
    best values of the others.
    """
    if not fit.parameters:
        return ""
    drawn = curve(fit) if len(fit.parameters) == 1 else plane(fit)
    names = ", ".join(parameter.name for parameter in fit.parameters[:2])
    label = html.escape(f"Cost of {fit.model} over {names}; the region is outlined")
    return (
        f'<svg viewBox="0 0 {WIDE:g} {TALL:g}" width="100%" role="img" aria-label="{label}">'
        f"{drawn}</svg>"
    )


def curve(fit: ModelFit) -> str:
    """The costs over one parameter, the region as a band."""
    (parameter,), costs = fit.parameters, fit.first.costs
    values = np.array(parameter.values)
    x, y = places(values, LEFT, WIDE - RIGHT), levels(np.r_[costs, fit.first.null_cost])
    null, y = y[-1], y[:-1]
    inside = x[fit.first.in_region]
    band = (
        f'<rect x="{inside.min() - 1:.1f}" y="{ABOVE:g}" width="{np.ptp(inside) + 2:.1f}" '
        f'height="{TALL - ABOVE - BELOW:g}" fill="{REGION}" opacity="0.18"/>'
    )
    line = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True) if np.isfinite(b))
    best = fit.first.best
    return (
        f'{band}<polyline points="{line}" fill="none" stroke="#2171b5" stroke-width="1.8"/>'
        f'<line x1="{LEFT:g}" x2="{WIDE - RIGHT:g}" y1="{null:.1f}" y2="{null:.1f}" '
        f'stroke="currentColor" stroke-dasharray="4 3" opacity="0.6"/>'
        f'<text x="{WIDE - RIGHT:g}" y="{null - 3:.1f}" text-anchor="end" {FIGURE}>keeps its '
        f"heading</text>"
        f'<circle cx="{x[best]:.1f}" cy="{y[best]:.1f}" r="3.5" fill="{BEST}"/>'
        f"{axis_across(parameter.name, parameter.unit, values, x)}"
        f'<text transform="translate(12 {0.5 * (TALL - BELOW):g}) rotate(-90)" '
        f'text-anchor="middle" {FIGURE}>cost, rad²</text>'
    )


def plane(fit: ModelFit) -> str:
    """The costs over the first two parameters as cells, the region outlined."""
    first, second = fit.parameters[:2]
    shape = [len(parameter.values) for parameter in fit.parameters]
    rest = np.unravel_index(fit.first.best, shape)
    chosen: tuple[Any, ...] = (slice(None), slice(None), *(int(k) for k in rest[2:]))
    costs = fit.first.costs.reshape(shape)[chosen]
    inside = fit.first.in_region.reshape(shape)[chosen]
    rows, columns = costs.shape
    wide, tall = (WIDE - LEFT - RIGHT) / rows, (TALL - ABOVE - BELOW) / columns
    finite = costs[np.isfinite(costs)]
    order = np.searchsorted(np.sort(finite), costs) / max(len(finite) - 1, 1)
    cells, edges = [], []
    for i in range(rows):
        for j in range(columns):
            if not np.isfinite(costs[i, j]):
                continue
            x, y = LEFT + i * wide, TALL - BELOW - (j + 1) * tall
            red, green, blue = LOW + min(order[i, j], 1.0) * (HIGH - LOW)
            cells.append(
                f'<rect x="{x:.1f}" y="{y:.1f}" width="{wide + 0.3:.1f}" height="{tall + 0.3:.1f}" '
                f'fill="rgb({red:.0f},{green:.0f},{blue:.0f})"><title>{first.name} '
                f"{first.values[i]:g}, {second.name} {second.values[j]:g}: cost "
                f"{costs[i, j]:.3g}</title></rect>"
            )
            if inside[i, j]:
                edges += outline(inside, i, j, x, y, wide, tall)
    i, j = int(rest[0]), int(rest[1])
    middle = LEFT + (i + 0.5) * wide, TALL - BELOW - (j + 0.5) * tall
    across, up = (np.array(parameter.values) for parameter in (first, second))
    x_ticks = LEFT + (np.arange(rows) + 0.5) * wide
    y_ticks = TALL - BELOW - (np.arange(columns) + 0.5) * tall
    return (
        f'{"".join(cells)}<path d="{"".join(edges)}" stroke="{REGION}" stroke-width="2" '
        f'fill="none"/><circle cx="{middle[0]:.1f}" cy="{middle[1]:.1f}" r="3.5" fill="{BEST}" '
        f'stroke="white"/>{axis_across(first.name, first.unit, across, x_ticks)}'
        f"{axis_up(second.name, second.unit, up, y_ticks)}"
    )


def outline(
    inside: np.ndarray, i: int, j: int, x: float, y: float, wide: float, tall: float
) -> list[str]:
    """The sides of a cell of the region beyond which the region ends, as SVG paths."""

    def is_out(a: int, b: int) -> bool:
        return not (0 <= a < inside.shape[0] and 0 <= b < inside.shape[1] and inside[a, b])

    right, low = x + wide, y + tall
    sides = {
        (i - 1, j): (x, y, x, low),
        (i + 1, j): (right, y, right, low),
        (i, j + 1): (x, y, right, y),
        (i, j - 1): (x, low, right, low),
    }
    return [
        f"M{a:.1f} {b:.1f}L{c:.1f} {d:.1f}" for at, (a, b, c, d) in sides.items() if is_out(*at)
    ]


def places(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Where values are along an axis: by their logarithms, if they are evenly apart so."""
    spread = values
    if len(values) > 2 and values[0] > 0.0:
        ratios, steps = np.diff(np.log(values)), np.diff(values)
        if np.ptp(ratios) / ratios.mean() < np.ptp(steps) / steps.mean():
            spread = np.log(values)
    extent = float(np.ptp(spread)) or 1.0
    return low + (high - low) * (spread - spread[0]) / extent


def levels(costs: np.ndarray) -> np.ndarray:
    """How far up costs are drawn, 0 at the foot."""
    top = float(np.nanmax(costs)) or 1.0
    return TALL - BELOW - (TALL - ABOVE - BELOW) * 0.96 * costs / top


def axis_across(name: str, unit: str, values: np.ndarray, x: np.ndarray) -> str:
    """Figures and the name below a picture."""
    texts = [
        f'<text x="{x[k]:.1f}" y="{TALL - BELOW + 12:g}" text-anchor="middle" {FIGURE}>'
        f"{values[k]:g}</text>"
        for k in ticks(len(values))
    ]
    title = html.escape(f"{name}, {unit}" if unit != "1" else name)
    middle = 0.5 * (LEFT + WIDE - RIGHT)
    return "".join(texts) + (
        f'<text x="{middle:g}" y="{TALL - 6:g}" text-anchor="middle" {FIGURE}>{title}</text>'
    )


def axis_up(name: str, unit: str, values: np.ndarray, y: np.ndarray) -> str:
    """Figures and the name on the left of a picture."""
    texts = [
        f'<text x="{LEFT - 5:g}" y="{y[k] + 3:.1f}" text-anchor="end" {FIGURE}>{values[k]:g}</text>'
        for k in ticks(len(values))
    ]
    title = html.escape(f"{name}, {unit}" if unit != "1" else name)
    middle = 0.5 * (ABOVE + TALL - BELOW)
    return "".join(texts) + (
        f'<text transform="translate(12 {middle:g}) rotate(-90)" text-anchor="middle" {FIGURE}>'
        f"{title}</text>"
    )


def ticks(count: int) -> list[int]:
    """Which of so many values have figures: some five."""
    return np.unique(np.linspace(0, count - 1, min(count, 5)).astype(int)).tolist()
