"""How far individuals are apart: to the nearest neighbour, and from their centre."""

from __future__ import annotations

import numpy as np

from agents.observables import neighbours, order
from app.studies.measure import COUNT
from app.tracks.measures.track_measure import (
    MeasureInput,
    MeasureResult,
    Progress,
    TrackMeasure,
    describe_values,
    distribution_chart,
    frame_series,
    needs_neighbours,
)


def spacing(given: MeasureInput, progress: Progress) -> MeasureResult:
    """The distance to the nearest other one seen: its median and least by frame, and all of it."""
    every: list[np.ndarray] = []
    least = np.full(len(given.tracks.frame), np.nan)

    def median_distance(place: np.ndarray) -> float:
        near = neighbours.nearest_neighbour(place, given.size, given.images)
        every.append(near)
        return float(np.median(near))

    position = np.where(given.tracks.seen[..., None], given.tracks.position, np.nan)
    values, count = given.by_frame(median_distance, position, progress=progress)
    result = frame_series(given, "spacing", "{u}", values, count, COUNT)
    least[np.isfinite(values)] = [near.min() for near in every if np.isfinite(np.median(near))]
    near = np.concatenate([np.empty(0), *every])
    near = near[np.isfinite(near)]
    table, chart = distribution_chart(near, f"distance to the nearest neighbour ({given.unit})")
    numbers = {f"of all individuals, {k}": v for k, v in describe_values(near).items()}
    if len(near):
        numbers["least of all"] = float(near.min())
    return MeasureResult(
        {**result.numbers, **numbers},
        {"": {**result.tables[""], "least_spacing": least}, "distribution": table},
        (*result.charts, chart), result.notes,
    )  # fmt: skip


def gyration_radius(given: MeasureInput, progress: Progress) -> MeasureResult:
    """Root mean square distance of those seen from their centre, in each frame."""
    position = np.where(given.tracks.seen[..., None], given.tracks.position, np.nan)
    values, count = given.by_frame(
        lambda place: order.gyration_radius(place, given.size, given.images),
        position,
        progress=progress,
    )
    return frame_series(given, "gyration-radius", "{u}", values, count, COUNT)


MEASURES = (
    TrackMeasure(
        "spacing", "Distance to the nearest neighbour, median and distribution",
        "Clark and Evans 1954", spacing,
        cost=lambda frames, n: 1e-4 * frames + 2e-6 * frames * n,
        lacks=needs_neighbours, by_frame="{u}",
    ),
    TrackMeasure(
        "gyration-radius", "Root mean square distance from the centre", "", gyration_radius,
        cost=lambda frames, n: 2e-4 * frames + 5e-8 * frames * n, by_frame="{u}",
    ),
)  # fmt: skip
