"""Whether a fit would find a truth, and up to which noise: runs of its best, fitted as the tracks.

The model runs from the first frame of the tracks with its best values, as many individuals and as
long; noise of places is added, and the same fit is asked for what was put in.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from agents.flock import Flock
from agents.spec import Spec
from app.tracks.fit.fit_request import FitRequest
from app.tracks.fit.fit_result import ModelFit, describe_point
from app.tracks.fit.fit_study import DEFAULT_SETTINGS, RunnerSettings
from app.tracks.fit.one_step_fit import fit_by_one_step, two_windows
from app.tracks.playing.tracks_world import world_of_tracks
from app.tracks.tracks import PIXELS, Tracks
from worlds.input_error import InputError

NOISES = (0.0, 0.1, 0.2, 0.5, 1.0)
"""Of places, as shares of the way of a tick."""
TICKS = 400
"""Of a synthetic run, at most."""
HELD = 0.5
"""Of the truths of a noise, above which share it counts as found."""


@dataclass(frozen=True)
class SyntheticNoise:
    """What became of the truths of one noise."""

    noise: float
    """Share of the way of a tick."""
    found: int
    """Fits whose region holds the truth,"""
    explained: int
    """fits that beat both nulls and say a region,"""
    repeats: int
    """and all fits."""
    bests: tuple[Mapping[str, float], ...]


@dataclass(frozen=True)
class SyntheticCheck:
    """Truths of one model at several noises."""

    model: str
    truth: Mapping[str, float]
    noises: tuple[SyntheticNoise, ...]

    def sentences(self) -> list[str]:
        """What is said of it."""
        counts = ", ".join(
            f"{100 * one.noise:.0f} %: {one.found} of {one.repeats}" for one in self.noises
        )
        found = [one.noise for one in self.noises if one.found > HELD * one.repeats]
        lost = [one.noise for one in self.noises if one.noise not in found]
        words = (
            f"Runs of {self.model} with {describe_point(self.truth)}, fitted in the same way: the "
            f"truth is in the region told, by noise of places in shares of a tick's way: {counts}"
        )
        if not lost:
            return [words + "."]
        return [words + f"; it breaks at {100 * min(lost):.0f} %."]

    def to_dict(self) -> dict[str, Any]:
        """All of it as plain values, for JSON."""
        return {
            "model": self.model,
            "truth": dict(self.truth),
            "noises": [vars(one) for one in self.noises],
        }


def synthetic_tracks(
    tracks: Tracks, request: FitRequest, fit: ModelFit, noise: float, seed: int
) -> Tracks:
    """A run of the best of a fit, seen with noise of places, as tracks of a frame a tick."""
    if tracks.unit != PIXELS:
        tracks = tracks.in_metres()
    scale = request.scale_of(tracks)
    first, _ = two_windows(tracks, request)
    sample = first.fitted
    rows = np.flatnonzero(sample.present[0])
    silent = fit.model_noises
    fixed = {name: value for name, value in fit.fixed.items() if name not in silent}
    spec = Spec(
        fit.model,
        world=world_of_tracks(tracks, 1.0 / scale.length),
        informed=0,
        seed=seed,
        parameters={**fixed, **fit.best},
    )
    start = {"position": sample.position[0, rows], "heading": sample.heading[0, rows]}
    if Flock(spec, start=start).model.body.speed is None:
        time_unit = 1.0 if Flock(spec, start=start).model.body.unit == "s" else scale.seconds
        start["speed"] = sample.speed[0, rows] * time_unit
    flock = Flock(spec, start=start)
    ticks = min(TICKS, len(tracks.frame) // scale.every)
    place = np.concatenate([flock.position[None], flock.trace(ticks - 1)]) * scale.length
    way = float(np.nanmedian(first.motion.speed)) * scale.seconds
    rng = np.random.default_rng(seed)
    place = place + noise * way * rng.normal(size=place.shape)
    return Tracks(
        position=place,
        frame=np.arange(ticks),
        time=np.arange(ticks) * scale.seconds,
        ids=tuple(tracks.ids[row] for row in rows),
        unit=tracks.unit,
        name=f"a run of {fit.model}",
        period=tracks.period,
    )


def check_by_synthetic_truth(
    tracks: Tracks,
    request: FitRequest,
    fit: ModelFit,
    folder: Path,
    repeats: int = 1,
    settings: RunnerSettings = DEFAULT_SETTINGS,
) -> SyntheticCheck:
    """Fit runs of the best of a fit at several noises. Raises FitStoppedError and InputError."""
    if repeats < 1:
        raise InputError(f"synthetic truths = {repeats} is not allowed: 1 or more are needed")
    names = tuple(
        f"{p.name}={p.values[0]:.12g}:{p.values[-1]:.12g}:{len(p.values)}" for p in fit.parameters
    )
    own = replace(request, models=(fit.model,), parameters=names, every=1, shuffles=1)
    outcomes = []
    for noise in NOISES:
        found = explained = 0
        bests = []
        for k in range(repeats):
            seed = request.seed + k
            run = synthetic_tracks(tracks, request, fit, noise, seed)
            place = folder / f"{fit.model}-{100 * noise:.0f}-{seed}"
            (again,) = fit_by_one_step(run, own, place, settings).fits
            bests.append(again.best)
            told = again.explains and not again.has_moved
            explained += told
            found += told and all(
                region.low <= fit.best[region.name] <= region.high for region in again.first.regions
            )
        outcomes.append(SyntheticNoise(noise, found, explained, repeats, tuple(bests)))
    return SyntheticCheck(fit.model, fit.best, tuple(outcomes))
