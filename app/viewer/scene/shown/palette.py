"""The scene's colours, all as sRGB in [0, 1]."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from app.viewer.scene.shown.oklch import attainable, oklch


def srgb(css: str) -> np.ndarray:
    """A CSS colour #rrggbb as sRGB (3,) in [0, 1]."""
    return np.array([int(css[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0


def css(colour: np.ndarray) -> str:
    """The inverse of `srgb`."""
    red, green, blue = (round(255.0 * min(max(one, 0.0), 1.0)) for one in colour.tolist())
    return f"#{red:02x}{green:02x}{blue:02x}"


SKY_HIGH, SKY_LOW = srgb("#cddcf0"), srgb("#f8fafd")
FLOOR = srgb("#fbfcfe")
CELL, SECTION = srgb("#e3e9f1"), srgb("#d3dbe6")
"""The lines of the floor."""
GROUND, GROUND_LINE = srgb("#dfe5ed"), srgb("#cdd6e1")
"""What the floor of a world in space lies on."""
FOG = srgb("#e1e7ef")
"""What is far off; the sky behind it is lighter, which makes the horizon."""
EDGE = srgb("#64748b")
EDGE_SPACE = srgb("#8493a8")
EDGE_LIGHT = srgb("#b4bfce")
LINK = srgb("#9db0c9")

SOLID = srgb("#b9c2cf")
SOLID_EDGE = srgb("#475569")
RIM = srgb("#ccd4df")
START = srgb("#2a9d5c")
GOAL = srgb("#7c3aed")
POINT = srgb("#e08214")

PLAIN = srgb("#2f6fde")
LEADER = srgb("#e11d48")
HALO = srgb("#f6a609")
SELECTED = srgb("#0f172a")
UNKNOWN = srgb("#aab4c2")

LAYERS = np.array(
    [
        LEADER,
        srgb("#f97316"),
        srgb("#e0a800"),
        srgb("#4fae2b"),
        srgb("#0ea5a0"),
        srgb("#2f7df0"),
        srgb("#6d4be0"),
        srgb("#a836c9"),
        srgb("#7a3358"),
    ]
)
"""Layers 1 to 8, then all farther ones; `UNKNOWN` for agents nobody leads."""

GROUPS = np.array(
    [
        srgb("#1f5fe0"),
        srgb("#f08c1a"),
        srgb("#1fa774"),
        srgb("#c63d96"),
        srgb("#8a63d8"),
        srgb("#c9a21b"),
        srgb("#24a6c4"),
        srgb("#d9534a"),
        srgb("#9aa5b4"),
    ]
)
"""The largest group, the seven after it, then all smaller ones."""

FORCES = np.array(
    [
        srgb("#1f5fe0"),
        srgb("#0ea5a0"),
        srgb("#d9480f"),
        srgb("#c99700"),
        srgb("#7c3aed"),
        srgb("#c2255c"),
        srgb("#5c7c1f"),
        srgb("#64748b"),
    ]
)
"""The forces on an agent, in the order in which its rule names them."""

ZONES = np.array([srgb("#d1352b"), srgb("#f0a80e"), srgb("#1b7fc4"), srgb("#12a08a")])
"""The zones of a rule from the inside out; told apart by their lightness too."""
BLIND = srgb("#7b8794")
"""What an agent does not notice."""
COOL, WARM = srgb("#1d78b5"), srgb("#e07b16")
"""The left and the right line of a bird's wake."""
GLASS, TYRE = srgb("#26323f"), srgb("#1b222b")
"""The windows and the wheels of cars."""
FENCE = srgb("#d9730d")
"""Where real cars are made to stop; and what is stuck."""
OWN = {
    "blue": srgb("#016cff"),
    "orange": srgb("#ed6b00"),
    "teal": srgb("#007f78"),
    "pink": srgb("#ea2fa4"),
    "olive": srgb("#646e00"),
    "sky": srgb("#1d9ce2"),
    "brown": srgb("#a75657"),
    "green": srgb("#41a356"),
    "gold": srgb("#a68d3a"),
    "plum": srgb("#a342ac"),
    "red": srgb("#e30010"),
    "grey": srgb("#7e7c9c"),
}
"""Colours that agents have as their own, the most distinct first. The first eight can be told apart
without seeing red or green; all stand out from a light and from a dark ground, 3 to 1."""
STATES = {
    "tracked": srgb("#12a07f"),
    "late": srgb("#eba10c"),
    "lost": srgb("#d92b2b"),
    "stopped": srgb("#64748b"),
    "simulated": srgb("#3f9fe8"),
}
"""What a car in a room with real ones is: the colour of the outline around it."""
ARMS = {"safe": srgb("#64748b"), "armed": srgb("#0e8f8a"), "emergency": srgb("#d92b2b")}
"""The edge of a capture area, by what the laboratory may do."""
CRASHED = srgb("#a3706c")
CRASH = srgb("#c9302c")
"""The place of a crash that has just happened."""

_HUES = 360
_RISES = 33
_SMOOTH = 25
HUE_EAST = np.deg2rad(255.0)
"""Hue of an agent heading along +x; the hue grows with the azimuth."""
HUE_YELLOW = np.deg2rad(95.0)
"""The hue that turns to mud unless it is made lighter than the others."""


def _heading_table() -> np.ndarray:
    """(rises, hues, 3): hue by azimuth; lighter climbing, darker diving."""
    hue = HUE_EAST + np.linspace(0.0, 2.0 * np.pi, _HUES, endpoint=False)[None, :]
    rise = np.linspace(-0.13, 0.11, _RISES)[:, None]
    lightness = 0.675 + 0.085 * np.cos(hue - HUE_YELLOW) + rise
    # What sRGB can show changes abruptly with the hue; an even wheel must change slowly.
    chroma = attainable(lightness, np.full_like(lightness, 0.20), hue + 0.0 * lightness)
    return oklch(lightness, _around(_around(chroma).min(axis=-1)).mean(axis=-1), hue)


def _around(rows: np.ndarray) -> np.ndarray:
    """(rises, hues, _SMOOTH): of each value (rises, hues) those around it; hues go round."""
    ends = np.pad(rows, ((0, 0), (_SMOOTH // 2, _SMOOTH // 2)), mode="wrap")
    return sliding_window_view(ends, _SMOOTH, axis=1)


def _speed_table() -> np.ndarray:
    """(256, 3): slow pale blue, over violet, to fast crimson."""
    t = np.linspace(0.0, 1.0, 256)
    hue = np.deg2rad(225.0 + 150.0 * t)
    return oklch(0.80 - 0.25 * t, 0.09 + 0.14 * t, hue)


def _saving_table() -> np.ndarray:
    """(257, 3): orange where it costs, over pale grey at 0, to deep teal where it is saved."""
    t = np.linspace(-1.0, 1.0, 257)
    strength = np.abs(t) ** 0.8
    hue = np.deg2rad(np.where(t < 0.0, 48.0, 205.0))
    lightness = 0.86 - np.where(t < 0.0, 0.23, 0.36) * strength
    chroma = np.where(t < 0.0, 0.18, 0.105) * strength
    return oklch(lightness, chroma, hue)


HEADINGS = _heading_table()
SAVINGS = _saving_table()
SPEEDS = _speed_table()


def by_heading(heading: np.ndarray) -> np.ndarray:
    """Headings (N, dim) -> colours (N, 3)."""
    azimuth = np.arctan2(heading[:, 1], heading[:, 0])
    column = np.rint(azimuth * (_HUES / (2.0 * np.pi))).astype(int) % _HUES
    if heading.shape[1] == 2:
        return HEADINGS[_RISES // 2, column]
    rise = np.arcsin(np.clip(heading[:, 2], -1.0, 1.0)) / np.pi + 0.5
    return HEADINGS[np.rint(rise * (_RISES - 1)).astype(int), column]


def by_speed(speed: np.ndarray, full: float) -> np.ndarray:
    """Speeds (N,) -> colours (N, 3), the last of the table from `full` on."""
    share = np.clip(speed / full if full > 0.0 else np.zeros_like(speed), 0.0, 1.0)
    return SPEEDS[np.rint(255.0 * share).astype(int)]


def by_number(values: np.ndarray) -> np.ndarray:
    """Numbers (N,), NaN or infinite unknown -> colours (N, 3), from the least to the largest."""
    known = np.isfinite(values)
    low, high = span(values)
    colours = by_speed(np.where(known, values, low) - low, high - low)
    return np.where(known[:, None], colours, UNKNOWN)


def span(values: np.ndarray) -> tuple[float, float]:
    """The least and the largest of those numbers that are known; 0 and 0 if none is."""
    known = values[np.isfinite(values)]
    return (float(known.min()), float(known.max())) if len(known) else (0.0, 0.0)


def by_zone(zone: np.ndarray) -> np.ndarray:
    """Zones (N,) from the inside out, below 0 unnoticed -> colours (N, 3)."""
    return np.where((zone < 0)[:, None], BLIND, ZONES[zone % len(ZONES)])


def by_saving(saved: np.ndarray, full: float) -> np.ndarray:
    """Shares (N,) saved, NaN unknown -> colours (N, 3), the last of the table from +-full on."""
    known = np.isfinite(saved)
    share = np.clip(np.where(known, saved, 0.0) / full, -1.0, 1.0)
    return np.where(known[:, None], SAVINGS[np.rint(128.0 * (share + 1.0)).astype(int)], UNKNOWN)


def by_layer(layer: np.ndarray) -> np.ndarray:
    """Layers (N,), 1 the information agents, N + 1 unknown -> colours (N, 3)."""
    colours = LAYERS[np.clip(layer - 1, 0, len(LAYERS) - 1)]
    colours[layer > len(layer)] = UNKNOWN
    return colours


def by_group(group: np.ndarray) -> np.ndarray:
    """Labels (N,), 0 the largest group -> colours (N, 3)."""
    return GROUPS[np.clip(group, 0, len(GROUPS) - 1)]
