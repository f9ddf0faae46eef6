"""The scene's colours, all as sRGB in [0, 1]."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache, lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from agents.kinds import KindTable
from app.viewer.scene.shown.frame import Frame

# Perceptually even colours: OKLCH (lightness, chroma, hue) to sRGB.
#
# Source: B. Ottosson, "A perceptual color space for image processing" (2020).

_LMS_FROM_LAB = np.array(
    [
        [1.0, 0.3963377774, 0.2158037573],
        [1.0, -0.1055613458, -0.0638541728],
        [1.0, -0.0894841775, -1.2914855480],
    ]
)
_RGB_FROM_LMS = np.array(
    [
        [4.0767416621, -3.3077115913, 0.2309699292],
        [-1.2684380046, 2.6097574011, -0.3413193965],
        [-0.0041960863, -0.7034186147, 1.7076147010],
    ]
)


def linear_to_srgb(linear: np.ndarray) -> np.ndarray:
    """Linear light in [0, 1] -> sRGB in [0, 1]."""
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def srgb_to_linear(srgb: np.ndarray) -> np.ndarray:
    """sRGB in [0, 1] -> linear light in [0, 1]."""
    srgb = np.clip(srgb, 0.0, 1.0)
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def _linear(lightness: np.ndarray, chroma: np.ndarray, hue: np.ndarray) -> np.ndarray:
    lab = np.stack([lightness, chroma * np.cos(hue), chroma * np.sin(hue)], axis=-1)
    return (lab @ _LMS_FROM_LAB.T) ** 3 @ _RGB_FROM_LMS.T


def _is_in_gamut(lightness: np.ndarray, chroma: np.ndarray, hue: np.ndarray) -> np.ndarray:
    """Whether sRGB can show these colours."""
    linear = _linear(lightness, chroma, hue)
    return np.all((linear >= -1e-6) & (linear <= 1.0 + 1e-6), axis=-1)


def attainable_chroma(lightness: np.ndarray, chroma: np.ndarray, hue: np.ndarray) -> np.ndarray:
    """The largest chroma up to `chroma` that sRGB can show at these lightnesses and hues."""
    low, high = np.zeros_like(chroma), chroma.copy()
    for _ in range(20):
        middle = 0.5 * (low + high)
        visible = _is_in_gamut(lightness, middle, hue)
        low, high = np.where(visible, middle, low), np.where(visible, high, middle)
    return np.where(_is_in_gamut(lightness, chroma, hue), chroma, low)


def oklch(lightness: np.ndarray, chroma: np.ndarray, hue: np.ndarray) -> np.ndarray:
    """Lightness [0, 1], chroma [0, 0.4) and hue [rad] -> sRGB (..., 3) in [0, 1].

    A chroma that sRGB cannot show at that lightness and hue is lowered until it can, so that
    lightness and hue stay true.
    """
    lightness, chroma, hue = np.broadcast_arrays(
        *(np.asarray(part, dtype=float) for part in (lightness, chroma, hue))
    )
    return linear_to_srgb(_linear(lightness, attainable_chroma(lightness, chroma, hue), hue))


def srgb(css: str) -> np.ndarray:
    """A CSS colour #rrggbb as sRGB (3,) in [0, 1]."""
    return np.array([int(css[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0


def css(colour: np.ndarray) -> str:
    """The inverse of `srgb`."""
    red, green, blue = (round(255.0 * min(max(channel, 0.0), 1.0)) for channel in colour.tolist())
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
LEADER = srgb("#f8403a")
"""Red on a light ground, and still red where the dark theme has turned it round: darker ones are
pink there."""
HALO = srgb("#f6a609")
SELECTED = srgb("#0f172a")
UNKNOWN = srgb("#aab4c2")

LAYERS = np.array(
    [
        LEADER,
        srgb("#fa7d14"),
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
CAUGHT = srgb("#c3ccd8")
"""Who was caught and stands still: pale on a light and on a dark ground."""
CRASHED = srgb("#a3706c")
CRASH = srgb("#c9302c")
"""The place of a crash that has just happened."""

_HUES = 360
_RISES = 33
_SMOOTH = 25
_STRENGTHS, _ORDERS, _TURNS = 64, 16, 90
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
    chroma = attainable_chroma(lightness, np.full_like(lightness, 0.20), hue + 0.0 * lightness)
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


@cache
def density_table() -> np.ndarray:
    """Of a picture of density, (strengths, orders, hues, 3), bytes: from the floor to dark, from
    grey to full hues, by the mean heading."""
    strength = np.linspace(0.0, 1.0, _STRENGTHS)[:, None, None]
    order = np.linspace(0.0, 1.0, _ORDERS)[None, :, None]
    hue = HUE_EAST + np.linspace(0.0, 2.0 * np.pi, _TURNS, endpoint=False)[None, None, :]
    lightness = 0.99 - 0.56 * strength**0.9 + 0.04 * strength * np.cos(hue - HUE_YELLOW)
    chroma = 0.19 * order * np.minimum(1.0, 2.2 * strength)
    colours = oklch(lightness + 0.0 * order, chroma + 0.0 * hue, hue)
    colours[0] = FLOOR
    return (255.0 * colours + 0.5).astype(np.uint8)


HEADINGS = _heading_table()
SAVINGS = _saving_table()
SPEEDS = _speed_table()


def heading_colours(heading: np.ndarray) -> np.ndarray:
    """Headings (N, dim) -> colours (N, 3)."""
    azimuth = np.arctan2(heading[:, 1], heading[:, 0])
    column = np.rint(azimuth * (_HUES / (2.0 * np.pi))).astype(int) % _HUES
    if heading.shape[1] == 2:
        return HEADINGS[_RISES // 2, column]
    rise = np.arcsin(np.clip(heading[:, 2], -1.0, 1.0)) / np.pi + 0.5
    return HEADINGS[np.rint(rise * (_RISES - 1)).astype(int), column]


def speed_colours(speed: np.ndarray, full: float) -> np.ndarray:
    """Speeds (N,) -> colours (N, 3), the last of the table from `full` on."""
    share = np.clip(speed / full if full > 0.0 else np.zeros_like(speed), 0.0, 1.0)
    return SPEEDS[np.rint(255.0 * share).astype(int)]


def number_colours(values: np.ndarray) -> np.ndarray:
    """Numbers (N,), NaN or infinite unknown -> colours (N, 3), from the least to the largest."""
    is_known = np.isfinite(values)
    low, high = span(values)
    colours = speed_colours(np.where(is_known, values, low) - low, high - low)
    return np.where(is_known[:, None], colours, UNKNOWN)


def span(values: np.ndarray) -> tuple[float, float]:
    """The least and the largest of those numbers that are known; 0 and 0 if none is."""
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)


def zone_colours(zone: np.ndarray) -> np.ndarray:
    """Zones (N,) from the inside out, below 0 unnoticed -> colours (N, 3)."""
    return np.where((zone < 0)[:, None], BLIND, ZONES[zone % len(ZONES)])


def saving_colours(saved: np.ndarray, full: float) -> np.ndarray:
    """Shares (N,) saved, NaN unknown -> colours (N, 3), the last of the table from +-full on."""
    is_known = np.isfinite(saved)
    share = np.clip(np.where(is_known, saved, 0.0) / full, -1.0, 1.0)
    return np.where(is_known[:, None], SAVINGS[np.rint(128.0 * (share + 1.0)).astype(int)], UNKNOWN)


def layer_colours(layer: np.ndarray) -> np.ndarray:
    """Layers (N,), 1 the information agents, N + 1 unknown -> colours (N, 3)."""
    colours = LAYERS[np.clip(layer - 1, 0, len(LAYERS) - 1)]
    colours[layer > len(layer)] = UNKNOWN
    return colours


def group_colours(group: np.ndarray) -> np.ndarray:
    """Labels (N,), 0 the largest group -> colours (N, 3)."""
    return GROUPS[np.clip(group, 0, len(GROUPS) - 1)]


# The colour that each agent has as its own: by identity, the same wherever it is told of.

COLOURS = np.array(list(OWN.values()))
OTHER_WORDS = {"yellow": "gold", "purple": "plum", "cyan": "sky", "gray": "grey", "magenta": "pink"}
"""Words for colours that go by another name here."""


def identity_colours(ids: np.ndarray) -> np.ndarray:
    """Identities (N,), which begin at 1 -> colours (N, 3); from the thirteenth on they come again.

    >>> len(np.unique(identity_colours(np.arange(1, 14)), axis=0))
    12
    """
    return COLOURS[(np.asarray(ids, int) - 1) % len(COLOURS)]


def kind_colours(kinds: KindTable) -> np.ndarray:
    """The colours of kinds (K, 3), the ordinary one first: what they declare, else the most
    distinct that no other one has.

    >>> [css(one) for one in kind_colours(KindTable((), {}))]
    ['#016cff']
    """
    declared = {kind.colour.lower() for kind in kinds.kinds}
    left = (colour for colour in OWN.values() if css(colour) not in declared)
    colours = [next(left)]
    colours += [srgb(kind.colour) if kind.colour else next(left) for kind in kinds.kinds]
    return np.array(colours)


def colours_by_kind(kind: np.ndarray, kinds: KindTable) -> np.ndarray:
    """Numbers of kinds (N,), -1 of who was caught -> colours (N, 3)."""
    return np.concatenate([kind_colours(kinds), CAUGHT[None]])[kind]


def car_colours(names: Sequence[str]) -> dict[str, np.ndarray]:
    """The colours of cars by their names, which keep their order: one that is called by a colour
    has that, the others have those that are left, in turn.

    >>> [css(one) for one in car_colours(["car 2", "red"]).values()]
    ['#016cff', '#e30010']
    """
    requested: dict[str, str] = {}
    for name in names:
        words = (OTHER_WORDS.get(word, word) for word in re.findall("[a-z]+", name.lower()))
        colour = next((word for word in words if word in OWN), None)
        if colour is not None and colour not in requested.values():
            requested[name] = colour
    left = [colour for colour in OWN if colour not in requested.values()] or list(OWN)
    others = [name for name in names if name not in requested]
    assigned = requested | {name: left[k % len(left)] for k, name in enumerate(others)}
    return {name: OWN[assigned[name]] for name in names}


def frame_colours(frame: Frame) -> np.ndarray:
    """The own colours (N, 3) of the agents of a frame."""
    if frame.live is None:
        return identity_colours(frame.ids)
    colours = car_colours(frame.live.roster)
    return np.array([colours[name] for name in frame.live.names]).reshape(-1, 3)


# What to send so that the browser shows the colour that was meant.
#
# viser's canvas takes colours of instances and vertices as linear light, multiplies them by the
# light that falls on them, and passes the result through three.js's ACES filmic curve before
# encoding it as sRGB. Here that chain is undone. Very light or very saturated colours lie outside
# what the curve can give and are clipped.

_INTO_ACES = np.array(
    [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]]
)
_OUT_OF_ACES = np.array(
    [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]]
)
_FROM_ACES, _BACK = np.linalg.inv(_INTO_ACES), np.linalg.inv(_OUT_OF_ACES)
_EXPOSURE = 1.0 / 0.6

LIGHT = 1.25
"""Light on a facet turned half towards the sun, as a multiple of its own colour."""


def _inverse_aces(colour: np.ndarray) -> np.ndarray:
    """The linear light that ACES turns into the linear light `colour`, (..., 3)."""
    y = np.clip(colour @ _BACK.T, 0.0, 0.98)
    # ACES: y = (v^2 + 0.0245786 v - 0.000090537) / (0.983729 v^2 + 0.432951 v + 0.238081)
    a = 1.0 - 0.983729 * y
    b = 0.0245786 - 0.4329510 * y
    c = -0.000090537 - 0.238081 * y
    v = (-b + np.sqrt(b * b - 4.0 * a * c)) / (2.0 * a)
    return v @ _FROM_ACES.T / _EXPOSURE


def unlit_bytes(srgb: np.ndarray) -> np.ndarray:
    """Bytes for colours (..., 3) of points and of the ends of lines, which no light falls on."""
    linear = _inverse_aces(srgb_to_linear(srgb))
    return (255.0 * np.clip(linear, 0.0, 1.0) + 0.5).astype(np.uint8)


def lit_bytes(srgb: np.ndarray, light: float = LIGHT) -> np.ndarray:
    """Bytes for colours (..., 3) of mesh instances under the scene's lights."""
    linear = _inverse_aces(srgb_to_linear(srgb)) / light
    return (255.0 * np.clip(linear, 0.0, 1.0) + 0.5).astype(np.uint8)


def node_colour(srgb: np.ndarray, light: float = 1.0) -> tuple[int, int, int]:
    """Bytes for the one colour (3,) of a whole node, which three.js decodes from sRGB itself."""
    return _node_colour(tuple(np.asarray(srgb, dtype=float).tolist()), light)


@lru_cache(maxsize=1024)
def _node_colour(srgb: tuple[float, ...], light: float) -> tuple[int, int, int]:
    linear = np.clip(_inverse_aces(srgb_to_linear(np.array(srgb))) / light, 0.0, 1.0)
    red, green, blue = (255.0 * linear_to_srgb(linear) + 0.5).astype(int)
    return int(red), int(green), int(blue)
