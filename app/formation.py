"""The picture of a V seen from above, and of what jitter costs it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from agents.observables.formation import THESIS_SPACING, Spacing, upwash_share
from app.figure import new_figure, write_figure
from app.results_folder import PICTURES, make_folder
from worlds.file_writer import write_text

# What the formation commands write: pictures as PNG and SVG, numbers as CSV.

SAVED, LOST, INK, PALE = "#1f9d63", "#c0392b", "#3c434b", "#9aa3ad"
SHADES = "BrBG"
"""Colours of shares: downwash brown, upwash green."""


def write_picture(folder: Path, name: str, draw: Callable[[Any], None]) -> dict[str, Path]:
    """Draw on a new figure and write it into the folder; the files by kind. Raises InputError."""
    files = {kind: folder / f"{name}.{kind}" for kind in PICTURES}
    with new_figure() as figure:
        draw(figure)
        make_folder(folder)
        for path in files.values():
            write_figure(figure, path)
    return files


def table(
    folder: Path, name: str, head: Sequence[str], rows: Iterable[Sequence[Any]]
) -> dict[str, Path]:
    """Write rows of numbers as CSV into the folder; the file by kind. Raises InputError."""
    path = folder / f"{name}.csv"
    lines = [",".join(head), *(",".join(f"{value:.9g}" for value in row) for row in rows)]
    make_folder(folder)
    write_text("table", path, "\n".join(lines) + "\n")
    return {"csv": path}


# The picture of the upwash behind one bird: from above, and across its wake.

ASIDE = np.linspace(-2.5, 2.5, 251)
BACK = np.linspace(-1.5, 6.0, 251)
UP = np.linspace(-1.25, 1.25, 126)
"""Places that are drawn, spans."""
SCALE = 0.8
"""Share that is drawn in the strongest colour."""


def shares_from_above(core: float, above: float) -> np.ndarray:
    """Shares (len(BACK), len(ASIDE)) of a bird with its middle there."""
    return upwash_share(BACK[:, None], ASIDE[None], above, core)


def shares_across(core: float, behind: float) -> np.ndarray:
    """Shares (len(UP), len(ASIDE))."""
    return upwash_share(behind, ASIDE[None], UP[:, None], core)


def draw_behind(figure: Any, core: float, above: float, behind: float, best: Spacing) -> None:
    """Draw both maps; a white cross where a follower at that distance saves most."""
    figure.set_size_inches(11.0, 5.2)
    left, right = figure.subplots(1, 2)
    levels = {"cmap": SHADES, "vmin": -SCALE, "vmax": SCALE, "shading": "gouraud"}
    left.pcolormesh(ASIDE, -BACK, shares_from_above(core, above), rasterized=True, **levels)
    mesh = right.pcolormesh(ASIDE, UP, shares_across(core, behind), rasterized=True, **levels)
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


# The picture of what a bird saves beside another, over the wing-tip spacing.

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


MOST = 1.0
"""Share that is drawn in the strongest colour."""


def draw_vee(
    figure: Any, places: np.ndarray, shares: np.ndarray, rows: list[dict[str, float]]
) -> None:
    """Draw the birds (N, 3) in spans coloured by their shares (N,), and the rows' percentages."""
    figure.set_size_inches(11.0, 4.8)
    left, right = figure.subplots(1, 2, width_ratios=(1.35, 1.0))
    birds(left, places, shares)
    costs(right, rows)
    figure.suptitle(
        f"A V of {len(places)}: share of each bird's induced drag saved; power saved by the V",
        x=0.01,
        ha="left",
    )


def birds(axes: Any, places: np.ndarray, shares: np.ndarray) -> None:
    """Birds from above, heading up the page, with their shares in percent."""
    from matplotlib import colormaps
    from matplotlib.collections import PolyCollection

    outline = np.array(
        [[0, 0.16], [0.06, 0.05], [0.5, -0.06], [0.5, -0.1], [0.07, -0.1], [0.06, -0.24], [0, -0.2]]
    )
    outline = np.vstack([outline, outline[::-1] * [-1, 1]])
    shapes = [outline + np.array([-y, x]) for x, y, _ in places]
    colours = colormaps[SHADES](0.5 + 0.5 * np.clip(shares / MOST, -1.0, 1.0))
    axes.add_collection(PolyCollection(shapes, facecolors=colours, edgecolors=INK, linewidths=0.7))
    for (x, y, _), share in zip(places, shares, strict=True):
        words = f"{100.0 * share:.0f} %".replace("-", "−")
        axes.text(-y, x - 0.34, words, ha="center", va="top", fontsize=8, color=INK)
    axes.set_aspect("equal")
    axes.set_xlim(-places[:, 1].max() - 0.8, -places[:, 1].min() + 0.8)
    axes.set_ylim(places[:, 0].min() - 0.9, places[:, 0].max() + 0.5)
    axes.grid(visible=False)
    axes.set_xlabel("aside / b")
    axes.set_ylabel("ahead / b")


def costs(axes: Any, rows: list[dict[str, float]]) -> None:
    """Power saved in percent over the jitter, bars from the 5th to the 95th percentile."""
    jitter = [row["jitter"] for row in rows]
    mean = np.array([row["power"] for row in rows])
    ends = [mean - [row["power_5"] for row in rows], [row["power_95"] for row in rows] - mean]
    axes.errorbar(
        jitter, mean, np.clip(ends, 0.0, None), color=SAVED, marker="o", linewidth=1.6, capsize=4
    )
    for x, y in zip(jitter, mean, strict=True):
        axes.annotate(
            f"{y:.0f} %".replace("-", "−"), (x, y), xytext=(7, 6), textcoords="offset points"
        )
    axes.axhline(0.0, color=INK, linewidth=0.8)
    axes.margins(x=0.12)
    axes.set_xlabel("jitter of every coordinate / b (standard deviation)")
    axes.set_ylabel("power saved by the V / %")
