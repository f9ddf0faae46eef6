"""What a fit is asked for, checked: models, parameters, scale, windows, frames."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

from agents.catalogue import model as find_model
from app.tracks.fit.fitted_parameter import FittedParameter, fitted_parameters
from app.tracks.fit.tick_scale import ScaledModel, TickScale, scaled_model, tick_scale
from app.tracks.tracks import Tracks
from worlds.input_error import InputError, unknown

Method = Literal["one-step", "likelihood", "abc"]
METHODS: tuple[Method, ...] = get_args(Method)
FRAMES = 40
"""Of each half of the time, where nobody says how many."""
DEFAULT_WINDOW = 6
"""Steps between frames that the first window spans: 7 frames. With 5, noise of 50 % of a step
moves the best of a mill; see `tests/tracks/fit/test_fit_of_mill.py`."""
SECOND_WINDOW = 10
"""And the second one, 11 frames, unless the first is another: then it is as much longer."""
SHUFFLES = 5
"""Times that headings are shuffled in time and fitted again."""
MOST_FRAMES = 10_000


@dataclass(frozen=True)
class FitRequest:
    """What is fitted, and how. Raises InputError for numbers that cannot be."""

    models: tuple[str, ...]
    parameters: tuple[str, ...] = ()
    """Each `NAME` or `NAME=LOW:HIGH:STEPS`; a model takes those that it has."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """Other parameters; a model takes those that it has."""
    method: Method = "one-step"
    every: int = 1
    """Frames that a tick takes."""
    ticks: int = 1
    """Ticks that a frame takes, for ABC."""
    length: float | None = None
    """Units of the tracks in one length of the model; None: 1 m."""
    window: float | None = None
    """Seconds of the smoothing; None: 6 steps between frames."""
    second_window: float | None = None
    """Seconds of the smoothing of the second fit; None: as much longer as 10 is than 6."""
    frames: int | None = None
    """Of each half of the time, at most; None: 40, or 150 for the likelihood."""
    least_speed: float = 0.0
    """Below which there is no heading, unit of the tracks per s."""
    use_file_headings: bool = False
    shuffles: int = SHUFFLES
    runs: int = 1000
    """Simulated runs of ABC."""
    seed: int = 1
    """Of what is shuffled, drawn and simulated."""

    def __post_init__(self) -> None:
        if not self.models:
            raise InputError("which model? give --model NAME; `flockscope list models` names them")
        for name in self.models:
            if self.models.count(name) > 1:
                raise InputError(f"model {name!r} is given twice")
            find_model(name)
        if self.method not in METHODS:
            raise unknown("method", self.method, METHODS)
        for name in ("window", "second_window"):
            value = getattr(self, name)
            if value is not None and not 0.0 <= value < math.inf:
                raise InputError(
                    f"{name.replace('_', ' ')} = {value:g} s is not allowed: a finite time >= 0 is "
                    "needed"
                )
        bounds = {"frames": (10, MOST_FRAMES), "shuffles": (1, 1000), "runs": (50, 1_000_000)}
        for name, (least, most) in bounds.items():
            value = getattr(self, name)
            if value is not None and not least <= value <= most:
                raise InputError(f"{name} = {value} is outside [{least}, {most}]")

    def windows(self, step: float) -> tuple[float, float]:
        """Both windows in seconds, of frames `step` s apart. Raises InputError for equal ones."""
        first = DEFAULT_WINDOW * step if self.window is None else self.window
        second = self.second_window
        if second is None:
            second = max(first * SECOND_WINDOW / DEFAULT_WINDOW, first + 4.0 * step)
        if round(first / (2.0 * step)) == round(second / (2.0 * step)):
            raise InputError(
                f"windows of {first:.3g} s and {second:.3g} s are the same, of frames {step:.3g} s "
                "apart: the second has to differ by 2 frames or more"
            )
        return first, second

    @property
    def frames_of_half(self) -> int:
        """Frames of each half of the time, at most."""
        return FRAMES if self.frames is None else self.frames

    def scale_of(self, tracks: Tracks) -> TickScale:
        """The scale between the tracks and the models. Raises InputError."""
        return tick_scale(tracks, self.every, self.length, self.ticks)

    def fitted(self) -> dict[str, tuple[FittedParameter, ...]]:
        """The parameters in question of each model. Raises InputError."""
        models = [find_model(name) for name in self.models]
        for name in self.settings:
            if not any(name in model.parameters.model_fields for model in models):
                known = dict.fromkeys(
                    field for model in models for field in model.parameters.model_fields
                )
                raise unknown("parameter", name, known, f"--set {name}")
        fitted = fitted_parameters(models, self.parameters)
        for parameters in fitted.values():
            for parameter in parameters:
                if parameter.name in self.settings:
                    raise InputError(
                        f"{parameter.name} is fitted and set: leave --set {parameter.name} out"
                    )
        return fitted

    def scaled(
        self, name: str, scale: TickScale, speed: float, fitted: Sequence[FittedParameter]
    ) -> ScaledModel:
        """A model with what the tracks and the settings say of it. Raises InputError."""
        fields = find_model(name).parameters.model_fields
        own = {key: value for key, value in self.settings.items() if key in fields}
        return scaled_model(
            name, scale, speed, own, tuple(parameter.name for parameter in fitted),
            silent=self.method != "abc",
        )  # fmt: skip


def demand_dimensions(tracks: Tracks, models: Sequence[str]) -> None:
    """Raise InputError where a model is not defined in the dimensions of the tracks."""
    for name in models:
        dimensions = find_model(name).dimensions
        if tracks.dim not in dimensions:
            allowed = " and ".join(f"{dim}-D" for dim in dimensions)
            raise InputError(f"{tracks.name} is {tracks.dim}-D, but {name} is defined in {allowed}")
