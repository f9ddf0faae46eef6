"""Connected groups within a reach: how many, how large, and neighbours within it."""

from __future__ import annotations

import math

import numpy as np

from agents.observables import neighbours
from agents.observables.groups import group_sizes
from agents.observables.neighbours import groups_within
from app.studies.measure import COUNT
from app.tracks.measures.track_measure import (
    MeasureChart,
    MeasureInput,
    MeasureResult,
    Progress,
    TrackMeasure,
    frame_series,
    needs_neighbours,
)
from worlds.input_error import InputError

SPACINGS = 3.0
"""Of the median distance to the nearest neighbour: a reach that nobody asked for."""


def reach_of(given: MeasureInput) -> tuple[float, str]:
    """The reach, and a sentence on where it is from."""
    asked = given.options.reach
    if asked is not None:
        if not 0.0 < asked < math.inf:
            raise InputError(f"reach = {asked:g} {given.unit} is not allowed: a length > 0")
        return asked, f"reach {asked:g} {given.unit}"
    reach = SPACINGS * given.spacing
    return reach, (
        f"reach {reach:.4g} {given.unit}, {SPACINGS:g} times the median distance to the nearest "
        "neighbour: --reach chooses another"
    )


def sizes(given: MeasureInput, progress: Progress) -> MeasureResult:
    """The size of the largest group in each frame, and how often groups have each size."""
    from app.studies.charts.array_charts import draw_curve

    reach, said = reach_of(given)
    position = np.where(given.tracks.seen[..., None], given.tracks.position, np.nan)
    many = np.zeros(given.tracks.position.shape[1] + 1, np.int64)
    number = np.full(len(position), np.nan)
    at = iter(np.flatnonzero(given.tracks.seen.sum(axis=1) >= max(given.options.least, 1)))

    def largest(place: np.ndarray) -> float:
        size = group_sizes(groups_within(place, reach, given.size, given.images))
        np.add.at(many, size, 1)
        number[next(at)] = len(size)
        return float(size[0])

    values, count = given.by_frame(largest, position, progress=progress)
    result = frame_series(given, "largest-group", "individuals", values, count, COUNT)
    size = np.flatnonzero(many)
    share = size * many[size] / max(int((size * many[size]).sum()), 1)
    chart = MeasureChart(
        "size of the group (individuals)", "share of individuals in such groups",
        lambda axes: draw_curve(axes, size, share),
    )  # fmt: skip
    table = {"size": size, "groups": many[size], "share_of_individuals": share}
    columns = {**result.tables[""], "groups": number}
    return MeasureResult(
        {**result.numbers, "groups, mean": float(np.nanmean(number)) if len(size) else math.nan},
        {"": columns, "distribution": table},
        (*result.charts, chart),
        (said, *result.notes),
    )


def mean_neighbours(given: MeasureInput, progress: Progress) -> MeasureResult:
    """The mean number of others within the reach, in each frame."""
    reach, said = reach_of(given)
    position = np.where(given.tracks.seen[..., None], given.tracks.position, np.nan)
    values, count = given.by_frame(
        lambda place: neighbours.mean_neighbours(place, reach, given.size, given.images),
        position,
        progress=progress,
    )
    result = frame_series(given, "mean-neighbours", "individuals", values, count, COUNT)
    return MeasureResult(result.numbers, result.tables, result.charts, (said, *result.notes))


MEASURES = (
    TrackMeasure(
        "group-sizes", "Connected groups: the largest, and how large they are", "", sizes,
        cost=lambda frames, n: 3e-4 * frames + 1e-6 * frames * n,
        lacks=needs_neighbours, by_frame="individuals",
    ),
    TrackMeasure(
        "mean-neighbours", "Mean number of others within reach", "", mean_neighbours,
        cost=lambda frames, n: 2e-4 * frames + 3e-6 * frames * n,
        lacks=needs_neighbours, by_frame="individuals",
    ),
)  # fmt: skip
