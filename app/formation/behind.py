"""The picture of the upwash behind one bird: from above, and across its wake."""

from __future__ import annotations

from typing import Any

import numpy as np

from agents.observables.formation import Spacing, upwash_share
from app.formation.files import INK, SHADES

ASIDE = np.linspace(-2.5, 2.5, 251)
BACK = np.linspace(-1.5, 6.0, 251)
UP = np.linspace(-1.25, 1.25, 126)
"""Places that are drawn, spans."""
SCALE = 0.8
"""Share that is drawn in the strongest colour."""


def from_above(core: float, above: float) -> np.ndarray:
    """Shares (len(BACK), len(ASIDE)) of a bird with its middle there."""
    return upwash_share(BACK[:, None], ASIDE[None], above, core)


def across(core: float, behind: float) -> np.ndarray:
    """Shares (len(UP), len(ASIDE))."""
    return upwash_share(behind, ASIDE[None], UP[:, None], core)


def draw_behind(figure: Any, core: float, above: float, behind: float, best: Spacing) -> None:
    """Draw both maps; a white cross where a follower at that distance saves most."""
    figure.set_size_inches(11.0, 5.2)
    left, right = figure.subplots(1, 2)
    levels = {"cmap": SHADES, "vmin": -SCALE, "vmax": SCALE, "shading": "gouraud"}
    left.pcolormesh(ASIDE, -BACK, from_above(core, above), rasterized=True, **levels)
    mesh = right.pcolormesh(ASIDE, UP, across(core, behind), rasterized=True, **levels)
    for axes, there in ((left, -behind), (right, 0.0)):
        axes.plot([-0.5, 0.5], [0.0, 0.0], color=INK, linewidth=4)
        axes.plot([-1 - best.tip, 1 + best.tip], [there, there], "+", color="white", markersize=9)
        axes.set_aspect("equal")
        axes.grid(visible=False)
        axes.set_xlabel("middle of the follower, aside / b")
    left.axhline(-behind, color=INK, linewidth=0.7, linestyle=(0, (2, 3)))
    left.set_ylabel("ahead / b")
    right.set_ylabel("above / b")
    height = f"{above:g} b above" if above else "at the same height"
    left.set_title(f"from above, the follower {height}", loc="left")
    right.set_title(f"across the wake, {behind:g} b behind", loc="left")
    figure.colorbar(
        mesh, ax=[left, right], label="share of induced drag saved", extend="both", shrink=0.8
    )
    figure.suptitle("What a bird saves in the wake of one other (bar)", x=0.01, ha="left")
