"""Attitudes: unit quaternions (w, x, y, z) that turn an agent's nose, +x, onto its heading.

Without a roll the wings stay level, so left and right can be read at a glance.
"""

from __future__ import annotations

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


def rolled(wxyz: np.ndarray, roll: np.ndarray) -> np.ndarray:
    """Quaternions (N, 4) after a roll (N,), rad, about the nose; right wing down above 0.

    >>> rolled(attitude(np.array([[1.0, 0.0]])), np.array([0.0])).tolist()
    [[1.0, 0.0, 0.0, 0.0]]
    """
    w, x, y, z = np.asarray(wxyz, dtype=float).T
    c, s = np.cos(0.5 * roll), np.sin(0.5 * roll)
    made = np.column_stack([c * w - s * x, c * x + s * w, c * y + s * z, c * z - s * y])
    return made.astype(np.float32)


def nose(wxyz: np.ndarray) -> np.ndarray:
    """The direction, (3,), in which a quaternion (4,) points the nose."""
    w, x, y, z = (float(part) for part in wxyz)
    return np.array(
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
    )
