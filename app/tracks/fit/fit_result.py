"""What a fit has come to: costs, bests, regions, and what is said of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from agents.catalogue import model as find_model
from agents.models.declare import declared
from app.tracks.fit.fit_region import ParameterRegion
from app.tracks.fit.fitted_parameter import FittedParameter


@dataclass(frozen=True, eq=False)
class WindowFit:
    """The fit at one window of the smoothing."""

    window: float
    """s; 0 without smoothing."""
    frames: int
    """Frames of the window."""
    costs: np.ndarray
    """(C,) the mean cost of each cell on the frames of the fit, rad^2."""
    best: int
    """The cell of the least cost."""
    regions: tuple[ParameterRegion, ...]
    in_region: np.ndarray
    """(C,) bool: the cells that the frames cannot tell from the best."""
    null_cost: float
    """Of keeping the heading, on the frames of the fit, rad^2."""


@dataclass(frozen=True, eq=False)
class ModelFit:
    """What the tracks say of one model."""

    model: str
    parameters: tuple[FittedParameter, ...]
    points: np.ndarray
    """(C, D) the values of each cell, the last parameter changing first."""
    first: WindowFit
    second: WindowFit
    fixed: Mapping[str, Any]
    """Parameters that were set: by the user, the scale, the data; noise off."""
    notes: tuple[str, ...]
    """What was set and why."""
    cost: float
    """Of the best cell on the frames held back, rad^2."""
    null_cost: float
    """Of keeping the heading there, rad^2."""
    gain: tuple[float, float]
    """95 % interval of the null's cost minus the model's there, rad^2."""
    shuffled_skills: tuple[float, ...]
    """The skill of the model fitted to headings shuffled in time, on such frames held back."""
    shuffled_gain: float
    """The mean of the null's cost minus the model's on those, rad^2."""
    has_moved: bool
    """Whether the second window has its best outside of the region of the first."""

    @property
    def best(self) -> dict[str, float]:
        """The best values."""
        names = [parameter.name for parameter in self.parameters]
        return dict(zip(names, self.points[self.first.best].tolist(), strict=True))

    @property
    def model_noises(self) -> set[str]:
        """The parameters of the model that are noise."""
        parameters = find_model(self.model).parameters
        return {declaration.name for declaration in declared(parameters) if declaration.noise}

    @property
    def skill(self) -> float:
        """The share of the null's cost that the model takes away on frames held back; <= 1."""
        return 1.0 - self.cost / self.null_cost

    @property
    def beats_null(self) -> bool:
        """Whether it is surely better than keeping the heading."""
        return self.gain[0] > 0.0

    @property
    def beats_shuffled(self) -> bool:
        """Whether it is better than with headings shuffled in time, of which it may foretell as
        much where all go one way anyway."""
        return self.skill > max(self.shuffled_skills) and self.gain[0] > self.shuffled_gain

    @property
    def explains(self) -> bool:
        """Whether it beats both."""
        return self.beats_null and self.beats_shuffled

    def sentences(self) -> list[str]:
        """What is said of it, a sentence each."""
        windows = f"window {self.first.window:.3g} s, second window {self.second.window:.3g} s"
        if not self.beats_null:
            low, high = self.gain
            return [
                f"{self.model} explains nothing: on frames it has not seen it is no better than "
                f"keeping the heading (cost {self.cost:.4g}, keeping the heading "
                f"{self.null_cost:.4g} rad^2, 95 % interval of the gain {low:.2g} to {high:.2g}; "
                f"{windows})."
            ]
        if not self.beats_shuffled:
            return [
                f"{self.model} explains nothing: with headings shuffled in time it foretells as "
                f"much ({100 * max(self.shuffled_skills):.1f} %, unshuffled "
                f"{100 * self.skill:.1f} %), so who is near whom does not matter, and nothing is "
                f"told of its parameters ({windows})."
            ]
        lines = [
            f"Of what can be foretold beyond keeping the heading, {self.model} explains "
            f"{100 * self.skill:.0f} % on frames it has not seen (headings shuffled in time: "
            f"{100 * max(self.shuffled_skills):.0f} % at most)."
        ]
        if not self.parameters:
            return lines
        if self.has_moved:
            lines.append(
                f"No region: with a window of {self.first.window:.3g} s the best is "
                f"{describe_point(self.best)}, with {self.second.window:.3g} s it is "
                f"{describe_point(self.second_best)}; the answer hangs on the smoothing."
            )
        else:
            told = "; ".join(region.describe() for region in self.first.regions)
            lines.append(
                f"{told} (best {describe_point(self.best)}; window {self.first.window:.3g} s; with "
                f"{self.second.window:.3g} s the best is {describe_point(self.second_best)})."
            )
        return lines

    @property
    def second_best(self) -> dict[str, float]:
        """The best values of the second window."""
        names = [parameter.name for parameter in self.parameters]
        return dict(zip(names, self.points[self.second.best].tolist(), strict=True))

    def to_dict(self) -> dict[str, Any]:
        """All of it as plain values, for JSON."""

        def of_window(fit: WindowFit) -> dict[str, Any]:
            return {
                "window": fit.window,
                "frames": fit.frames,
                "costs": fit.costs.tolist(),
                "in_region": fit.in_region.tolist(),
                "best": dict(zip(names, self.points[fit.best].tolist(), strict=True)),
                "null_cost": fit.null_cost,
                "regions": [asdict(region) for region in fit.regions],
            }

        names = [parameter.name for parameter in self.parameters]
        return {
            "model": self.model,
            "explains": self.explains,
            "beats_null": self.beats_null,
            "beats_shuffled": self.beats_shuffled,
            "skill": self.skill,
            "cost": self.cost,
            "null_cost": self.null_cost,
            "gain": list(self.gain),
            "shuffled_skills": list(self.shuffled_skills),
            "best": self.best,
            "has_moved": self.has_moved,
            "parameters": [asdict(parameter) for parameter in self.parameters],
            "points": self.points.tolist(),
            "first": of_window(self.first),
            "second": of_window(self.second),
            "fixed": dict(self.fixed),
            "notes": list(self.notes),
            "sentences": self.sentences(),
        }


def describe_point(point: Mapping[str, float]) -> str:
    """Values of parameters in words.

    >>> describe_point({"dr_o": 3.0, "dr_a": 10.0})
    'dr_o 3, dr_a 10'
    """
    return ", ".join(f"{name} {value:g}" for name, value in point.items()) or "without parameters"


@dataclass(frozen=True, eq=False)
class FitResult:
    """A fit of one or several models to tracks by one-step prediction."""

    tracks: str
    """The name of the tracks."""
    fits: tuple[ModelFit, ...]
    scale: str
    """How seconds and lengths became ticks and lengths of the models."""
    speed: float
    """Median of the tracks, their unit/s."""
    unit: str
    noise_share: float
    """Noise of places as a share of the way of a tick, from what the window leaves; or NaN."""
    fitted_frames: tuple[int, ...]
    """The numbers of the frames of the fit,"""
    held_back_frames: tuple[int, ...]
    """and of those held back from it."""
    evaluated: int = 0
    """Cells evaluated now."""
    taken: int = 0
    """Cells that the folder had."""
    checks: tuple[Any, ...] = field(default_factory=tuple)
    """Synthetic truths at several noises, if they were asked for."""

    @property
    def best(self) -> ModelFit:
        """The model of the least cost on frames held back."""
        return min(self.fits, key=lambda fit: fit.cost)

    def sentences(self) -> list[str]:
        """All that is said, the scale first."""
        lines = [f"{self.tracks}: {self.scale}; median speed {self.speed:.4g} {self.unit}/s."]
        lines += [f"{fit.model}: {'; '.join(fit.notes)}." for fit in self.fits if fit.notes]
        if np.isfinite(self.noise_share):
            lines.append(
                f"Places are noisy by {100 * self.noise_share:.0f} % of the way of a tick, as far "
                "as the window shows; they were smoothed first."
            )
        for fit in self.fits:
            lines += fit.sentences()
        if len(self.fits) > 1:
            explaining = [fit for fit in self.fits if fit.explains]
            if explaining:
                best = min(explaining, key=lambda fit: fit.cost)
                lines.append(f"On frames held back {best.model} foretells most.")
            else:
                lines.append("None of the models explains anything.")
        for check in self.checks:
            lines += check.sentences()
        return lines

    def table(self) -> list[dict[str, Any]]:
        """One row for each rule on the frames held back: the null first, then the models."""
        rows: list[dict[str, Any]] = [
            {"rule": "keeps its heading", "cost": self.fits[0].null_cost, "skill": 0.0,
             "shuffled": None, "parameters": "", "explains": None}
        ]  # fmt: skip
        rows += [
            {
                "rule": fit.model,
                "cost": fit.cost,
                "skill": fit.skill,
                "shuffled": max(fit.shuffled_skills),
                "parameters": describe_point(fit.best) if fit.parameters else "",
                "explains": fit.explains,
            }
            for fit in self.fits
        ]
        return rows

    def to_dict(self) -> dict[str, Any]:
        """All of it as plain values, for JSON."""
        return {
            "method": "one-step",
            "tracks": self.tracks,
            "scale": self.scale,
            "speed": self.speed,
            "unit": self.unit,
            "noise_share": self.noise_share,
            "fitted_frames": list(self.fitted_frames),
            "held_back_frames": list(self.held_back_frames),
            "evaluated": self.evaluated,
            "taken": self.taken,
            "table": self.table(),
            "models": [fit.to_dict() for fit in self.fits],
            "checks": [check.to_dict() for check in self.checks],
            "sentences": self.sentences(),
        }
