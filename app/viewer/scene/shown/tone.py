"""What to send so that the browser shows the colour that was meant.

viser's canvas takes colours of instances and vertices as linear light, multiplies them by the
light that falls on them, and passes the result through three.js's ACES filmic curve before
encoding it as sRGB. Here that chain is undone. Very light or very saturated colours lie outside
what the curve can give and are clipped.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from app.viewer.scene.shown.oklch import decoded, encoded

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


def _before_aces(shown: np.ndarray) -> np.ndarray:
    """The linear light that ACES turns into the linear light `shown`, (..., 3)."""
    y = np.clip(shown @ _BACK.T, 0.0, 0.98)
    # ACES: y = (v^2 + 0.0245786 v - 0.000090537) / (0.983729 v^2 + 0.432951 v + 0.238081)
    a = 1.0 - 0.983729 * y
    b = 0.0245786 - 0.4329510 * y
    c = -0.000090537 - 0.238081 * y
    v = (-b + np.sqrt(b * b - 4.0 * a * c)) / (2.0 * a)
    return v @ _FROM_ACES.T / _EXPOSURE


def unlit(srgb: np.ndarray) -> np.ndarray:
    """Bytes for colours (..., 3) of points and of the ends of lines, which no light falls on."""
    linear = _before_aces(decoded(srgb))
    return (255.0 * np.clip(linear, 0.0, 1.0) + 0.5).astype(np.uint8)


def lit(srgb: np.ndarray, light: float = LIGHT) -> np.ndarray:
    """Bytes for colours (..., 3) of mesh instances under the scene's lights."""
    linear = _before_aces(decoded(srgb)) / light
    return (255.0 * np.clip(linear, 0.0, 1.0) + 0.5).astype(np.uint8)


def single(srgb: np.ndarray, light: float = 1.0) -> tuple[int, int, int]:
    """Bytes for the one colour (3,) of a whole node, which three.js decodes from sRGB itself."""
    return _single(tuple(np.asarray(srgb, dtype=float).tolist()), light)


@lru_cache(maxsize=1024)
def _single(srgb: tuple[float, ...], light: float) -> tuple[int, int, int]:
    linear = np.clip(_before_aces(decoded(np.array(srgb))) / light, 0.0, 1.0)
    red, green, blue = (255.0 * encoded(linear) + 0.5).astype(int)
    return int(red), int(green), int(blue)
