"""Frames too far apart for a prediction: whole runs of the model are compared with the tracks.

Approximate Bayesian computation: parameters are drawn from their ranges, each draw is run from the
first frame of the tracks, and both are described by the same few numbers. Draws near the tracks are
kept, and brought nearer by a regression on those numbers (Beaumont, Zhang and Balding 2002). How
often such an interval holds the truth is measured, by leaving each of many draws out in turn and
taking it for the tracks: intervals of this kind are known to be too narrow.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from agents.flock import Flock
from agents.spec import Spec
from app.studies.runs.database import Outcome
from app.studies.runs.store_reader import StoreReader
from app.studies.workers.kernels import compile_loop
from app.studies.workers.run_worker import stop_if_unwanted
from app.tracks.fit.fit_request import FitRequest, demand_dimensions
from app.tracks.fit.fit_study import (
    DEFAULT_SETTINGS,
    FitCell,
    RunnerSettings,
    basis_of,
    evaluate_cells,
)
from app.tracks.fit.fitted_parameter import FittedParameter
from app.tracks.fit.tick_scale import ScaledModel
from app.tracks.playing.tracks_world import world_of_tracks
from app.tracks.tracks import PIXELS, Tracks
from worlds.input_error import InputError
from worlds.world import World

FRAMES = 20
"""Of the tracks that are compared, where nobody says how many."""
LEAST_FRAMES = 4
KEPT = 0.2
"""Share of the draws that are kept, the nearest."""
LEAST_KEPT = 100
"""Of fewer a regression on eleven numbers says what it likes."""
LARGEST = 700.0
"""A logit, at most."""
LEFT_OUT = 200
"""Draws that are left out in turn, at most."""
INTERVAL = 0.9
BINS = (0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 1.0)
"""Of distances between pairs, as quantiles of those of the tracks."""
STRAIGHT = 0.95
"""The quantile of ways from frame to frame that stands for the speed: most are not straight."""
UNLIKE = 0.95
"""Tracks further from their draws than this share of draws are from theirs are unlike all."""


def shortest(difference: np.ndarray, period: np.ndarray) -> np.ndarray:
    """Differences of places (..., dim) by the shortest way, where the world wraps."""
    return difference - period * np.round(difference / np.where(period > 0.0, period, np.inf))


def summarise(position: np.ndarray, period: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """What is compared of places (F, N, dim), NaN where nobody is seen: 11 numbers.

    Polarisation of the ways from frame to frame, its standard deviation, the length of a way; the
    mean cosine between the ways of pairs in six bins of distance; between a way and the next; the
    distance to the nearest.
    """
    way = shortest(np.diff(position, axis=0), period)
    length = np.linalg.norm(way, axis=2)
    moves = np.isfinite(length) & (length > 0.0)
    unit = way / np.where(moves, length, np.nan)[..., None]
    counts = np.maximum(moves.sum(axis=1), 1)
    order = np.linalg.norm(np.nansum(unit, axis=1), axis=1) / counts
    turn = (unit[1:] * unit[:-1]).sum(axis=2)
    sums, numbers = np.zeros(len(edges) - 1), np.zeros(len(edges) - 1)
    nearest = []
    for k in range(len(unit)):
        rows = np.flatnonzero(moves[k])
        if len(rows) < 2:
            continue
        place, heading = position[k, rows], unit[k, rows]
        distance = np.linalg.norm(shortest(place[:, None] - place[None], period), axis=2)
        np.fill_diagonal(distance, np.inf)
        nearest.append(distance.min(axis=1).mean())
        first, second = np.triu_indices(len(rows), 1)
        cosine = (heading[first] * heading[second]).sum(axis=1)
        bins = np.clip(np.searchsorted(edges, distance[first, second]) - 1, 0, len(sums) - 1)
        sums += np.bincount(bins, cosine, len(sums))
        numbers += np.bincount(bins, minlength=len(numbers))
    return np.array([
        order.mean(), order.std(), np.nanmean(length), *(sums / np.maximum(numbers, 1)),
        np.nanmean(turn), np.mean(nearest) if nearest else np.nan,
    ])  # fmt: skip


@dataclass(frozen=True, eq=False)
class ObservedFrames:
    """The frames of the tracks that runs are compared with, in lengths of the model."""

    position: np.ndarray
    """(F, N, dim); all have a place in the first frame."""
    heading: np.ndarray
    """(N, dim), the ways of the first frame as unit vectors: what runs begin with."""
    period: np.ndarray
    """(dim,), 0 where the world does not wrap."""
    edges: np.ndarray
    """Of the bins of distance."""
    ticks: int
    """From frame to frame."""
    world: World

    @property
    def digest(self) -> str:
        """A hash of all its numbers."""
        return hashlib.sha256(self.position.tobytes() + self.heading.tobytes()).hexdigest()[:16]


@dataclass
class SimulationJob:
    """How a draw is run: the job of the processes."""

    scaled: ScaledModel
    observed: ObservedFrames

    def prepare(self) -> None:
        """Nothing."""

    def flock(self, point: Mapping[str, float], seed: int) -> Flock:
        """The flock of a draw, at the first frame of the tracks."""
        spec = Spec(
            self.scaled.name, world=self.observed.world, informed=0, seed=seed,
            parameters={**self.scaled.fixed, **point},
        )  # fmt: skip
        start = {"position": self.observed.position[0], "heading": self.observed.heading}
        return Flock(spec, start=start)

    def run(self, payload: tuple[Mapping[str, float], int], _seed: int) -> Outcome:
        """Run a draw; what is compared of it."""
        point, seed = payload
        observed = self.observed
        flock = self.flock(point, seed)
        position = np.empty_like(observed.position)
        position[0] = observed.position[0]
        for k in range(1, len(position)):
            flock.advance(observed.ticks)
            position[k] = flock.position
            stop_if_unwanted()
        # Who is not seen in a frame of the tracks is not seen in that of the run.
        position[~np.isfinite(observed.position)] = np.nan
        values = summarise(position, observed.period, observed.edges)
        return Outcome("ok", {"polarisation": float(values[0])},
                       series={"summaries": (np.arange(len(values)), values)})  # fmt: skip


@dataclass(frozen=True)
class Posterior:
    """What is left of a parameter's range."""

    name: str
    unit: str
    low: float
    median: float
    high: float
    """The interval is of 90 %."""
    coverage: float
    """How often such an interval held the truth, leaving draws out in turn."""
    error: float
    """The median error of the median there."""
    is_told: bool
    """Whether the interval is less than half of the range."""

    def describe(self) -> str:
        """What is told of it, in words."""
        ends = f"{self.low:.3g} to {self.high:.3g}"
        return f"{self.name} {ends}" if self.is_told else f"{self.name} not told ({ends})"


def nearest_draws(summaries: np.ndarray, observed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which draws (K,) are kept, and their distances, of summaries (D, S) in units of spread."""
    distance = np.sqrt(((summaries - observed) ** 2).sum(axis=1))
    kept = min(len(distance), max(LEAST_KEPT, round(KEPT * len(distance))))
    rows = np.argsort(distance, kind="stable")[:kept]
    return rows, distance[rows]


def adjusted_draws(
    summaries: np.ndarray, draws: np.ndarray, observed: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The kept draws (K, P) as if their summaries were the observed, and their weights (K,).

    Draws are shares of the range in (0, 1), regressed as logits so that none leaves it.
    """
    rows, distance = nearest_draws(summaries, observed)
    weight = 1.0 - (distance / (distance.max() + 1e-12)) ** 2
    logits = np.log(draws[rows]) - np.log1p(-draws[rows])
    away = summaries[rows] - observed
    design = np.column_stack([np.ones(len(rows)), away])
    root = np.sqrt(weight)[:, None]
    slope = np.linalg.lstsq(root * design, root * logits, rcond=None)[0][1:]
    # Of tracks that are far from all runs the logits may be beyond what exp takes.
    return 1.0 / (1.0 + np.exp(np.clip(away @ slope - logits, -LARGEST, LARGEST))), weight


def weighted_quantiles(values: np.ndarray, weight: np.ndarray, shares: list[float]) -> np.ndarray:
    """Quantiles of values (K,) that count by their weights."""
    order = np.argsort(values)
    total = np.cumsum(weight[order]) - 0.5 * weight[order]
    return np.interp(np.array(shares) * weight.sum(), total, values[order])


def standardise(summaries: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The middle and the spread of each summary, of summaries (D, S); a spread of 0 is 1."""
    middle = np.median(summaries, axis=0)
    spread = 1.4826 * np.median(np.abs(summaries - middle), axis=0)
    return middle, np.where(spread > 0.0, spread, 1.0)


QUANTILES = [0.5 - INTERVAL / 2, 0.5, 0.5 + INTERVAL / 2]


@dataclass(frozen=True, eq=False)
class AbcFit:
    """What whole runs say of one model."""

    model: str
    posteriors: tuple[Posterior, ...]
    draws: np.ndarray
    """(D, P), the values that were run."""
    summaries: np.ndarray
    """(D, S)."""
    observed: np.ndarray
    """(S,), those of the tracks."""
    kept: np.ndarray
    """(K, P), the draws that are kept, as if their runs were the tracks,"""
    weights: np.ndarray
    """and how much each counts, (K,)."""
    unlikeness: float
    """Share of draws that are nearer to the others than the tracks are."""
    notes: tuple[str, ...]

    @property
    def is_like_tracks(self) -> bool:
        """Whether the tracks are as near to the draws as draws are to each other."""
        return self.unlikeness <= UNLIKE

    def sentences(self) -> list[str]:
        """What is said of it, a sentence each."""
        if not self.is_like_tracks:
            return [
                f"{self.model} explains nothing: none of {len(self.draws)} runs is like these "
                f"tracks ({100 * self.unlikeness:.0f} % of runs are nearer to others)."
            ]
        told = "; ".join(posterior.describe() for posterior in self.posteriors)
        coverage = ", ".join(f"{p.name} {100 * p.coverage:.0f} %" for p in self.posteriors)
        error = ", ".join(f"{p.name} {p.error:.2g}" for p in self.posteriors)
        return [
            f"{self.model}: {told} (intervals of 90 %).",
            f"With {min(LEFT_OUT, len(self.draws))} runs left out in turn, these intervals of 90 % "
            f"held the truth in: {coverage}; median error: {error}.",
        ]

    def to_dict(self) -> dict[str, Any]:
        """All of it as plain values, for JSON."""
        return {
            "model": self.model,
            "is_like_tracks": self.is_like_tracks,
            "unlikeness": self.unlikeness,
            "posteriors": [vars(posterior) for posterior in self.posteriors],
            "draws": self.draws.tolist(),
            "summaries": self.summaries.tolist(),
            "observed": self.observed.tolist(),
            "notes": list(self.notes),
            "sentences": self.sentences(),
        }


@dataclass(frozen=True, eq=False)
class AbcResult:
    """A fit of models by whole runs."""

    tracks: str
    fits: tuple[AbcFit, ...]
    scale: str
    evaluated: int
    taken: int

    def sentences(self) -> list[str]:
        """All that is said, the scale first."""
        lines = [f"{self.tracks}: {self.scale}."]
        for fit in self.fits:
            lines += [f"{fit.model}: {'; '.join(fit.notes)}."] if fit.notes else []
            lines += fit.sentences()
        return lines

    def table(self) -> list[dict[str, Any]]:
        """One row for each parameter of each model."""
        return [
            {"rule": fit.model, **vars(posterior)}
            for fit in self.fits
            for posterior in fit.posteriors
        ]

    def to_dict(self) -> dict[str, Any]:
        """All of it as plain values, for JSON."""
        return {
            "method": "abc",
            "tracks": self.tracks,
            "scale": self.scale,
            "evaluated": self.evaluated,
            "taken": self.taken,
            "table": self.table(),
            "models": [fit.to_dict() for fit in self.fits],
            "sentences": self.sentences(),
        }


def observed_frames(tracks: Tracks, request: FitRequest) -> ObservedFrames:
    """The frames that runs are compared with, from the first on. Raises InputError for too few."""
    scale = request.scale_of(tracks)
    frames = (FRAMES if request.frames is None else request.frames) + 1
    position = tracks.position[: frames * scale.every : scale.every] / scale.length
    period = np.array(tracks.period or (0.0,) * tracks.dim) / scale.length
    if len(position) <= LEAST_FRAMES:
        raise InputError(
            f"{tracks.name} has {len(position)} frames to compare: ABC needs {LEAST_FRAMES + 1}"
        )
    way = shortest(position[1] - position[0], period)
    length = np.linalg.norm(way, axis=1)
    rows = np.flatnonzero(np.isfinite(length) & (length > 0.0))
    if len(rows) < 2:
        raise InputError(
            f"{tracks.name}: {len(rows)} individuals move from the first frame to the next: ABC "
            "needs 2 or more"
        )
    position = position[:, rows]
    place = position[0]
    distance = np.linalg.norm(shortest(place[:, None] - place[None], period), axis=2)
    edges = np.quantile(distance[np.triu_indices(len(rows), 1)], BINS)
    heading = way[rows] / length[rows, None]
    world = world_of_tracks(tracks, 1.0 / scale.length)
    start = np.where(period > 0.0, np.mod(position, np.where(period > 0.0, period, 1.0)), position)
    return ObservedFrames(start, heading, period, edges, scale.ticks, world)


def fit_by_abc(
    tracks: Tracks,
    request: FitRequest,
    folder: Path,
    settings: RunnerSettings = DEFAULT_SETTINGS,
) -> AbcResult:
    """Fit models to tracks by whole runs; begun again with the same folder it goes on.

    Raises FitStoppedError where it was asked to stop, and InputError.
    """
    demand_dimensions(tracks, request.models)
    fitted = request.fitted()
    if tracks.unit != PIXELS:
        tracks = tracks.in_metres()
    if len(tracks.ids) < 2:
        raise InputError(f"{tracks.name} has 1 individual: a fit needs 2 or more")
    scale = request.scale_of(tracks)
    observed = observed_frames(tracks, request)
    way = np.linalg.norm(shortest(np.diff(observed.position, axis=0), observed.period), axis=2)
    speed = float(np.nanquantile(way, STRAIGHT)) * scale.length / (scale.seconds * scale.ticks)
    fits, evaluated, taken = [], 0, 0
    for name in request.models:
        parameters = fitted[name]
        if not parameters:
            raise InputError(f"which parameters of {name}? ABC needs --parameters")
        scaled = request.scaled(name, scale, speed, parameters)
        job = SimulationJob(scaled, observed)
        shares = np.random.default_rng(request.seed).uniform(
            1e-6, 1.0 - 1e-6, (request.runs, len(parameters))
        )
        low, high = np.array([parameter.range for parameter in parameters]).T
        draws = low + shares * (high - low)
        points = [{p.name: float(v) for p, v in zip(parameters, row, strict=True)} for row in draws]
        first = job.flock(points[0], 0)
        basis, identity = basis_of(first), {
            "fixed": scaled.fixed, "frames": observed.digest, "ticks": observed.ticks,
        }  # fmt: skip
        cells = [
            FitCell((point, k), {"model": name, **point}, {**identity, "seed": k}, basis)
            for k, point in enumerate(points)
        ]
        done = evaluate_cells(
            f"runs of {name} beside {tracks.name}", folder, job, ["polarisation"], cells,
            lambda first=first: compile_loop(first, settings.tell), settings,  # type: ignore[misc]
        )  # fmt: skip
        evaluated, taken = evaluated + done.made, taken + done.taken
        table = np.full((len(cells), len(BINS) + 4), np.nan)
        place = {number: k for k, number in enumerate(done.numbers)}
        for number, _, column, _, values in StoreReader(folder).series():
            if column == "summaries" and number in place:
                table[place[number]] = values
        fits.append(abc_fit(scaled, parameters, shares, table, observed))
    words = scale.describe() + "; a speed is that of the longest ways, which are not all straight"
    return AbcResult(tracks.name, tuple(fits), words, evaluated, taken)


def abc_fit(
    scaled: ScaledModel,
    parameters: tuple[FittedParameter, ...],
    shares: np.ndarray,
    table: np.ndarray,
    observed: ObservedFrames,
) -> AbcFit:
    """The fit of one model from its draws, as shares (D, P) of the ranges, and summaries (D, S)."""
    seen = summarise(observed.position, observed.period, observed.edges)
    sound = np.isfinite(table).all(axis=1)
    shares, table = shares[sound], table[sound]
    middle, spread = standardise(table)
    summaries, target = (table - middle) / spread, (seen - middle) / spread
    low, high = np.array([parameter.range for parameter in parameters]).T
    adjusted, weight = adjusted_draws(summaries, shares, target)
    middle_distance = nearest_draws(summaries, target)[1].mean()
    held, errors, distances = [], [], []
    for k in range(min(LEFT_OUT, len(shares))):
        others = np.arange(len(shares)) != k
        own, own_weight = adjusted_draws(summaries[others], shares[others], summaries[k])
        ends = np.array([weighted_quantiles(column, own_weight, QUANTILES) for column in own.T])
        held.append((ends[:, 0] <= shares[k]) & (shares[k] <= ends[:, 2]))
        errors.append(np.abs(ends[:, 1] - shares[k]) * (high - low))
        distances.append(nearest_draws(summaries[others], summaries[k])[1].mean())
    coverage, error = np.mean(held, axis=0), np.median(errors, axis=0)
    posteriors = []
    for column, parameter in enumerate(parameters):
        ends = weighted_quantiles(adjusted[:, column], weight, QUANTILES)
        values = low[column] + ends * (high[column] - low[column])
        posteriors.append(
            Posterior(
                name=parameter.name,
                unit=parameter.unit,
                low=float(values[0]),
                median=float(values[1]),
                high=float(values[2]),
                coverage=float(coverage[column]),
                error=float(error[column]),
                is_told=bool(ends[2] - ends[0] < 0.5),
            )
        )
    return AbcFit(
        scaled.name, tuple(posteriors), low + shares * (high - low), table, seen,
        low + adjusted * (high - low), weight,
        float(np.mean(np.array(distances) < middle_distance)), scaled.notes,
    )  # fmt: skip
