"""Frames of tracks from which the next one is foretold, for a fit and held back from it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from app.tracks.fit.tick_scale import TickScale
from app.tracks.motion import SmoothedMotion, smoothed_motion
from app.tracks.tracks import Tracks
from worlds.input_error import InputError
from worlds.number_text import counted

LEAST_INDIVIDUALS = 2
"""That are foretold in a frame that counts."""
LEAST_FRAMES = 10
"""Of a fit, and as many held back."""


@dataclass(frozen=True, eq=False)
class FrameSample:
    """Some frames, and the headings a tick later; in lengths of the model.

    Individuals without place or heading in a frame have NaN there, and are not in its flock.
    """

    position: np.ndarray
    """(F, N, dim)."""
    heading: np.ndarray
    """(F, N, dim), unit vectors."""
    speed: np.ndarray
    """(F, N), length per second."""
    following: np.ndarray
    """(F, N, dim), headings a tick later; NaN where they are not known."""
    frame: np.ndarray
    """(F,), the numbers of the frames."""

    @cached_property
    def present(self) -> np.ndarray:
        """(F, N) bool: who is in the flock."""
        return np.isfinite(self.position).all(axis=2) & np.isfinite(self.heading).all(axis=2)

    @cached_property
    def judged(self) -> np.ndarray:
        """(F, N) bool: whose next heading is compared."""
        return self.present & np.isfinite(self.following).all(axis=2)

    @cached_property
    def digest(self) -> str:
        """A hash of all its numbers."""
        digest = hashlib.sha256()
        for array in (self.position, self.heading, self.speed, self.following):
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()[:16]

    def with_shuffled_headings(self, seed: int) -> FrameSample:
        """The same places, with each individual's headings in another order of the frames.

        Heading, speed and next heading stay together, so that how far each turns in a tick is what
        it was, and only whom it may have followed is not.
        """
        rng = np.random.default_rng(seed)
        heading, following, speed = self.heading.copy(), self.following.copy(), self.speed.copy()
        for row in range(self.heading.shape[1]):
            at = np.flatnonzero(self.judged[:, row])
            mixed = rng.permutation(at)
            for array, before in (
                (heading, self.heading),
                (following, self.following),
                (speed, self.speed),
            ):
                array[at, row] = before[mixed, row]
        return replace(self, heading=heading, following=following, speed=speed)


@dataclass(frozen=True, eq=False)
class HeldBackFrames:
    """The frames of a fit, those held back from it, and the window that both are smoothed over."""

    fitted: FrameSample
    held_back: FrameSample
    motion: SmoothedMotion

    @property
    def window(self) -> float:
        """Seconds of the window, 0 without smoothing."""
        return self.motion.window if self.motion.frames else 0.0


def sample_frames(
    tracks: Tracks,
    scale: TickScale,
    window: float,
    frames: int = 40,
    least_speed: float = 0.0,
    use_file_headings: bool = False,
    chosen: tuple[np.ndarray, np.ndarray] | None = None,
) -> HeldBackFrames:
    """Frames of the first half of the time for a fit, and of the second half held back.

    `frames` of each half at most, spread evenly; or `chosen`, rows of the tracks for each half, so
    that a second window looks at the same frames. Raises InputError for too few.
    """
    if len(tracks.ids) < LEAST_INDIVIDUALS:
        raise InputError(f"{tracks.name} has 1 individual: a fit needs {LEAST_INDIVIDUALS} or more")
    demand_even(tracks)
    motion = smoothed_motion(tracks, window, least_speed, use_file_headings=use_file_headings)
    heading, k = motion.heading, scale.every
    known = np.isfinite(heading).all(axis=2) & np.isfinite(motion.position).all(axis=2)
    apart = np.abs(tracks.time[k:] - tracks.time[:-k] - k * tracks.step) <= 0.01 * k * tracks.step
    judged = (known[:-k] & known[k:]).sum(axis=1)
    usable = np.flatnonzero(apart & (judged >= LEAST_INDIVIDUALS) & is_most(tracks, known)[:-k])
    if chosen is None:
        chosen = split_frames(tracks, usable, frames, motion.frames + k)
    else:
        chosen = np.intersect1d(chosen[0], usable), np.intersect1d(chosen[1], usable)
        demand_enough(tracks, chosen, len(usable))
    period = np.array(tracks.period or (0.0,) * tracks.dim)
    place = np.where(period > 0.0, np.mod(motion.position, np.where(period > 0, period, 1.0)),
                     motion.position)  # fmt: skip

    def sample(at: np.ndarray) -> FrameSample:
        return FrameSample(
            position=place[at] / scale.length,
            heading=np.where(known[at][..., None], heading[at], np.nan),
            speed=motion.speed[at] / scale.length,
            following=heading[at + k],
            frame=tracks.frame[at],
        )

    return HeldBackFrames(sample(chosen[0]), sample(chosen[1]), motion)


def is_most(tracks: Tracks, known: np.ndarray) -> np.ndarray:
    """(T,) bool: whether of those seen in a frame half or more have a heading."""
    return 2 * known.sum(axis=1) >= tracks.seen.sum(axis=1)


def split_frames(
    tracks: Tracks, usable: np.ndarray, frames: int, apart: int
) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the first and the second half of what is usable, `apart` rows between the halves."""
    if not len(usable):
        demand_enough(tracks, (usable, usable), 0)
    middle = usable[len(usable) // 2]
    halves = usable[usable < middle], usable[usable >= min(middle + apart, len(tracks.frame))]
    demand_enough(tracks, halves, len(usable))
    first, second = (
        half[np.unique(np.linspace(0, len(half) - 1, min(frames, len(half))).round().astype(int))]
        for half in halves
    )
    return first, second


def demand_enough(tracks: Tracks, halves: tuple[np.ndarray, ...], usable: int) -> None:
    """Raise InputError where there are too few frames for a fit, or to hold back."""
    if min(map(len, halves)) < LEAST_FRAMES:
        raise InputError(
            f"{tracks.name} has {counted(usable, 'frame')} from which the next can be foretold: a "
            f"fit needs {LEAST_FRAMES} in each half of the time, and some between"
        )


def demand_even(tracks: Tracks) -> None:
    """Raise InputError where frames are mostly not one step apart, as derivatives need them."""
    if len(tracks.time) > 1 and not tracks.is_even:
        step = tracks.step
        even = np.mean(np.abs(np.diff(tracks.time) - step) <= 0.01 * step)
        if even < 0.5:
            raise InputError(
                f"{tracks.name}: {1.0 - even:.0%} of the times between frames are not the median, "
                f"{step:.4g} s: a fit needs frames at an even rate"
            )
