"""A fit by one-step prediction: all cells evaluated, the best judged on frames held back."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from agents.catalogue import model as find_model
from agents.models.declare import checked, declared
from app.tracks.fit.fit_region import (
    cells_like_best,
    has_moved,
    mean_interval,
    parameter_regions,
)
from app.tracks.fit.fit_request import FitRequest, demand_dimensions
from app.tracks.fit.fit_result import FitResult, ModelFit, WindowFit
from app.tracks.fit.fit_study import DEFAULT_SETTINGS, FitCells, FitStudy, RunnerSettings
from app.tracks.fit.fitted_parameter import FittedParameter, grid
from app.tracks.fit.frame_sample import HeldBackFrames, sample_frames
from app.tracks.fit.one_step import OneStepPredictor, costs_of_kept_headings
from app.tracks.playing.tracks_world import world_of_tracks
from app.tracks.tracks import PIXELS, Tracks
from worlds.input_error import InputError

FIRST, SECOND, SHUFFLED = "cost", "cost at the second window", "cost shuffled"


def fit_by_one_step(
    tracks: Tracks,
    request: FitRequest,
    folder: Path,
    settings: RunnerSettings = DEFAULT_SETTINGS,
) -> FitResult:
    """Fit models to tracks; begun again with the same folder it goes on where it was stopped.

    Raises FitStoppedError where it was asked to stop, and InputError.
    """
    demand_dimensions(tracks, request.models)
    fitted = request.fitted()
    for name, parameters in fitted.items():
        demand_no_noise(name, parameters, request)
    if tracks.unit != PIXELS:
        tracks = tracks.in_metres()
    scale = request.scale_of(tracks)
    if scale.ticks > 1:
        raise InputError(
            f"ticks = {scale.ticks}: one-step prediction needs frames that are a tick apart or "
            "less; with several ticks in a frame take --method abc"
        )
    first, second = two_windows(tracks, request)
    speed = float(np.nanmedian(first.motion.speed))
    world = world_of_tracks(tracks, 1.0 / scale.length)
    scaled = {name: request.scaled(name, scale, speed, fitted[name]) for name in request.models}
    predictors = [OneStepPredictor(scaled[name], world) for name in request.models]
    points = [list(grid(fitted[name])) for name in request.models]
    for name, own_points in zip(request.models, points, strict=True):
        for point in own_points:
            checked(scaled[name].model.parameters, {**scaled[name].fixed, **point})
    samples = {FIRST: first.fitted, SECOND: second.fitted} | {
        f"{SHUFFLED} {k}": first.fitted.with_shuffled_headings(request.seed + k)
        for k in range(1, request.shuffles + 1)
    }
    study = FitStudy(
        f"fit of {', '.join(request.models)} to {tracks.name}",
        folder, predictors, samples, points, settings,
    )  # fmt: skip
    cells = study.evaluate()
    step = speed * scale.seconds
    return FitResult(
        tracks=tracks.name,
        fits=tuple(
            model_fit(predictor, fitted[predictor.scaled.name], own_cells, first, second, request)
            for predictor, own_cells in zip(predictors, cells, strict=True)
        ),
        scale=scale.describe() + f"; {describe_world(tracks)}",
        speed=speed,
        unit=tracks.unit,
        noise_share=first.motion.noise / step if step > 0.0 else float("nan"),
        fitted_frames=tuple(first.fitted.frame.tolist()),
        held_back_frames=tuple(first.held_back.frame.tolist()),
        evaluated=study.made,
        taken=study.taken,
    )


def two_windows(tracks: Tracks, request: FitRequest) -> tuple[HeldBackFrames, HeldBackFrames]:
    """The frames at both windows of the smoothing, the same ones. Raises InputError."""
    if len(tracks.time) < 2:
        raise InputError(f"{tracks.name} has 1 frame: nothing can be foretold of it")
    scale = request.scale_of(tracks)
    windows = request.windows(tracks.step)
    common = scale, request.frames_of_half, request.least_speed, request.use_file_headings
    # The longer window has fewer whole stretches: it chooses, so that both have the same frames.
    longer = sample_frames(tracks, scale, max(windows), *common[1:])
    rows = tuple(
        np.searchsorted(tracks.frame, sample.frame) for sample in (longer.fitted, longer.held_back)
    )
    shorter = sample_frames(tracks, scale, min(windows), *common[1:], chosen=rows)  # type: ignore[arg-type]
    return (shorter, longer) if windows[0] < windows[1] else (longer, shorter)


def demand_no_noise(
    name: str, parameters: tuple[FittedParameter, ...], request: FitRequest
) -> None:
    """Raise InputError for a strength of noise: a prediction has none, and tells nothing of it."""
    declarations = declared(find_model(name).parameters)
    noises = {declaration.name for declaration in declarations if declaration.noise}
    for parameter in parameters:
        if parameter.name in noises and request.method == "one-step":
            raise InputError(
                f"{parameter.name} of {name} is noise, and one-step prediction has none: take "
                "--method likelihood for the Vicsek family, or --method abc"
            )


def describe_world(tracks: Tracks) -> str:
    """The world that the predictions are made in, in words."""
    if any(tracks.period):
        sides = " x ".join(f"{side:g}" if side else "open" for side in tracks.period)
        return f"the world wraps, {sides} {tracks.unit}"
    return "the world is open" + (", with the walls of the file" if tracks.boundary else "")


def model_fit(
    predictor: OneStepPredictor,
    parameters: tuple[FittedParameter, ...],
    cells: FitCells,
    first: HeldBackFrames,
    second: HeldBackFrames,
    request: FitRequest,
) -> ModelFit:
    """The fit of one model from the costs of its cells."""
    points = np.array([[point[p.name] for p in parameters] for point in cells.points])
    points = points.reshape(len(cells.points), len(parameters))
    fits = [
        window_fit(frames, parameters, points, cells.costs[column], request.seed)
        for frames, column in ((first, FIRST), (second, SECOND))
    ]
    best = cells.points[fits[0].best]
    null, cost = costs_of_kept_headings(first.held_back), predictor.costs(first.held_back, best)
    skills, gains = [], []
    for k in range(1, request.shuffles + 1):
        shuffled = first.held_back.with_shuffled_headings(-request.seed - k + 2**31)
        chosen = cells.points[least_cell(cells.costs[f"{SHUFFLED} {k}"])]
        own = float(np.mean(costs_of_kept_headings(shuffled)))
        shuffled_cost = float(np.mean(predictor.costs(shuffled, chosen)))
        skills.append(1.0 - shuffled_cost / own)
        gains.append(own - shuffled_cost)
    return ModelFit(
        model=predictor.scaled.name,
        parameters=parameters,
        points=points,
        first=fits[0],
        second=fits[1],
        fixed=predictor.scaled.fixed,
        notes=predictor.scaled.notes,
        cost=float(np.mean(cost)),
        null_cost=float(np.mean(null)),
        gain=mean_interval(null - cost, request.seed),
        shuffled_skills=tuple(skills),
        shuffled_gain=float(np.mean(gains)),
        has_moved=has_moved(parameters, fits[0].regions, fits[1].regions),
    )


def least_cell(costs: np.ndarray) -> int:
    """The cell of the least mean cost, of costs (C, F); cells without costs are none."""
    means = costs.mean(axis=1)
    return int(np.argmin(np.where(np.isfinite(means), means, np.inf)))


def window_fit(
    frames: HeldBackFrames,
    parameters: tuple[FittedParameter, ...],
    points: np.ndarray,
    costs: np.ndarray,
    seed: int,
) -> WindowFit:
    """The fit at one window, from the costs (C, F) of its cells."""
    best = least_cell(costs)
    in_region = cells_like_best(costs, best, seed)
    return WindowFit(
        window=frames.window,
        frames=frames.motion.frames,
        costs=costs.mean(axis=1),
        best=best,
        regions=parameter_regions(parameters, points, in_region, best),
        in_region=in_region,
        null_cost=float(np.mean(costs_of_kept_headings(frames.fitted))),
    )
