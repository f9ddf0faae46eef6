"""Where nearest neighbours are, ahead or aside, by rank; the border of the flock is left out."""

from __future__ import annotations

import math

import numpy as np

from agents.observables.anisotropy import (
    isotropic_gamma,
    neighbour_anisotropy,
    range_of_structure,
)
from app.studies.charts.array_charts import draw_curve
from app.tracks.measures.track_measure import (
    MeasureChart,
    MeasureInput,
    MeasureResult,
    Progress,
    TrackMeasure,
)
from worlds.input_error import InputError

LEAST_FRAMES = 5
"""That a mean by rank is of, at least."""


def structure(given: MeasureInput, progress: Progress) -> MeasureResult:
    """gamma_k over frames, of those whose k-th neighbour is nearer than the border."""
    count = given.options.neighbours
    if count < 1:
        raise InputError(f"neighbours = {count} is not allowed: 1 or more are needed")
    tracks, heading = given.tracks, given.motion.heading
    ranks = min(count, max(len(tracks.ids) - 1, 1))
    frames = np.flatnonzero(tracks.seen.sum(axis=1) >= max(given.options.least, tracks.dim + 2))
    gamma, distance = np.full((len(frames), ranks), np.nan), np.full((len(frames), ranks), np.nan)
    for k, t in enumerate(frames):
        mean = np.nansum(heading[t], axis=0)
        if mean.any():
            one = neighbour_anisotropy(
                tracks.position[t][tracks.seen[t]], mean, given.size, given.images, ranks
            )
            fit = one.individuals >= max(given.options.least, 1)
            gamma[k, fit], distance[k, fit] = one.gamma[fit], one.distance[fit]
        if k % 32 == 0:
            progress((k + 1) / len(frames))
    many = np.isfinite(gamma).sum(axis=0)
    sums = np.nansum(gamma, axis=0)
    enough = many >= LEAST_FRAMES
    mean_gamma = np.where(enough, sums / np.maximum(many, 1), np.nan)
    spread = np.sqrt(np.nansum((gamma - mean_gamma) ** 2, axis=0) / np.maximum(many - 1, 1))
    error = np.where(enough, spread / np.sqrt(np.maximum(many, 1)), np.nan)
    apart = np.where(enough, np.nansum(distance, axis=0) / np.maximum(many, 1), np.nan)
    even, even_spread = isotropic_gamma(tracks.dim)
    n_c = range_of_structure(mean_gamma, tracks.dim)
    rank = np.arange(1, ranks + 1)
    at = float(np.interp(n_c, rank, apart)) if math.isfinite(n_c) else math.nan
    words = "in space" if tracks.dim == 3 else "in the plane"
    notes = [
        f"neighbours that are the same all round have {even:.3g} {words} (broken line), with a "
        f"spread of {even_spread:.2g} in a frame; above it they are aside, below ahead and behind",
        "individuals count whose neighbour is nearer than the border of the flock",
    ]
    if not enough.any():
        notes.insert(0, "not resolved: too few individuals are inside of the flock's border")
    elif not abs(mean_gamma[0] - even) > 2.0 * error[0]:
        notes.insert(0, "not resolved: the nearest neighbour is not told from the same all round")
    chart = MeasureChart(
        "k-th neighbour", "gamma",
        lambda axes: draw_curve(axes, rank[enough], mean_gamma[enough], error[enough], even),
    )  # fmt: skip
    return MeasureResult(
        {"gamma of the nearest": float(mean_gamma[0]), "the same all round": even,
         "neighbours until the same all round": n_c, f"their distance ({given.unit})": at,
         "frames": int(many.max(initial=0))},
        {"": {"k": rank, "gamma": mean_gamma, "error": error, "distance": apart, "frames": many}},
        (chart,) if enough.any() else (), tuple(notes),
    )  # fmt: skip


MEASURES = (
    TrackMeasure(
        "structure", "Whether nearest neighbours are ahead or aside", "Ballerini et al. 2008",
        structure, lambda frames, n: 2e-3 * frames + 6e-6 * frames * n,
    ),
)  # fmt: skip
