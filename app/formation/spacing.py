"""The picture of what a bird saves beside another, over the wing-tip spacing."""

from __future__ import annotations

from typing import Any

import numpy as np

from agents.observables.formation import THESIS_SPACING, Spacing, upwash_share
from app.formation.files import INK, LOST, PALE, SAVED

TIPS = np.linspace(-1.2, 1.0, 2201)
"""Wing-tip spacings that are drawn, spans."""


def curve(core: float, behind: float, above: float) -> np.ndarray:
    """Shares of induced drag saved at TIPS."""
    return upwash_share(behind, 1.0 + TIPS, above, core)


def draw_spacing(figure: Any, core: float, behind: float, above: float, best: Spacing) -> None:
    """Draw the share with the core asked for, with none, and the spacing of (2.8)."""
    figure.set_size_inches(7.6, 4.6)
    axes = figure.subplots()
    axes.axhline(0.0, color=INK, linewidth=0.8)
    axes.axvline(
        THESIS_SPACING, color=LOST, linewidth=1.2, linestyle=(0, (4, 3)), label="(2.8): −0.107 b"
    )
    if core > 0.0:
        lines = curve(0.0, behind, above)
        axes.plot(TIPS, lines, color=PALE, linewidth=1.4, label="line vortices, no core")
    axes.plot(
        TIPS,
        curve(core, behind, above),
        color=SAVED,
        linewidth=2.2,
        label=f"core of {core:g} b" if core > 0.0 else "line vortices, no core",
    )
    axes.plot(*best, "o", color=SAVED, markeredgecolor="white", markersize=8, zorder=5)
    axes.annotate(
        f"{100.0 * best.saved:.0f} % at {best.tip:.3f} b".replace("-", "−"),
        best,
        xytext=(-10, 6),
        textcoords="offset points",
        ha="right",
        color=SAVED,
        weight="bold",
    )
    axes.set_xlim(TIPS[0], TIPS[-1])
    axes.set_ylim(-2.1, 1.2)
    axes.set_xlabel("wing-tip spacing / b (negative: wings overlap)")
    axes.set_ylabel("share of induced drag saved")
    axes.legend(loc="lower right")
    place = "far behind" if behind == np.inf else f"{behind:g} b behind"
    level = "" if above == 0.0 else f", {above:g} b above"
    figure.suptitle(f"What a bird saves {place}{level} another", x=0.01, ha="left")
