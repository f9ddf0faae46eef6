"""What may be wrong with tracks: swaps, jumps, two names on one body, rows at rest, gaps.

Nothing is changed: what is found is told, with who and when, so that its owner can look at the
video. All is found by what no animal does: a step far beyond the others, a place that another has
had, two individuals in one place for many frames.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from app.tracks.tracks import Tracks
from worlds.number_text import counted

FEW = 10
"""Cases of each kind that are told one by one."""
FAR_STEP = 8.0
"""Times the 95 % speed from which a step is a jump."""
ONE_BODY = 0.15
"""Part of the median distance to the nearest below which two are taken for one body."""
TOGETHER = 10
"""Frames in a row for which two lie on one body."""
LONGEST_REST = 0.5
"""Part of the steps of an individual that are exactly 0 from which it is told."""
MOST_PAIRS_OF_FRAME = 2_000_000
"""Pairs of individuals of a frame that are looked at."""


@dataclass(frozen=True)
class TrackFlag:
    """Something that may be wrong, with some cases of it."""

    kind: str
    """A word: "jump", "swap", "one-body", "rest", "uneven", "short", "dropped"."""
    text: str
    """For people, a line."""
    count: int
    cases: tuple[dict[str, Any], ...] = ()
    """The first FEW: individuals, frames, and how far."""


@dataclass(frozen=True)
class TrackReport:
    """What tracks hold, and what may be wrong with them."""

    tracks: Tracks
    flags: tuple[TrackFlag, ...] = ()
    values: dict[str, Any] = field(default_factory=dict)

    @property
    def is_sound(self) -> bool:
        """Whether nothing was flagged."""
        return not self.flags


def describe_tracks(tracks: Tracks) -> dict[str, Any]:
    """What tracks hold, as JSON has it: size, rate, unit, extent, how much is seen, gaps."""
    seen = tracks.seen
    counts = seen.sum(axis=1)
    low, high = tracks.extent if seen.any() else (np.full(tracks.dim, math.nan),) * 2
    lengths = gap_lengths(seen)
    return {
        "name": tracks.name,
        "format": tracks.format,
        "individuals": len(tracks.ids),
        "frames": len(tracks.frame),
        "first_frame": int(tracks.frame[0]),
        "last_frame": int(tracks.frame[-1]),
        "seconds": float(tracks.time[-1] - tracks.time[0]),
        "rate": tracks.rate,
        "even": tracks.is_even,
        "unit": tracks.unit,
        "dim": tracks.dim,
        "low": low.tolist(),
        "high": high.tolist(),
        "places": int(seen.sum()),
        "seen": float(seen.mean()),
        "seen_at_once": [int(counts.min()), float(np.median(counts)), int(counts.max())],
        "gaps": len(lengths),
        "longest_gap": int(lengths.max(initial=0)),
        "filled": int(tracks.filled.sum()) if tracks.filled is not None else 0,
        "heading": tracks.heading is not None,
        "confidence": tracks.confidence is not None,
        "period": list(tracks.period),
        "boundary": bool(tracks.boundary),
        "ids": list(tracks.ids[:1000]),
        "dropped": [{"rows": one.rows, "reason": one.reason} for one in tracks.dropped],
        "notes": list(tracks.notes),
    }


def gap_lengths(seen: np.ndarray) -> np.ndarray:
    """Frames of each gap between two frames (T, N) in which an individual is seen."""
    places = np.arange(len(seen))[:, None]
    before = np.maximum.accumulate(np.where(seen, places, -1), axis=0)
    at, row = np.nonzero(seen[1:] & ~seen[:-1] & (before[:-1] >= 0))
    return at - before[:-1][at, row]


def check_tracks(tracks: Tracks) -> TrackReport:
    """What may be wrong with tracks; see `TrackFlag`. Takes seconds for ten million places."""
    steps = steps_of(tracks)
    found = [
        *jumps_and_swaps(tracks, steps),
        one_body(tracks),
        rests(tracks, steps),
        uneven(tracks),
        short(tracks),
        *(TrackFlag("dropped", str(one), one.rows) for one in tracks.dropped),
    ]
    flags = tuple(one for one in found if one is not None and one.count)
    return TrackReport(tracks, flags, describe_tracks(tracks))


def ways(tracks: Tracks, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """From places to places (..., dim), the short way where an axis wraps."""
    way = end - start
    for axis, side in enumerate(tracks.period):
        if side > 0.0:
            way[..., axis] -= side * np.round(way[..., axis] / side)
    return way


def steps_of(tracks: Tracks) -> np.ndarray:
    """How far each goes from a frame to the next, (T - 1, N), NaN where it is not seen in both."""
    return np.linalg.norm(ways(tracks, tracks.position[:-1], tracks.position[1:]), axis=2)


def case(tracks: Tracks, at: int, rows: list[int], **more: float) -> dict[str, Any]:
    """A case: the frame, who, and numbers."""
    return {
        "frame": int(tracks.frame[at]),
        "ids": [tracks.ids[row] for row in rows],
        **{name: float(f"{value:.6g}") for name, value in more.items()},
    }


def jumps_and_swaps(tracks: Tracks, steps: np.ndarray) -> list[TrackFlag]:
    """Steps that are far too long, and those of them that are two who change places.

    Two have changed places where both jump to the next frame, and each lands nearer to where the
    other would be than to where it would be itself.
    """
    if not len(steps):
        return []
    speeds = steps / np.diff(tracks.time)[:, None]
    moving = speeds[np.isfinite(speeds) & (speeds > 0.0)]
    if len(moving) < 20:
        return []
    limit = FAR_STEP * float(np.percentile(moving, 95.0))
    at, row = np.nonzero(speeds > limit)
    swaps: list[dict[str, Any]] = []
    for k in np.unique(at):
        rows = row[at == k]
        if not 2 <= len(rows) <= 200:
            continue
        start, end = tracks.position[k, rows], tracks.position[k + 1, rows]
        far = np.linalg.norm(ways(tracks, start[:, None], end[None]), axis=2)
        np.fill_diagonal(far, np.inf)
        other = far.argmin(axis=1)
        for i, j in enumerate(other):
            if i < j and other[j] == i and far[i, j] < 0.5 * steps[k, rows[i]]:
                swaps.append(
                    case(tracks, k + 1, [int(rows[i]), int(rows[j])], apart=steps[k, rows[i]])
                )
    order = np.argsort(-speeds[at, row])
    cases = [
        case(
            tracks, at[k] + 1, [int(row[k])], speed=speeds[at[k], row[k]], way=steps[at[k], row[k]]
        )
        for k in order[:FEW]
    ]
    unit = tracks.unit
    return [
        TrackFlag(
            "jump",
            f"{counted(len(at), 'step')} above {limit:.3g} {unit}/s, {FAR_STEP:g} times what 95 % "
            "of steps are below",
            len(at),
            tuple(cases),
        ),
        TrackFlag(
            "swap",
            f"{counted(len(swaps), 'time')} two change places from one frame to the next",
            len(swaps),
            tuple(swaps[:FEW]),
        ),
    ]


def one_body(tracks: Tracks) -> TrackFlag | None:
    """Two individuals in one place for many frames in a row."""
    from scipy.spatial import cKDTree

    nearest = nearest_distances(tracks)
    if not np.isfinite(nearest).any():
        return None
    least = ONE_BODY * float(np.nanmedian(nearest))
    runs: dict[tuple[int, int], list[int]] = {}
    found: list[dict[str, Any]] = []
    count = 0
    for k in range(len(tracks.frame) + 1):
        pairs: set[tuple[int, int]] = set()
        if k < len(tracks.frame) and (nearest[k] < least).any():
            rows = np.flatnonzero(tracks.seen[k])
            tree = cKDTree(*tree_arguments(tracks, tracks.position[k, rows]))
            close = tree.query_pairs(least, output_type="ndarray")[:MOST_PAIRS_OF_FRAME]
            pairs = {(int(rows[i]), int(rows[j])) for i, j in close}
        for pair in [pair for pair in runs if pair not in pairs]:
            first, last = runs.pop(pair)
            if last - first + 1 >= TOGETHER:
                count += 1
                if len(found) < FEW:
                    found.append(case(tracks, first, list(pair), frames=last - first + 1))
        for pair in pairs:
            runs.setdefault(pair, [k, k])[1] = k
    return TrackFlag(
        "one-body",
        f"{counted(count, 'time')} two individuals are within {least:.3g} {tracks.unit} of each "
        f"other for {TOGETHER} frames or more: perhaps two names on one body",
        count,
        tuple(found),
    )


def tree_arguments(tracks: Tracks, places: np.ndarray) -> tuple[Any, ...]:
    """Places, and what `cKDTree` takes for a box that wraps."""
    if not tracks.period:
        return (places,)
    box = np.array(tracks.period)
    wrapped = places.copy()
    wraps = box > 0.0
    wrapped[:, wraps] %= box[wraps]
    wrapped[:, wraps] = np.where(wrapped[:, wraps] >= box[wraps], 0.0, wrapped[:, wraps])
    return wrapped, 16, True, False, True, box


def nearest_distances(tracks: Tracks) -> np.ndarray:
    """How far the nearest other one is, (T, N), NaN for who is not seen or alone."""
    from scipy.spatial import cKDTree

    distances = np.full(tracks.seen.shape, np.nan)
    for k in np.flatnonzero(tracks.seen.sum(axis=1) > 1):
        rows = np.flatnonzero(tracks.seen[k])
        arguments = tree_arguments(tracks, tracks.position[k, rows])
        distances[k, rows] = cKDTree(*arguments).query(arguments[0], k=2)[0][:, 1]
    return distances


def rests(tracks: Tracks, steps: np.ndarray) -> TrackFlag | None:
    """Individuals whose place is exactly the same in many steps: a tracker or a logger repeats."""
    told = np.isfinite(steps).sum(axis=0)
    still = (steps == 0.0).sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(told >= TOGETHER, still / told, 0.0)
    rows = np.flatnonzero(share >= LONGEST_REST)
    cases = [{"ids": [tracks.ids[row]], "share": float(f"{share[row]:.3g}")} for row in rows[:FEW]]
    all_steps = float(still.sum() / max(told.sum(), 1))
    return TrackFlag(
        "rest",
        f"{counted(len(rows), 'individual')} with the same place in half of the steps or more "
        f"({all_steps:.0%} of all steps are 0)",
        len(rows),
        tuple(cases),
    )


def uneven(tracks: Tracks) -> TrackFlag | None:
    """Frames that are not equally far apart."""
    if tracks.is_even:
        return None
    gaps = np.diff(tracks.time)
    odd = np.flatnonzero(np.abs(gaps - tracks.step) > 0.01 * tracks.step)
    largest = odd[np.argsort(-gaps[odd])][:FEW]
    return TrackFlag(
        "uneven",
        f"{counted(len(odd), 'step')} of time other than {tracks.step:.4g} s, up to "
        f"{gaps.max():.4g} s: derivatives need even frames",
        len(odd),
        tuple({"frame": int(tracks.frame[k + 1]), "seconds": float(gaps[k])} for k in largest),
    )


def short(tracks: Tracks) -> TrackFlag | None:
    """Individuals who are seen in few frames, as pieces of a broken track are."""
    counts = tracks.seen.sum(axis=0)
    rows = np.flatnonzero(counts < min(TOGETHER, len(tracks.frame)))
    return TrackFlag(
        "short",
        f"{counted(len(rows), 'individual')} seen in fewer than {TOGETHER} frames",
        len(rows),
        tuple({"ids": [tracks.ids[row]], "frames": int(counts[row])} for row in rows[:FEW]),
    )
