"""What all schemes are drawn with: agents, arrows, words on a ground of their own, bare panels."""

from __future__ import annotations

from typing import Any

import numpy as np

INK, FAINT = "#3c434b", "#9aa3ad"
ZONE_FILLS = ("#fbe6a2", "#cfe9d3", "#d5e3f5")
"""Grounds of repulsion, orientation and attraction: the thesis's yellow, green and blue."""
ZONE_COLOURS = ("#b07d12", "#1f9d63", "#2166ac")
"""The same as colours of agents and words."""
BLIND = "#eef0f3"


def set_square_view(axes: Any, centre: np.ndarray, half: float) -> None:
    """Show a square of half side `half` about a centre (2,), without ticks and frame."""
    axes.set(
        xlim=(centre[0] - half, centre[0] + half), ylim=(centre[1] - half, centre[1] + half),
        xticks=[], yticks=[], aspect="equal",
    )  # fmt: skip
    axes.grid(visible=False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def draw_dart(axes: Any, place: np.ndarray, heading: np.ndarray, colour: str, size: float,
         hollow: bool = False) -> None:  # fmt: skip
    """Draw an agent as a V-shaped dart of a length `size` that points along its heading (2,)."""
    from matplotlib.patches import Polygon

    along = heading / np.linalg.norm(heading)
    aside = np.array([-along[1], along[0]])
    corners = [0.6 * along, -0.4 * along + 0.32 * aside, -0.2 * along, -0.4 * along - 0.32 * aside]
    axes.add_patch(
        Polygon(
            np.asarray(place) + size * np.array(corners), closed=True, zorder=7, linewidth=1.1,
            facecolor="white" if hollow else colour, edgecolor=colour,
        )
    )  # fmt: skip


def arrow(axes: Any, tail: np.ndarray, vector: np.ndarray, colour: str, width: float = 1.8,
          zorder: float = 8.0, style: Any = "-") -> None:  # fmt: skip
    """Draw a vector (2,) from a place (2,)."""
    if np.linalg.norm(vector) < 1e-12:
        return
    axes.annotate(
        "", np.asarray(tail) + vector, tail, zorder=zorder,
        arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": width, "linestyle": style,
                    "mutation_scale": 8.0 + 3.0 * width, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip


def write_label(
    axes: Any,
    at: np.ndarray,
    words: str,
    colour: str = INK,
    shift: tuple[float, float] = (0, 0),
    size: float = 10.0,
    **more: Any,
) -> None:
    """Write words at a place (2,) shifted by points, on a white ground."""
    axes.annotate(
        words, at, shift, textcoords="offset points", color=colour, fontsize=size, zorder=9,
        **({"ha": "center", "va": "center"} | more),
        bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none",
              "alpha": 0.85},
    )  # fmt: skip


def rotate_vector(heading: np.ndarray, angle: float) -> np.ndarray:
    """A vector (2,) turned by an angle, deg, anticlockwise."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return np.array([c * heading[0] - s * heading[1], s * heading[0] + c * heading[1]])


def sign(colour: str, label: str, marker: str = "o", hollow: bool = False) -> Any:
    """A mark of the legend."""
    from matplotlib.lines import Line2D

    face = "white" if hollow else colour
    return Line2D([], [], color=colour, marker=marker, linestyle="none", markersize=8, label=label,
                  markerfacecolor=face)  # fmt: skip


def stroke(colour: str, label: str, style: Any = "-", width: float = 2.0) -> Any:
    """A line of the legend."""
    from matplotlib.lines import Line2D

    return Line2D([], [], color=colour, linestyle=style, linewidth=width, label=label)
