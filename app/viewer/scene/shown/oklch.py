"""Perceptually even colours: OKLCH (lightness, chroma, hue) to sRGB.

Source: B. Ottosson, "A perceptual color space for image processing" (2020).
"""

from __future__ import annotations

import numpy as np

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


def encoded(linear: np.ndarray) -> np.ndarray:
    """Linear light in [0, 1] -> sRGB in [0, 1]."""
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def decoded(srgb: np.ndarray) -> np.ndarray:
    """sRGB in [0, 1] -> linear light in [0, 1]."""
    srgb = np.clip(srgb, 0.0, 1.0)
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def _linear(lightness: np.ndarray, chroma: np.ndarray, hue: np.ndarray) -> np.ndarray:
    lab = np.stack([lightness, chroma * np.cos(hue), chroma * np.sin(hue)], axis=-1)
    return (lab @ _LMS_FROM_LAB.T) ** 3 @ _RGB_FROM_LMS.T


def _shown(lightness: np.ndarray, chroma: np.ndarray, hue: np.ndarray) -> np.ndarray:
    """Whether sRGB can show these colours."""
    linear = _linear(lightness, chroma, hue)
    return np.all((linear >= -1e-6) & (linear <= 1.0 + 1e-6), axis=-1)


def attainable(lightness: np.ndarray, chroma: np.ndarray, hue: np.ndarray) -> np.ndarray:
    """The largest chroma up to `chroma` that sRGB can show at these lightnesses and hues."""
    low, high = np.zeros_like(chroma), chroma.copy()
    for _ in range(20):
        middle = 0.5 * (low + high)
        shown = _shown(lightness, middle, hue)
        low, high = np.where(shown, middle, low), np.where(shown, high, middle)
    return np.where(_shown(lightness, chroma, hue), chroma, low)


def oklch(lightness: np.ndarray, chroma: np.ndarray, hue: np.ndarray) -> np.ndarray:
    """Lightness [0, 1], chroma [0, 0.4) and hue [rad] -> sRGB (..., 3) in [0, 1].

    A chroma that sRGB cannot show at that lightness and hue is lowered until it can, so that
    lightness and hue stay true.
    """
    lightness, chroma, hue = np.broadcast_arrays(
        *(np.asarray(part, dtype=float) for part in (lightness, chroma, hue))
    )
    return encoded(_linear(lightness, attainable(lightness, chroma, hue), hue))
