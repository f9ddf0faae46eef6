"""What a notebook shows of a value: a small picture as SVG and a table, HTML that needs no page."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

WIDTH = 240
"""Of a picture, pixels; its height follows from the world."""
TALLEST = 3.0
"""The height of a picture over its width at most; what is taller is drawn narrower."""
FIGURES = 4
"""Of a number in a table."""


def svg(
    low: Sequence[float],
    size: Sequence[float],
    outlines: Iterable[Any],
    marks: Iterable[str] = (),
    words: str = "",
) -> str:
    """A box [low, low + size) seen from above as SVG, y upwards.

    `outlines` are shapely's polygons of what is solid; `marks` are SVG elements in the world's own
    coordinates, drawn over it; `words` say what is seen. Lengths are those of the world.
    """
    left, front = float(low[0]), float(low[1])
    wide, deep = float(size[0]), float(size[1])
    height = min(WIDTH * deep / wide, TALLEST * WIDTH)
    line = max(wide, deep) / 400
    solids = "".join(f'<path d="{path_of(outline)}"/>' for outline in outlines)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label="{html.escape(words)}" '
        f'width="{height * wide / deep:.0f}" '
        f'height="{height:.0f}" viewBox="{left:g} {-front - deep:g} {wide:g} {deep:g}">'
        f'<g transform="scale(1 -1)"><rect x="{left:g}" y="{front:g}" width="{wide:g}" '
        f'height="{deep:g}" fill="#8881" stroke="#888" stroke-width="{2 * line:.3g}"/>'
        f'<g fill="#888" fill-rule="evenodd">{solids}</g>{"".join(marks)}</g></svg>'
    )


def path_of(outline: Any) -> str:
    """A shapely polygon, or several, as the data of an SVG path."""
    polygons = getattr(outline, "geoms", [outline])
    rings = [
        ring for one in polygons if not one.is_empty for ring in (one.exterior, *one.interiors)
    ]
    return "".join(
        "M" + "L".join(f"{x:.4g} {y:.4g}" for x, y, *_ in ring.coords[:-1]) + "Z" for ring in rings
    )


def arrows(position: np.ndarray, heading: np.ndarray, length: float) -> list[str]:
    """An arrow head for each agent, coloured by where it heads; of (N, 2 or 3) from above."""
    hue = np.degrees(np.arctan2(heading[:, 1], heading[:, 0])) % 360
    ahead = heading[:, :2] * length
    aside = np.column_stack([-ahead[:, 1], ahead[:, 0]]) * 0.4
    place = position[:, :2]
    corners = np.stack([place + ahead, place - ahead + aside, place - ahead - aside], axis=1)
    return [
        f'<path fill="hsl({round(colour)} 75% 45%)" d="M'
        + "L".join(f"{x:.4g} {y:.4g}" for x, y in triangle)
        + 'Z"/>'
        for colour, triangle in zip(hue.tolist(), corners.tolist(), strict=True)
    ]


def number_text(value: Any) -> str:
    """A value for people.

    >>> number_text(0.123456), number_text((5.0, 2.5)), number_text("wrap")
    ('0.1235', '5, 2.5', 'wrap')
    """
    if isinstance(value, tuple | list):
        return ", ".join(number_text(one) for one in value)
    return f"{value:.{FIGURES}g}" if isinstance(value, float | np.floating) else str(value)


def table(rows: Mapping[str, Any], title: str = "", picture: str = "") -> str:
    """Names and values as an HTML table, beside a picture if there is one."""
    lines = "".join(
        f'<tr><th style="text-align:left">{html.escape(name)}</th>'
        f'<td style="text-align:left">{html.escape(number_text(value))}</td></tr>'
        for name, value in rows.items()
    )
    head = f"<b>{html.escape(title)}</b>" if title else ""
    columns = f"<div>{head}<table>{lines}</table></div>"
    return f'<div style="display:flex;gap:1em;align-items:flex-start">{picture}{columns}</div>'
