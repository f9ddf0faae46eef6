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
)


def nearest_neighbour(given: MeasureInput, progress: Progress) -> MeasureResult:
    """The least distance to another one in each frame, over those seen: mean and distribution."""
    every: list[np.ndarray] = []

    def mean_distance(place: np.ndarray) -> float:
        near = neighbours.nearest_neighbour(place, given.size, given.images)
        every.append(near)
        return float(near.mean())

    position = np.where(given.tracks.seen[..., None], given.tracks.position, np.nan)
    values, count = given.by_frame(mean_distance, position, progress=progress)
    result = frame_series(given, "nearest-neighbour", "{u}", values, count, COUNT)
    near = np.concatenate(every) if every else np.empty(0)
    table, chart = distribution_chart(near, f"distance to the nearest neighbour ({given.unit})")
    numbers = {f"of all individuals, {k}": v for k, v in describe_values(near).items()}
    if len(near):
        numbers["of all individuals, least"] = float(near.min())
    return MeasureResult(
        {**result.numbers, **numbers}, {**result.tables, "distribution": table},
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
        "nearest-neighbour", "Distance to the nearest neighbour, mean and distribution",
        "Clark and Evans 1954", nearest_neighbour,
        cost=lambda frames, n: 1e-4 * frames + 2e-6 * frames * n, by_frame="{u}",
    ),
    TrackMeasure(
        "gyration-radius", "Root mean square distance from the centre", "", gyration_radius,
        cost=lambda frames, n: 2e-4 * frames + 5e-8 * frames * n, by_frame="{u}",
    ),
)  # fmt: skip
