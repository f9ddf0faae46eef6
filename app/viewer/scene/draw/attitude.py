"""Attitudes: unit quaternions (w, x, y, z) that turn an agent's nose, +x, onto its heading.

Without a roll the wings stay level, so left and right can be read at a glance.
"""

from __future__ import annotations

import math

import numpy as np


def attitude(heading: np.ndarray) -> np.ndarray:
    """Headings (N, 2) or (N, 3), unit vectors -> quaternions (N, 4), float32.

    A turn by the azimuth about z after a turn by minus the elevation about y.

    >>> attitude(np.array([[1.0, 0.0]])).tolist()
    [[1.0, 0.0, 0.0, 0.0]]
    """
    heading = np.asarray(heading, dtype=float)
    half_azimuth = 0.5 * np.arctan2(heading[:, 1], heading[:, 0])
    wxyz = np.zeros((len(heading), 4), dtype=np.float32)
    if heading.shape[1] == 2:
        wxyz[:, 0] = np.cos(half_azimuth)
        wxyz[:, 3] = np.sin(half_azimuth)
        return wxyz
    level = np.hypot(heading[:, 0], heading[:, 1])
    half_pitch = -0.5 * np.arctan2(heading[:, 2], level)
    cos_a, sin_a = np.cos(half_azimuth), np.sin(half_azimuth)
    cos_p, sin_p = np.cos(half_pitch), np.sin(half_pitch)
    wxyz[:, 0] = cos_a * cos_p
    wxyz[:, 1] = -sin_a * sin_p
    wxyz[:, 2] = cos_a * sin_p
    wxyz[:, 3] = sin_a * cos_p
    return wxyz


def roll_attitudes(wxyz: np.ndarray, roll: np.ndarray) -> np.ndarray:
    """Quaternions (N, 4) after a roll (N,), rad, about the nose; right wing down above 0.

    >>> roll_attitudes(attitude(np.array([[1.0, 0.0]])), np.array([0.0])).tolist()
    [[1.0, 0.0, 0.0, 0.0]]
    """
    w, x, y, z = np.asarray(wxyz, dtype=float).T
    c, s = np.cos(0.5 * roll), np.sin(0.5 * roll)
    rotated = np.column_stack([c * w - s * x, c * x + s * w, c * y + s * z, c * z - s * y])
    return rotated.astype(np.float32)


def yaw_attitudes(wxyz: np.ndarray, yaw: np.ndarray) -> np.ndarray:
    """Quaternions (N, 4) after a turn (N,), rad, about what is up for each; above 0 to its left.

    >>> yaw_attitudes(attitude(np.array([[1.0, 0.0]])), np.array([0.0])).tolist()
    [[1.0, 0.0, 0.0, 0.0]]
    """
    w, x, y, z = np.asarray(wxyz, dtype=float).T
    c, s = np.cos(0.5 * yaw), np.sin(0.5 * yaw)
    rotated = np.column_stack([c * w - s * z, c * x + s * y, c * y - s * x, c * z + s * w])
    return rotated.astype(np.float32)


def ahead_directions(wxyz: np.ndarray) -> np.ndarray:
    """The direction of the nose, (N, 3), of agents of attitudes (N, 4)."""
    w, x, y, z = wxyz.T
    return np.column_stack(
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)]
    )


def left_directions(wxyz: np.ndarray) -> np.ndarray:
    """The direction of the left side, (N, 3), of agents of attitudes (N, 4)."""
    w, x, y, z = wxyz.T
    return np.column_stack(
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)]
    )


def up_directions(wxyz: np.ndarray) -> np.ndarray:
    """The direction over the back, (N, 3), of agents of attitudes (N, 4)."""
    w, x, y, z = wxyz.T
    return np.column_stack(
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)]
    )


def hinge_offsets(wxyz: np.ndarray, hinge: tuple[float, float, float]) -> np.ndarray:
    """From the middles of agents of attitudes (N, 4) to a point ahead, left and up, (N, 3)."""
    directions = (ahead_directions, left_directions, up_directions)
    parts = [far * one(wxyz) for far, one in zip(hinge, directions, strict=True) if far]
    return np.sum(parts, axis=0) if parts else np.zeros((len(wxyz), 3))


def nose(wxyz: np.ndarray) -> np.ndarray:
    """The direction, (3,), in which a quaternion (4,) points the nose."""
    w, x, y, z = (float(part) for part in wxyz)
    return np.array(
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
    )


# Places and attitudes as browsers are sent them: so fine that nobody sees it, and no finer.
#
# What lies beyond is noise, of which a line that packs what it carries can make nothing.

FINE = 2.0**-10
"""The widest step. The displayed world is about 10 units wide: where that is 4 000 pixels, a step
is 0.4 of them."""
OF_LENGTH = 1 / 256
"""A step as a share of an agent's length, at most: one may come close to small ones."""

ROUND = 1024
"""Azimuths of who is level; as few are found again by what packs, and 0.35 degrees are no pixel."""
OTHERWISE = 2.0**-11
"""Step of the attitudes of others."""

half = np.pi * np.arange(2 * ROUND) / ROUND
LEVEL = np.column_stack([np.cos(half), 0.0 * half, 0.0 * half, np.sin(half)]).astype(np.float32)
"""All attitudes of who is level, (2 ROUND, 4)."""


def rounded_places(at: np.ndarray, length: float) -> np.ndarray:
    """Places (N, 3) of agents of some length, in steps that are a power of 2, float32.

    >>> rounded_places(np.array([[1.0 / 3.0, 0.0, 0.0]]), length=0.2)[0, 0]
    np.float32(0.3334961)
    """
    step = min(FINE, 2.0 ** math.floor(math.log2(max(OF_LENGTH * length, 1e-9))))
    return round_to_step(at, step)


def quantise_attitudes(wxyz: np.ndarray) -> np.ndarray:
    """Attitudes (N, 4) to one of not too many, float32.

    >>> quantise_attitudes(np.array([[1.0, 0.0, 0.0, 0.001]])).tolist()
    [[1.0, 0.0, 0.0, 0.0]]
    """
    if wxyz[:, 1:3].any():
        return round_to_step(wxyz, OTHERWISE)
    place = np.rint(np.arctan2(wxyz[:, 3], wxyz[:, 0]) * (ROUND / np.pi)).astype(int)
    return LEVEL[place % (2 * ROUND)]


def round_to_step(numbers: np.ndarray, step: float) -> np.ndarray:
    """Numbers to the nearest step, float32."""
    return np.asarray(np.rint(np.multiply(numbers, 1.0 / step)) * step, np.float32)
