"""The picture of a V seen from above, and of what jitter costs it."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.formation.files import INK, SAVED, SHADES

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
