"""How fast individuals move: by frame, and the distribution over all of them."""

from __future__ import annotations

import numpy as np

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


def speed(given: MeasureInput, progress: Progress) -> MeasureResult:
    """The mean speed in each frame, and the speeds of all individuals in all frames."""
    speeds = given.motion.speed
    values, count = given.by_frame(
        lambda one: float(one.mean()), speeds[..., None], progress=progress
    )
    result = frame_series(given, "speed", "{u}/s", values, count, COUNT)
    every = speeds[np.isfinite(speeds)]
    table, chart = distribution_chart(every, f"speed ({given.unit}/s)")
    numbers = {f"of all individuals, {k}": v for k, v in describe_values(every).items()}
    notes = result.notes
    if given.motion.least_speed and len(every):
        slow = float((every < given.motion.least_speed).mean())
        notes = (
            *notes, f"{slow:.0%} of the speeds are below the least one: no heading is taken there"
        )  # fmt: skip
    return MeasureResult(
        {**result.numbers, **numbers}, {**result.tables, "distribution": table},
        (*result.charts, chart), notes,
    )  # fmt: skip


MEASURES = (
    TrackMeasure(
        "speed", "Speed, mean and distribution", "", speed, by_frame="{u}/s",
    ),
)  # fmt: skip
