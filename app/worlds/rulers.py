"""The axes of a plan: lengths at the same scale, without a frame."""

from __future__ import annotations

from typing import Any

from app.worlds.colours import INK, PALE


def ruled(axes: Any, across: str, up: str) -> None:
    """Name the axes and give them their look."""
    from matplotlib.ticker import MaxNLocator

    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(8, steps=[1, 2, 5, 10]))
    axes.set(aspect="equal", xlabel=f"${across}$ / m", ylabel=f"${up}$ / m")
    axes.tick_params(length=3, color=PALE, labelsize=8.5, labelcolor=INK)
