"""Order by frame: how far individuals agree on a heading, mill, and differ in their velocities."""

from __future__ import annotations

import math

import numpy as np

from agents.observables import order
from app.studies.measure import COUNT, SHARE
from app.tracks.measures.track_measure import (
    MeasureInput,
    MeasureResult,
    Progress,
    TrackMeasure,
    frame_series,
)


def random_polarisation(n: float, dim: int) -> float:
    """The polarisation that n headings at random have, for many.

    `sqrt(pi / 4n)` in the plane, `sqrt(8 / 3 pi n)` in space.

    >>> round(random_polarisation(25, 2), 3), round(random_polarisation(25, 3), 3)
    (0.177, 0.184)
    """
    return math.sqrt(math.pi / (4.0 * n) if dim == 2 else 8.0 / (3.0 * math.pi * n))


def polarisation(given: MeasureInput, progress: Progress) -> MeasureResult:
    """The length of the mean heading in each frame."""
    heading = given.motion.heading
    there = np.isfinite(heading[..., 0])
    count = there.sum(axis=1)
    total = np.where(there[..., None], heading, 0.0).sum(axis=1)
    enough = count >= max(given.options.least, 1)
    length = np.sqrt((total**2).sum(axis=1)) / np.maximum(count, 1)
    values = np.where(enough, np.minimum(length, 1.0), np.nan)
    progress(1.0)
    seen = count[np.isfinite(values)]
    level = random_polarisation(float(np.median(seen)), given.tracks.dim) if len(seen) else math.nan
    result = frame_series(given, "polarisation", "1", values, count, SHARE, level)
    if math.isnan(level):
        return result
    note = f"headings at random would have {level:.2f} (broken line), of the median number seen"
    return MeasureResult(
        {**result.numbers, "at random": level}, result.tables, result.charts, (note, *result.notes)
    )


def angular_momentum(given: MeasureInput, progress: Progress) -> MeasureResult:
    """How much individuals mill about their centre in each frame."""
    values, count = given.by_frame(
        lambda place, heading: order.angular_momentum(place, heading, given.size, given.images),
        given.tracks.position,
        given.motion.heading,
        progress=progress,
    )
    return frame_series(given, "angular-momentum", "1", values, count, SHARE)


def velocity_spread(given: MeasureInput, progress: Progress) -> MeasureResult:
    """Root mean square difference of the velocities from their mean in each frame."""
    values, count = given.by_frame(order.velocity_spread, given.motion.velocity, progress=progress)
    return frame_series(given, "velocity-spread", "{u}/s", values, count, COUNT)


MEASURES = (
    TrackMeasure(
        "polarisation", "Length of the mean heading", "Vicsek et al. 1995", polarisation,
        by_frame="1",
    ),
    TrackMeasure(
        "angular-momentum", "How much individuals mill about their centre",
        "Couzin et al. 2002, (5)", angular_momentum,
        cost=lambda frames, n: 2e-4 * frames + 5e-8 * frames * n, by_frame="1",
    ),
    TrackMeasure(
        "velocity-spread", "Root mean square difference of the velocities from their mean",
        "Cucker and Smale 2007", velocity_spread, by_frame="{u}/s",
    ),
)  # fmt: skip
