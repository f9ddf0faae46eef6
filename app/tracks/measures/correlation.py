"""How far velocity fluctuations hang together: C(r), and its first zero by frame."""

from __future__ import annotations

import math

import numpy as np

from agents.observables.correlation import BINS, bin_width, correlation, correlation_length
from app.studies.charts.array_charts import draw_curve
from app.studies.measure import COUNT
from app.tracks.measures.track_measure import (
    MeasureChart,
    MeasureInput,
    MeasureResult,
    Progress,
    TrackMeasure,
    frame_series,
)

LEAST_PAIRS = 0.01
"""Share of the pairs of the fullest bin below which a bin of the mean C(r) is not drawn."""


def lengths(given: MeasureInput, progress: Progress) -> MeasureResult:
    """xi in each frame: where C(r) is 0 for the first time."""
    values, count = given.by_frame(
        lambda place, velocity: correlation_length(place, velocity, given.size, given.images),
        given.tracks.position,
        given.motion.velocity,
        progress=progress,
    )
    return frame_series(given, "correlation-length", "{u}", values, count, COUNT)


def mean_curve(given: MeasureInput, progress: Progress) -> MeasureResult:
    """C(r) in bins of one width, averaged over frames, each pair counting once."""
    tracks, velocity = given.tracks, given.motion.velocity
    there = tracks.seen & np.isfinite(velocity).all(axis=2)
    frames = np.flatnonzero(there.sum(axis=1) >= max(given.options.least, 2))
    widths = [
        bin_width(tracks.position[t][there[t]], given.size, given.images)
        for t in frames[:: max(1, len(frames) // 200)]
    ]
    width = float(np.median(widths)) if widths else math.nan
    sums, pairs, distance = np.zeros(BINS), np.zeros(BINS), np.zeros(BINS)
    used = 0
    for k, t in enumerate(frames):
        curve = correlation(
            tracks.position[t][there[t]], velocity[t][there[t]], given.size, given.images, width
        )
        if curve is not None:
            at = np.minimum((curve.distance / width).astype(int), BINS - 1)
            np.add.at(sums, at, curve.value * curve.pairs)
            np.add.at(distance, at, curve.distance * curve.pairs)
            np.add.at(pairs, at, curve.pairs)
            used += 1
        if k % 64 == 0:
            progress((k + 1) / len(frames))
    some = pairs > LEAST_PAIRS * pairs.max(initial=0.0)
    r, c = distance[some] / pairs[some], sums[some] / pairs[some]
    zero = math.nan
    below = np.flatnonzero(c <= 0.0)
    if len(below):
        k = int(below[0])
        r0, c0 = (r[k - 1], c[k - 1]) if k else (0.0, 1.0)
        zero = float(r0 + (r[k] - r0) * c0 / (c0 - c[k]))
    chart = MeasureChart(
        f"distance r ({given.unit})", "C(r)", lambda axes: draw_curve(axes, r, c, level=0.0)
    )
    return MeasureResult(
        {f"first zero ({given.unit})": zero, f"width of a bin ({given.unit})": width,
         "frames": used},
        {"": {"r": r, "c": c, "pairs": pairs[some].astype(np.int64)}},
        (chart,),
        ("fluctuations add up to nothing in each frame, so C(r) is below 0 somewhere in any flock: "
         "compare its zero with the size of the flock",),
    )  # fmt: skip


def pair_cost(frames: int, n: int) -> float:
    """Seconds for all pairs of individuals in all frames."""
    return 6e-4 * frames + 2.5e-9 * frames * n * n + 2e-6 * frames * n


MEASURES = (
    TrackMeasure(
        "correlation-length", "How far velocity fluctuations hang together",
        "Cavagna et al. 2010", lengths, cost=pair_cost, by_frame="{u}",
    ),
    TrackMeasure(
        "correlation", "C(r): correlation of velocity fluctuations by distance",
        "Cavagna et al. 2010", mean_curve, cost=pair_cost,
    ),
)  # fmt: skip
