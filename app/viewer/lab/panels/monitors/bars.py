"""Bars in the monitors: how many agents there are in each layer, or in each group."""

from __future__ import annotations

import html

import numpy as np

from app.viewer.panels.style import BLUE
from app.viewer.scene.shown import palette

MOST_BARS = 12


def layer_bars(counts: list[int], unknown: int, model: str = "") -> str:
    """Bars of how many agents are in each layer; deep layers go together in the last bar.

    `model` says which of two flocks they are of.
    """
    if len(counts) > MOST_BARS:
        counts = [*counts[: MOST_BARS - 1], sum(counts[MOST_BARS - 1 :])]
    most = max([*counts, unknown, 1])
    bars = "".join(
        bar(
            str(layer),
            count,
            most,
            palette.css(palette.LAYERS[min(layer, len(palette.LAYERS)) - 1]),
        )
        for layer, count in enumerate(counts, start=1)
    )
    bars += bar("?", unknown, most, palette.css(palette.UNKNOWN)) if unknown else ""
    return (
        '<div class="fs-head">Layers<span class="fs-quiet">'
        f"{html.escape(model) or 'steps from the information agent'}</span></div>"
        f'<div class="fs-bars">{bars}</div>'
    )


def bar(label: str, count: int, most: int, colour: str) -> str:
    """One bar with its count above and its label below."""
    height = max(2, round(34 * count / most)) if count else 0
    return f'<div>{count}<i style="height:{height}px;background:{colour}"></i>{label}</div>'


def size_bars(sizes: np.ndarray, model: str = "") -> str:
    """Bars of how many agents each group has (G,), the largest first.

    `model` says which of two flocks they are of.
    """
    shown = sizes[:MOST_BARS].tolist()
    rest = f"and {len(sizes) - len(shown)} more" if len(sizes) > len(shown) else "agents in each"
    bars = "".join(bar(str(rank), size, shown[0], BLUE) for rank, size in enumerate(shown, 1))
    return (
        f'<div class="fs-head">Groups<span class="fs-quiet">{html.escape(model)} {rest}</span>'
        f'</div><div class="fs-bars">{bars}</div>'
    )
