"""The likelihood of the Vicsek family: what is left of each turn, and how wide its noise is.

The rule adds to the mean heading an angle that is uniform in [-eta/2, eta/2]. Of a parameter such
as r the best is therefore the one that leaves residuals of the least variance, and
eta = sqrt(12 var). The largest residual would tell eta as well, but one outlier spoils it.
Headings are those of the file, or of the steps, unsmoothed: smoothing would take noise away, which
is what is asked for. The step from a frame to the next is the heading of the next, but in models
that move along their old heading.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from agents.catalogue import model as find_model
from agents.flock import Flock
from agents.models.declare import checked
from agents.motion.flock_loop import NOISE
from agents.spec import Spec
from app.tracks.fit.fit_region import (
    ParameterRegion,
    cells_like_best,
    mean_interval,
    parameter_regions,
)
from app.tracks.fit.fit_request import FitRequest, demand_dimensions
from app.tracks.fit.fit_result import describe_point
from app.tracks.fit.fit_study import DEFAULT_SETTINGS, FitCells, FitStudy, RunnerSettings
from app.tracks.fit.fitted_parameter import FittedParameter, grid
from app.tracks.fit.frame_sample import FrameSample, HeldBackFrames, sample_frames
from app.tracks.fit.one_step import OneStepPredictor, costs_of_kept_headings
from app.tracks.fit.one_step_fit import describe_world, least_cell
from app.tracks.playing.tracks_world import world_of_tracks
from app.tracks.tracks import PIXELS, Tracks
from worlds.input_error import InputError
from worlds.world import World

FRAMES = 150
"""Of each half of the time, where nobody says how many."""
FINER = 10
"""How many times finer the grid is around its best."""
OUTSIDE = 1.05
"""How many times as large as eta / 2 a residual is that is not the rule's noise."""


@dataclass(frozen=True, eq=False)
class LikelihoodFit:
    """What the residuals say of one model of the Vicsek family."""

    model: str
    parameters: tuple[FittedParameter, ...]
    points: np.ndarray
    """(C, D) all values tried, the coarse grid first."""
    variances: np.ndarray
    """(C,) of the residuals, on the frames of the fit, rad^2."""
    best: dict[str, float]
    regions: tuple[ParameterRegion, ...]
    eta: float
    """rad."""
    eta_interval: tuple[float, float]
    """rad, 95 % by bootstrap over frames."""
    outside: float
    """Share of residuals that are outside of the noise of this eta."""
    cost: float
    """Mean square of the residuals on frames held back, rad^2."""
    null_cost: float
    """Of keeping the heading there, rad^2."""
    gain: tuple[float, float]
    """95 % interval of the null's cost minus the model's there, rad^2."""
    shuffled_skills: tuple[float, ...]
    notes: tuple[str, ...]

    @property
    def skill(self) -> float:
        """The share of the null's cost that the model takes away on frames held back."""
        return 1.0 - self.cost / self.null_cost

    @property
    def explains(self) -> bool:
        """Whether it beats keeping the heading, and headings shuffled in time."""
        return self.gain[0] > 0.0 and self.skill > max(self.shuffled_skills)

    def sentences(self) -> list[str]:
        """What is said of it, a sentence each."""
        if not self.explains:
            what = (
                f"keeping the heading (cost {self.cost:.4g}, keeping the heading "
                f"{self.null_cost:.4g} rad^2)"
                if self.gain[0] <= 0.0
                else f"with headings shuffled in time ({100 * max(self.shuffled_skills):.1f} %, "
                f"without {100 * self.skill:.1f} %)"
            )
            return [
                f"{self.model} explains nothing: on frames it has not seen it is no better than "
                f"{what}."
            ]
        low, high = self.eta_interval
        told = "; ".join(region.describe() for region in self.regions)
        lines = [
            f"Of what can be foretold beyond keeping the heading, {self.model} explains "
            f"{100 * self.skill:.0f} % on frames it has not seen (headings shuffled in time: "
            f"{100 * max(self.shuffled_skills):.0f} % at most).",
            f"{told}; eta {low:.4g} to {high:.4g} rad (best {describe_point(self.best)}, eta "
            f"{self.eta:.4g}; not smoothed: noise of places would make eta larger).",
        ]
        if self.outside > 0.01:
            lines.append(
                f"{100 * self.outside:.1f} % of the residuals are outside of [-eta/2, eta/2]: the "
                "noise is not, or not only, that of the rule."
            )
        return lines

    def to_dict(self) -> dict[str, Any]:
        """All of it as plain values, for JSON."""
        return {
            "model": self.model,
            "explains": self.explains,
            "parameters": [parameter.name for parameter in self.parameters],
            "points": self.points.tolist(),
            "variances": self.variances.tolist(),
            "best": self.best,
            "regions": [vars(region) for region in self.regions],
            "eta": self.eta,
            "eta_interval": list(self.eta_interval),
            "outside": self.outside,
            "cost": self.cost,
            "null_cost": self.null_cost,
            "skill": self.skill,
            "gain": list(self.gain),
            "shuffled_skills": list(self.shuffled_skills),
            "notes": list(self.notes),
            "sentences": self.sentences(),
        }


@dataclass(frozen=True, eq=False)
class LikelihoodResult:
    """A fit of models of the Vicsek family by the likelihood of their residuals."""

    tracks: str
    fits: tuple[LikelihoodFit, ...]
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
        """One row for each rule on the frames held back: the null first, then the models."""
        rows: list[dict[str, Any]] = [
            {"rule": "keeps its heading", "cost": self.fits[0].null_cost, "skill": 0.0,
             "shuffled": None, "parameters": "", "explains": None}
        ]  # fmt: skip
        return rows + [
            {
                "rule": fit.model,
                "cost": fit.cost,
                "skill": fit.skill,
                "shuffled": max(fit.shuffled_skills),
                "parameters": f"{describe_point(fit.best)}, eta {fit.eta:.4g}",
                "explains": fit.explains,
            }
            for fit in self.fits
        ]

    def to_dict(self) -> dict[str, Any]:
        """All of it as plain values, for JSON."""
        return {
            "method": "likelihood",
            "tracks": self.tracks,
            "scale": self.scale,
            "evaluated": self.evaluated,
            "taken": self.taken,
            "table": self.table(),
            "models": [fit.to_dict() for fit in self.fits],
            "sentences": self.sentences(),
        }


def moves_along_old_heading(name: str) -> bool:
    """Whether a model's agents move along the heading that they had before the tick.

    Two agents side by side, at right angles, are run for a tick: their steps say it.
    """
    # They are nearer to each other than any radius can be.
    start = {"position": np.array([[5.0, 5.0], [5.01, 5.0]]), "heading": np.eye(2)}
    world = World(size=(10.0, 10.0), edges=("open",))
    flock = Flock(Spec(name, world=world, seed=0, parameters={"v0": 0.01}), start=start)
    flock.advance(1)
    step = flock.arrays.position - start["position"]
    along = [(step * heading).sum() for heading in (start["heading"], flock.arrays.heading)]
    return along[0] > along[1]


def signed_residuals(sample: FrameSample, predicted: np.ndarray) -> np.ndarray:
    """The angle from the predicted to the next heading of all who are judged, rad in (-pi, pi]."""
    a, b = predicted[sample.judged], sample.following[sample.judged]
    return np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1))


def fit_by_likelihood(
    tracks: Tracks,
    request: FitRequest,
    folder: Path,
    settings: RunnerSettings = DEFAULT_SETTINGS,
) -> LikelihoodResult:
    """Fit models of the Vicsek family; begun again with the same folder it goes on.

    Parameters are those asked for beside eta, by default r. Raises FitStoppedError, InputError.
    """
    request = replace(
        request, parameters=tuple(p for p in request.parameters if p != NOISE) or ("r",)
    )
    if tracks.dim != 2:
        raise InputError(f"{tracks.name} is {tracks.dim}-D: the likelihood is that of the plane")
    for name in request.models:
        if NOISE not in find_model(name).parameters.model_fields:
            raise InputError(
                f"{name} is not of the Vicsek family: it has no {NOISE}; take --method one-step"
            )
    demand_dimensions(tracks, request.models)
    fitted = request.fitted()
    for parameters in fitted.values():
        if any(parameter.name == NOISE for parameter in parameters):
            raise InputError(f"{NOISE} has no range here: it follows from what the best leaves")
    if tracks.unit != PIXELS:
        tracks = tracks.in_metres()
    scale = request.scale_of(tracks)
    world = world_of_tracks(tracks, 1.0 / scale.length)
    fits, evaluated, taken = [], 0, 0
    for name in request.models:
        frames = step_frames(tracks, request, moves_along_old_heading(name))
        speed = float(np.nanmedian(frames.motion.speed))
        scaled = request.scaled(name, scale, speed, fitted[name])
        predictor = OneStepPredictor(scaled, world, math.pi)
        for point in grid(fitted[name]):
            checked(scaled.model.parameters, {**scaled.fixed, **point})
        search = LikelihoodSearch(predictor, fitted[name], frames, request, folder, settings)
        fits.append(search.fit())
        evaluated, taken = evaluated + search.evaluated, taken + search.taken
    return LikelihoodResult(
        tracks.name, tuple(fits), scale.describe() + f"; {describe_world(tracks)}", evaluated, taken
    )


def step_frames(tracks: Tracks, request: FitRequest, is_old: bool) -> HeldBackFrames:
    """Frames with headings of the file if there are any, else of the steps. Raises InputError."""
    scale = request.scale_of(tracks)
    if tracks.heading is None and is_old:
        # The step from a frame on is the heading of that frame, not of the next.
        steps = np.full(tracks.position.shape, np.nan)
        steps[:-1] = step_directions(tracks)
        tracks = replace(tracks, heading=steps)
    frames = FRAMES if request.frames is None else request.frames
    return sample_frames(
        tracks, scale, 0.0, frames, request.least_speed, tracks.heading is not None
    )


def step_directions(tracks: Tracks) -> np.ndarray:
    """Unit vectors from each frame to the next, (T - 1, N, dim), around where the world wraps."""
    step = np.diff(tracks.position, axis=0)
    for axis, side in enumerate(tracks.period):
        if side > 0.0:
            step[..., axis] -= side * np.round(step[..., axis] / side)
    length = np.linalg.norm(step, axis=2, keepdims=True)
    return step / np.where(length > 0.0, length, np.nan)


@dataclass
class LikelihoodSearch:
    """The search of one model: a coarse grid, then a finer one around its best."""

    predictor: OneStepPredictor
    parameters: tuple[FittedParameter, ...]
    frames: HeldBackFrames
    request: FitRequest
    folder: Path
    settings: RunnerSettings
    evaluated: int = 0
    taken: int = 0

    def fit(self) -> LikelihoodFit:
        """Search, and judge the best on frames held back."""
        coarse = self.evaluate(self.parameters, self.frames.fitted, "residuals")
        centre = coarse.points[least_cell(coarse.costs["residuals"])]
        finer = tuple(
            self.finer(parameter, centre[parameter.name]) for parameter in self.parameters
        )
        fine = self.evaluate(finer, self.frames.fitted, "residuals")
        points = [*coarse.points, *fine.points]
        costs = np.concatenate([coarse.costs["residuals"], fine.costs["residuals"]])
        cell = least_cell(costs)
        best, names = points[cell], [parameter.name for parameter in self.parameters]
        table = np.array([[point[name] for name in names] for point in points])
        is_like = cells_like_best(costs, cell, self.request.seed)
        held, predictor = self.frames.held_back, self.predictor
        null = costs_of_kept_headings(held, math.pi)
        cost = predictor.costs(held, best)
        residuals = [
            signed_residuals(sample, predictor.predict(sample, best))
            for sample in (self.frames.fitted, held)
        ]
        squares = np.concatenate([predictor.costs(self.frames.fitted, best), cost])
        eta = math.sqrt(12.0 * float(np.concatenate(residuals).var()))
        low, high = (math.sqrt(12.0 * end) for end in mean_interval(squares, self.request.seed))
        far = np.abs(np.concatenate(residuals)) > OUTSIDE * eta / 2.0
        return LikelihoodFit(
            model=predictor.scaled.name,
            parameters=self.parameters,
            points=table,
            variances=costs.mean(axis=1),
            best=dict(best),
            regions=parameter_regions(self.parameters, table, is_like, cell),
            eta=eta,
            eta_interval=(low, high),
            outside=float(far.mean()),
            cost=float(np.mean(cost)),
            null_cost=float(np.mean(null)),
            gain=mean_interval(null - cost, self.request.seed),
            shuffled_skills=self.shuffled_skills(),
            notes=predictor.scaled.notes,
        )

    def finer(self, parameter: FittedParameter, centre: float) -> FittedParameter:
        """Values around a centre, one step of the grid to each side, within the range."""
        values = np.array(parameter.values)
        step = float(np.diff(values).min())
        around = centre + step * np.arange(-FINER, FINER + 1) / FINER
        around = around[(around >= values[0]) & (around <= values[-1])]
        return replace(parameter, values=tuple(float(f"{value:.12g}") for value in around))

    def evaluate(
        self, parameters: tuple[FittedParameter, ...], sample: FrameSample, column: str
    ) -> FitCells:
        """The costs of a grid on a sample."""
        study = FitStudy(
            f"likelihood of {self.predictor.scaled.name}", self.folder, [self.predictor],
            {column: sample}, [list(grid(parameters))], self.settings,
        )  # fmt: skip
        (cells,) = study.evaluate()
        self.evaluated, self.taken = self.evaluated + study.made, self.taken + study.taken
        return cells

    def shuffled_skills(self) -> tuple[float, ...]:
        """Skills of fits to headings shuffled in time, on such frames held back."""
        skills = []
        for k in range(1, self.request.shuffles + 1):
            shuffled = self.frames.fitted.with_shuffled_headings(self.request.seed + k)
            cells = self.evaluate(self.parameters, shuffled, f"shuffled {k}")
            point = cells.points[least_cell(cells.costs[f"shuffled {k}"])]
            held = self.frames.held_back.with_shuffled_headings(2**31 - self.request.seed - k)
            null = float(np.mean(costs_of_kept_headings(held, math.pi)))
            skills.append(1.0 - float(np.mean(self.predictor.costs(held, point))) / null)
        return tuple(skills)
