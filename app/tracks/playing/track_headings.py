"""Headings and speeds of tracks for those who play them: smoothed, and held through gaps."""

from __future__ import annotations

import numpy as np

from app.tracks.motion import smoothed_motion
from app.tracks.tracks import Tracks
from worlds.input_error import InputError


def headings_and_speeds(tracks: Tracks, window: float | None = None) -> tuple[np.ndarray, ...]:
    """Unit headings (T, N, dim) and speeds (T, N), in `unit`/s, of all individuals at all frames.

    Headings are the file's own where it has them, else those of the velocity, which is smoothed
    over `window` seconds, by default five frames; beside a gap, where no window is whole, it is the
    difference of the frames beside. Where an individual does not move or is not seen, it keeps its
    last heading, and before the first one it has that.
    """
    velocity = differences(tracks)
    try:
        smooth = smoothed_motion(tracks, window).velocity
    except InputError:  # nobody is seen for so long
        smooth = np.full(velocity.shape, np.nan)
    velocity = np.where(np.isfinite(smooth), smooth, velocity)
    speed = np.linalg.norm(velocity, axis=2)
    heading = np.full(velocity.shape, np.nan, np.float32)
    moving = np.isfinite(speed) & (speed > 0.0)
    heading[moving] = velocity[moving] / speed[moving][:, None]
    if tracks.heading is not None:
        own = np.isfinite(tracks.heading).all(axis=2)
        heading[own] = tracks.heading[own]
    return hold(heading), np.nan_to_num(speed)


def differences(tracks: Tracks) -> np.ndarray:
    """Velocities (T, N, dim) from the frame before to the one after, of those seen in both; at the
    ends of a stretch from one side. NaN where there is no other frame beside it."""
    place, time = tracks.position, tracks.time
    velocity = np.full(place.shape, np.nan)
    if len(time) < 2:
        return velocity
    way = np.diff(place, axis=0)
    for axis, side in enumerate(tracks.period):
        if side > 0.0:
            way[..., axis] -= side * np.round(way[..., axis] / side)
    step = np.diff(time)[:, None, None]
    rate = way / step
    velocity[1:] = rate
    velocity[:-1] = np.where(np.isfinite(velocity[:-1]), velocity[:-1], rate)
    both = (way[:-1] + way[1:]) / (step[:-1] + step[1:])
    velocity[1:-1] = np.where(np.isfinite(both), both, velocity[1:-1])
    velocity[~tracks.seen] = np.nan
    return velocity


def hold(heading: np.ndarray) -> np.ndarray:
    """Headings (T, N, dim) with none missing: the last one is kept, before the first it is that."""
    frames, count, dim = heading.shape
    known = np.isfinite(heading).all(axis=2)
    last = np.maximum.accumulate(np.where(known, np.arange(frames)[:, None], -1), axis=0)
    index = np.where(last < 0, np.argmax(known, axis=0), last)
    held = heading[index, np.arange(count)]
    held[:, ~known.any(axis=0)] = np.eye(dim)[0]
    return held
