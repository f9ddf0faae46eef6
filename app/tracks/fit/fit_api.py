"""A fit from a script or a notebook, by any method: the same as on the command line."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from app.studies.study_runner import At
from app.studies.workers.process_executor import cores
from app.tracks.fit.approximate_bayes import AbcResult, fit_by_abc
from app.tracks.fit.fit_request import FitRequest, Method
from app.tracks.fit.fit_result import FitResult
from app.tracks.fit.fit_study import FitStoppedError, RunnerSettings
from app.tracks.fit.one_step_fit import fit_by_one_step
from app.tracks.fit.synthetic_truth import check_by_synthetic_truth
from app.tracks.fit.vicsek_likelihood import LikelihoodResult, fit_by_likelihood
from app.tracks.tracks import Tracks
from worlds.input_error import InputError

AnyResult = FitResult | LikelihoodResult | AbcResult
SYNTHETIC = "synthetic"
"""The folder of the runs of synthetic truths, in that of a fit."""


def fit(
    tracks: Tracks,
    model: str | Sequence[str],
    parameters: str | Sequence[str] = (),
    *,
    method: Method = "one-step",
    length: float | None = None,
    every: int = 1,
    ticks: int = 1,
    window: float | None = None,
    second_window: float | None = None,
    frames: int | None = None,
    least_speed: float = 0.0,
    use_file_headings: bool = False,
    shuffles: int = 5,
    runs: int = 1000,
    synthetic: int = 0,
    seed: int = 1,
    folder: str | Path | None = None,
    workers: int | None = None,
    tell: Callable[[str], Any] | None = None,
    at: At = lambda *_: None,
    **settings: Any,
) -> AnyResult:
    """Find parameters of models from tracks, and say what the tracks tell of them.

    Parameters
    ----------
    model: the name of one, or of several that are compared.
    parameters: each `NAME` or `NAME=LOW:HIGH:STEPS`; a model takes those that it has.
    method: `one-step` prediction by the model's own rule, for any model; `likelihood` for the
        Vicsek family; `abc` for frames too far apart for a prediction.
    length: units of the tracks in one length of the model; by default 1 m.
    every: frames that a tick takes. ticks: ticks that a frame takes, for `abc`.
    window, second_window: seconds of the smoothing, by default 7 and 11 frames.
    frames: of each half of the time, the first for the fit and the second held back, at most.
    least_speed: below which there is no heading. use_file_headings: headings of the file.
    shuffles: how often headings are shuffled in time and fitted. runs: of `abc`.
    synthetic: how many synthetic truths are fitted at each of several noises.
    folder: where evaluations are kept, so that the same call goes on after a stop.
    at: hears of the share done, the seconds left, and words. settings: other parameters.

    Raises InputError.

    >>> import numpy as np
    >>> from flockscope import Flock
    >>> from flockscope.tracks import Tracks
    >>> flock = Flock("vem", agents=40, size=4.0, eta=0.5, r=1.0, v0=0.1, rng=1)
    >>> place = flock.trace(60)
    >>> frame = np.arange(60)
    >>> seen = Tracks(place, frame, 1.0 * frame, tuple(map(str, range(40))), "m", period=(4.0, 4.0))
    >>> found = fit(seen, "vem", "r=0.5:1.5:3", method="likelihood", frames=20, workers=1)
    >>> found.fits[0].best["r"], round(found.fits[0].eta, 1)
    (1.0, 0.5)
    """
    request = FitRequest(
        models=(model,) if isinstance(model, str) else tuple(model),
        parameters=split_names(parameters),
        settings=settings,
        method=method,
        every=every,
        ticks=ticks,
        length=length,
        window=window,
        second_window=second_window,
        frames=frames,
        least_speed=least_speed,
        use_file_headings=use_file_headings,
        shuffles=shuffles,
        runs=runs,
        seed=seed,
    )
    runner = RunnerSettings(workers=workers or cores(), tell=tell, at=at)
    with tempfile.TemporaryDirectory(prefix="flockscope-fit-") as temporary:
        place = Path(temporary) if folder is None else Path(folder)
        try:
            return fit_request(tracks, request, place, runner, synthetic)
        except FitStoppedError:
            raise InputError(
                f"the fit in {str(place)!r} was asked to stop: the same call goes on"
            ) from None


def split_names(parameters: str | Sequence[str]) -> tuple[str, ...]:
    """The parameters of one text with commas, or of several.

    >>> split_names("dr_o,dr_a=0:30:16"), split_names(["dr_o", "dr_a"])
    (('dr_o', 'dr_a=0:30:16'), ('dr_o', 'dr_a'))
    """
    texts = [parameters] if isinstance(parameters, str) else parameters
    return tuple(part.strip() for text in texts for part in text.split(",") if part.strip())


def fit_request(
    tracks: Tracks,
    request: FitRequest,
    folder: Path,
    runner: RunnerSettings,
    synthetic: int = 0,
) -> AnyResult:
    """Carry out a request by its method; `synthetic` truths at each noise for models that explain.

    Raises FitStoppedError and InputError.
    """
    if synthetic and request.method != "one-step":
        raise InputError(f"synthetic truths are of one-step prediction, not of {request.method}")
    if request.method == "likelihood":
        return fit_by_likelihood(tracks, request, folder, runner)
    if request.method == "abc":
        return fit_by_abc(tracks, request, folder, runner)
    result = fit_by_one_step(tracks, request, folder, runner)
    if not synthetic:
        return result
    checks = tuple(
        check_by_synthetic_truth(tracks, request, fit, folder / SYNTHETIC, synthetic, runner)
        for fit in result.fits
        if fit.explains and fit.parameters
    )
    return replace(result, checks=checks)
