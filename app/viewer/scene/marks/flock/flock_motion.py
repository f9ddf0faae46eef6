"""How each bird holds itself: it banks into its turns and beats its wings.

Nothing of this is computed by the flock, and nothing of the flock by this: it is for the eye, and
moves only when the flock does.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from app.viewer.scene.draw.attitude import attitude, rolled
from app.viewer.scene.draw.drawn_frame import Picture
from app.viewer.scene.draw.identities import rows_of
from app.viewer.scene.shown.frame import Frame

BEAT = 2.5
"""Wing beats per second on the screen."""
VARIETY = 0.24
"""How much the birds' beats differ, from the slowest to the quickest, as a share of BEAT."""
LONGEST_BEAT = 0.07
"""The most that wings move on from frame to frame, s; a slow flock beats slowly."""
AMPLITUDE, DIHEDRAL = 0.52, 0.10
"""Swing of the wings to each side, and the angle about which they swing, rad."""
GLIDE, GLIDING = -0.30, 0.12
"""A bird whose heading points lower than GLIDE (its vertical part) beats with this share."""
EASE = 0.45
"""Time constant with which it begins and ends to glide, s."""
LEAN = 0.30
"""Time constant with which it leans into a turn, s."""
LONGEST = 0.25
"""The most that counts as time between two frames, s: after a pause nobody jerks."""
STEEPEST = np.deg2rad(62.0)
"""Largest bank."""
NIMBLE = 0.25
"""A bird at full speed banks by 45 degrees in a turn whose radius is this share of its reach."""
DIVE, SPIN = -1.1, 5.0
"""A bird that falls: how far its nose is down, rad, and how fast it turns, rad/s."""
FOLDED, FLAT = 0.75, 0.02
"""Angle of the wings of one that falls, and of one that lies, rad."""
GOLDEN = 0.6180339887498949


class Poses(NamedTuple):
    """Of all birds of a frame."""

    wxyz: np.ndarray
    """Attitudes, (N, 4)."""
    beat: np.ndarray
    """Angle of the wings above level, (N,), rad."""


class FlockMotion:
    """Follows one flock from frame to frame; birds keep what they had through changes of rows."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._forget()

    def _forget(self) -> None:
        self._run: tuple[int, int] | None = None
        self._tick = 0
        self._seen = self._clock()
        self._beats = 0.0
        """Time that the wings have been beaten for, s."""
        self._ids = np.empty(0, dtype=int)
        self._heading = np.empty((0, 3))
        self._lean = np.empty(0)
        """Smoothed tangent of the bank, above 0 to the left."""
        self._effort = np.empty(0)
        """Share of the full swing."""
        self.poses = Poses(np.empty((0, 4)), np.empty(0))
        """Of the frame that was followed last."""

    def follow(self, picture: Picture) -> Poses:
        """The birds of the next frame of a flock in space."""
        frame = picture.frame
        run = (frame.run, frame.dim)
        if self._run != run or frame.tick < self._tick:
            self._forget()
            self._run, self._tick = run, frame.tick
        heading = np.asarray(frame.heading, dtype=float)
        self._meet(frame.ids, heading)
        now = self._clock()
        passed, ticks = min(now - self._seen, LONGEST), frame.tick - self._tick
        self._seen, self._tick = now, frame.tick
        if ticks > 0:
            self._beats += min(passed, LONGEST_BEAT)
            lean = leaning(frame, turned(self._heading, heading) / (ticks * frame.dt))
            self._lean += (1.0 - np.exp(-passed / LEAN)) * (lean - self._lean)
            effort = efforts(heading)
            self._effort += (1.0 - np.exp(-passed / EASE)) * (effort - self._effort)
        self._heading = heading.copy()
        wxyz = rolled(picture.wxyz, -np.arctan(self._lean))
        phase = 2.0 * np.pi * (self._beats * rhythm(frame.ids) + frame.ids * GOLDEN)
        beat = DIHEDRAL + AMPLITUDE * self._effort * np.sin(phase)
        self.poses = self._lying(picture, Poses(wxyz, beat))
        return self.poses

    def _meet(self, ids: np.ndarray, heading: np.ndarray) -> None:
        """Carry what is known over to the rows of these identities; newcomers fly level."""
        if np.array_equal(ids, self._ids):
            return
        rows, known = rows_of(self._ids, ids)
        before, lean, effort = self._heading, self._lean, self._effort
        self._heading, self._lean = heading.copy(), np.zeros(len(ids))
        self._effort = efforts(heading)
        self._heading[known] = before[rows]
        self._lean[known], self._effort[known] = lean[rows], effort[rows]
        self._ids = ids.copy()

    def _lying(self, picture: Picture, poses: Poses) -> Poses:
        """Those that have crashed: nose down while they fall, then flat."""
        frame = picture.frame
        down = frame.down
        if not down.any():
            return poses
        falling = down & (frame.speed > 0.0)
        azimuth = np.arctan2(frame.heading[:, 1], frame.heading[:, 0])
        azimuth = azimuth + np.where(falling, SPIN * self._beats, 0.0) + frame.ids * GOLDEN
        nose = np.where(falling, DIVE, 0.0)
        heading = np.column_stack(
            [np.cos(azimuth) * np.cos(nose), np.sin(azimuth) * np.cos(nose), np.sin(nose)]
        )
        wxyz, beat = poses.wxyz.copy(), poses.beat.copy()
        wxyz[down] = attitude(heading[down])
        beat[down] = np.where(falling[down], FOLDED, FLAT)
        return Poses(wxyz, beat)


def leaning(frame: Frame, rate: np.ndarray) -> np.ndarray:
    """v omega / g', the tangents (N,) of the banks that suit turns to the left at a rate (N,).

    The rate is in rad per unit of the flock's time; g' is chosen for the flock's own scale.
    """
    reach = frame.reach if np.isfinite(frame.reach) else float(np.max(frame.size))
    pull = frame.speed_scale**2 / (NIMBLE * max(reach, 1e-9))
    most = np.tan(STEEPEST)
    return np.clip(frame.speed * rate / max(pull, 1e-12), -most, most)


def turned(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """How far headings (N, 3) have turned to their left, (N,), rad, at most a right angle."""
    level = np.hypot(before[:, 0], before[:, 1])
    level = np.where(level > 1e-9, level, np.inf)
    left = (before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]) / level
    return np.arcsin(np.clip(left, -1.0, 1.0))


def efforts(heading: np.ndarray) -> np.ndarray:
    """The share of the full swing that birds with headings (N, 3) beat with, (N,)."""
    return np.where(heading[:, 2] < GLIDE, GLIDING, 1.0)


def rhythm(ids: np.ndarray) -> np.ndarray:
    """Beats per second of each bird, (N,); by its identity, so that no two beat together."""
    return BEAT * (1.0 + VARIETY * ((ids * GOLDEN * GOLDEN) % 1.0 - 0.5))
