"""Velocities and headings of tracks, smoothed over a window that is said beside every result.

Savitzky-Golay: a parabola is fitted to the w = 2 m + 1 places around each frame; its middle is the
smoothed place, its slope the velocity, its curvature the acceleration (Savitzky and Golay 1964).
Nothing is computed across a gap: a gap of g frames costs g + 2 m.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from app.tracks.tracks import EVEN, Tracks
from worlds.input_error import InputError
from worlds.number_text import counted

DEFAULT_FRAMES = 5
"""Of a window that nobody asked for."""
ROBUST = 0.6744897501960817
"""The median size of normal errors, in standard deviations."""


@dataclass(frozen=True, eq=False)
class SmoothedMotion:
    """Where individuals are and how they move, NaN where a window is not whole.

    `smoothed_motion` makes it of tracks; in memory it may be made of velocities from elsewhere.
    """

    position: np.ndarray
    """(T, N, dim), in the unit of the tracks."""
    velocity: np.ndarray
    """(T, N, dim), unit/s."""
    acceleration: np.ndarray | None = None
    """(T, N, dim), unit/s^2; None where only differences are taken."""
    frames: int = 0
    """Of the window, odd; 0 where velocities are differences from frame to frame."""
    step: float = math.nan
    """Seconds from frame to frame."""
    noise: float = math.nan
    """Standard deviation of a coordinate, in `unit`, from what the parabolas leave; NaN if the
    window is too short to tell."""
    unit: str = ""
    least_speed: float = 0.0
    """unit/s, below which there is no heading."""
    pointing: np.ndarray | None = None
    """(T, N, dim) unit vectors, if headings are those of the file and not of the velocity."""

    @property
    def window(self) -> float:
        """Seconds that the window spans, from its first frame to its last."""
        return (max(self.frames, 2) - 1) * self.step

    @property
    def velocity_noise(self) -> float:
        """Standard deviation of a component of the velocity that `noise` makes, unit/s."""
        return velocity_noise(self.noise, self.frames, self.step)

    @cached_property
    def speed(self) -> np.ndarray:
        """(T, N), unit/s."""
        return np.sqrt((self.velocity**2).sum(axis=2))

    @cached_property
    def heading(self) -> np.ndarray:
        """(T, N, dim) unit vectors, NaN below `least_speed` and where nobody moves."""
        moves = (self.speed > 0.0) & (self.speed >= self.least_speed)
        if self.pointing is not None:
            length = np.sqrt((self.pointing**2).sum(axis=2))
            points = (length > 0.0) & ((self.least_speed == 0.0) | moves)
            return self.pointing / np.where(points, length, np.nan)[..., None]
        speed = np.where(moves, self.speed, np.nan)
        return self.velocity / speed[..., None]

    @cached_property
    def turn(self) -> np.ndarray:
        """How fast headings turn to the left, (T, N), rad/s; NaN in space, and without headings.

        From velocity and acceleration of one parabola; else from a heading to the next.
        """
        heading = self.heading
        if heading.shape[2] != 2:
            return np.full(heading.shape[:2], np.nan)
        if self.acceleration is not None and self.pointing is None:
            across = _cross(self.velocity, self.acceleration)
            return np.where(np.isfinite(heading[..., 0]), across / self.speed**2, np.nan)
        turn = np.full(heading.shape[:2], np.nan)
        along = (heading[1:] * heading[:-1]).sum(axis=2)
        turn[:-1] = np.arctan2(_cross(heading[:-1], heading[1:]), along) / self.step
        return turn

    def describe(self) -> str:
        """Window, noise and least speed as one line.

        >>> still = np.zeros((3, 1, 2))
        >>> SmoothedMotion(still, still, frames=5, step=0.04, unit="m").describe()
        'window 5 frames (0.16 s)'
        """
        words = (
            f"window {counted(self.frames, 'frame')} ({self.window:.3g} s)"
            if self.frames
            else f"differences between frames ({self.step:.3g} s), not smoothed"
        )
        if math.isfinite(self.noise):
            words += (
                f"; noise of places {self.noise:.2g} {self.unit}, so of velocities "
                f"{self.velocity_noise:.2g} {self.unit}/s"
            )
        if self.least_speed:
            words += f"; no heading below {self.least_speed:g} {self.unit}/s"
        return words + ("; headings are those of the file" if self.pointing is not None else "")


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def velocity_noise(noise: float, frames: int, step: float) -> float:
    """Noise of a component of the velocity that noise of a coordinate makes, per second.

    `s / (h sqrt(2 sum k^2))`, k = 1 ... m, for a window of 2 m + 1 frames that are h apart; for
    differences between frames (`frames` 0) `s sqrt(2) / h`.

    >>> velocity_noise(1.0, 3, 0.5), round(velocity_noise(1.0, 5, 0.04), 6)
    (1.414213562373095, 7.905694)
    """
    if not frames:
        return noise * math.sqrt(2.0) / step
    m = frames // 2
    return noise / (step * math.sqrt(2.0 * m * (m + 1) * (2 * m + 1) / 6.0))


def window_frames(seconds: float, step: float) -> int:
    """The odd number of frames, at least 3, that spans nearest to so many seconds.

    >>> window_frames(0.3, 0.04), window_frames(0.0, 0.04), window_frames(0.08, 0.04)
    (9, 3, 3)
    """
    return 2 * max(1, math.floor(seconds / (2.0 * step) + 0.5)) + 1


def smoothed_motion(
    tracks: Tracks,
    window: float | None = None,
    least_speed: float = 0.0,
    *,
    use_file_headings: bool = False,
) -> SmoothedMotion:
    """How the individuals of tracks move.

    Parameters
    ----------
    window: s, of which the nearest odd number of frames is taken, at least 3; None for
        DEFAULT_FRAMES; 0 for differences from the frame before, without smoothing.
    least_speed: unit/s >= 0, below which an individual has no heading.
    use_file_headings: take headings from the file, which must have them.

    Raises InputError, also if no individual is seen in a whole window.
    """
    if window is not None and not 0.0 <= window < math.inf:
        raise InputError(f"window = {window:g} s is not allowed: a finite time >= 0 is needed")
    if not 0.0 <= least_speed < math.inf:
        raise InputError(
            f"least speed = {least_speed:g} {tracks.unit}/s is not allowed: a number >= 0 is needed"
        )
    if use_file_headings and tracks.heading is None:
        raise InputError(f"{tracks.name} holds no headings: take those of the velocity")
    if len(tracks.frame) < 2:
        raise InputError(f"{tracks.name} has one frame alone: there is no velocity")
    place = unwrap_places(tracks.position, tracks.period)
    place = np.where(tracks.seen[..., None], place, np.nan)
    skips = np.flatnonzero(np.abs(np.diff(tracks.time) - tracks.step) > EVEN * tracks.step)
    pointing = tracks.heading if use_file_headings else None
    if window == 0.0:
        velocity = np.full(place.shape, np.nan)
        velocity[1:] = np.diff(place, axis=0) / np.diff(tracks.time)[:, None, None]
        velocity[skips + 1] = np.nan
        if not np.isfinite(velocity).any():
            raise InputError(f"{tracks.name}: nobody is seen in two frames that follow each other")
        return SmoothedMotion(
            tracks.position, velocity, None, 0, tracks.step, math.nan, tracks.unit, least_speed,
            pointing,
        )  # fmt: skip
    frames = DEFAULT_FRAMES if window is None else window_frames(window, tracks.step)
    smooth, slope, curve = fit_parabolas(place, frames, tracks.step)
    m = frames // 2
    for skip in skips:  # frames skip-m+1 ... skip+m have both sides of it in their window
        for array in (smooth, slope, curve):
            array[max(skip - m + 1, 0) : skip + m + 1] = np.nan
    if not np.isfinite(slope).any():
        raise InputError(
            f"{tracks.name}: nobody is seen for {frames} frames without a gap, the window of "
            f"{(frames - 1) * tracks.step:.3g} s: take a shorter one"
        )
    noise = math.nan
    if frames > 3:
        error = float(np.nanmedian(np.abs(place - smooth))) / ROBUST
        noise = error / math.sqrt(1.0 - middle_weight(m))
    if any(tracks.period):
        side = np.array(tracks.period)
        smooth = np.where(side > 0.0, np.mod(smooth, np.where(side > 0.0, side, 1.0)), smooth)
    return SmoothedMotion(
        smooth, slope, curve, frames, tracks.step, noise, tracks.unit, least_speed, pointing
    )


def middle_weight(m: int) -> float:
    """What the middle frame weighs in its own smoothed place, of a window of 2 m + 1 frames.

    >>> [round(middle_weight(m), 6) for m in (1, 2, 3)]
    [1.0, 0.485714, 0.333333]
    """
    n = 2 * m + 1
    return 3.0 * (3.0 * n * n - 7.0) / (4.0 * n * (n * n - 4.0))


def unwrap_places(position: np.ndarray, period: tuple[float, ...]) -> np.ndarray:
    """Places (T, N, dim) as if axes with a period went on for ever, from each gap to the next."""
    if not any(period):
        return position
    side = np.array(period)
    step = np.diff(position, axis=0)
    turns = np.round(np.where(np.isfinite(step), step, 0.0) / np.where(side > 0.0, side, np.inf))
    unwrapped = position.copy()
    unwrapped[1:] -= np.cumsum(turns, axis=0) * side
    return unwrapped


def fit_parabolas(
    place: np.ndarray, frames: int, step: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Value, slope and curvature in the middle of a parabola over `frames` frames, an odd number.

    `place` is (T, N, dim), frames `step` s apart. NaN where not all of a window is there.
    """
    from scipy.ndimage import correlate1d

    m = frames // 2
    k = np.arange(-m, m + 1.0)
    s2, s4 = (k**2).sum(), (k**4).sum()
    spread = frames * s4 - s2 * s2
    weights = (s4 - s2 * k**2) / spread, k / (s2 * step), 2.0 * (frames * k**2 - s2) / spread
    results = [correlate1d(place, w, axis=0, mode="constant", cval=np.nan) for w in weights]
    return results[0], results[1], results[2] / (step * step)
