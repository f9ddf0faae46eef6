"""How the seconds and metres of tracks become the ticks and lengths of a model: said, not guessed.

One tick of the model is every `every`-th frame of the tracks. One length of the model is `length`
units of the tracks. What a model calls its time of a tick, or the one speed of its body, is set
from these.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from agents.catalogue import model as find_model
from agents.models.declare import NumberParameter, Parameters, checked, declared
from agents.models.model import Model
from app.tracks.tracks import PIXELS, Tracks
from worlds.input_error import InputError

ROUNDED = 1e-9
"""By which share two numbers may differ that are the same."""


@dataclass(frozen=True)
class TickScale:
    """The scale between tracks and models."""

    every: int
    """Frames that a tick takes."""
    ticks: int
    """Ticks that a frame takes; 1 but for frames too far apart, for which `every` is 1."""
    seconds: float
    """Of a tick."""
    length: float
    """Units of the tracks that one length of the model stands for."""
    unit: str
    """Of the tracks."""

    def describe(self) -> str:
        """The scale in words."""
        if self.ticks > 1:
            tick = f"{self.ticks} ticks are 1 frame"
        else:
            tick = f"1 tick is {self.every} frame" + ("s" if self.every > 1 else "")
        return f"{tick} (a tick is {self.seconds:.4g} s); 1 length is {self.length:g} {self.unit}"


def tick_scale(
    tracks: Tracks, every: int = 1, length: float | None = None, ticks: int = 1
) -> TickScale:
    """The scale of tracks; without a `length`, one length is one metre. Raises InputError.

    Tracks in pixels have none of their own: they need a `length`, in pixels.
    """
    if length is None and tracks.unit == PIXELS:
        raise InputError(
            f"{tracks.name} is in pixels: give --scale, metres in a pixel, or --length, pixels in "
            "one length of the model"
        )
    if length is not None and not 0.0 < length < math.inf:
        raise InputError(
            f"length = {length:g} {tracks.unit} is not allowed: a number > 0 is needed"
        )
    for name, count in (("frames of a tick", every), ("ticks of a frame", ticks)):
        if count < 1:
            raise InputError(f"{name} = {count} is not allowed: a whole number >= 1 is needed")
    if every > 1 and ticks > 1:
        raise InputError(
            f"{every} frames of a tick and {ticks} ticks of a frame exclude each other"
        )
    seconds = tracks.step * every / ticks
    return TickScale(every, ticks, seconds, 1.0 if length is None else length, tracks.unit)


@dataclass(frozen=True)
class ScaledModel:
    """A model with what tracks and user say of its parameters, but for those in question."""

    name: str
    fixed: dict[str, Any]
    """Parameters that differ from the model's own: by user, scale or data; noise is off."""
    notes: tuple[str, ...]
    """What was set and why, a line each."""
    time_unit: float = 1.0
    """Seconds of the unit in which the model counts time: a second, or a tick."""

    @property
    def model(self) -> Model:
        """The model itself."""
        return find_model(self.name)


def parameter_behind(
    parameters: type[Parameters], value: Callable[[Any], float]
) -> NumberParameter | None:
    """The parameter that a value is no more than a name for, None if it is none alone."""
    default = parameters()
    for declaration in declared(parameters):
        if isinstance(declaration, NumberParameter):
            probes = [(1.0 - k) * declaration.low + k * declaration.high for k in (0.25, 0.5)]
            copies = [default.model_copy(update={declaration.name: probe}) for probe in probes]
            if all(
                math.isclose(value(copy), probe, rel_tol=ROUNDED)
                for copy, probe in zip(copies, probes, strict=True)
            ):
                return declaration
    return None


def scaled_model(
    name: str,
    scale: TickScale,
    speed: float,
    settings: Mapping[str, Any],
    fitted: tuple[str, ...] = (),
    silent: bool = True,
) -> ScaledModel:
    """A model with its time of a tick and its speed from the tracks, and its noise off.

    Parameters
    ----------
    speed: median of the tracks, their unit/s. settings: parameters that the user sets; they win
    over the speed. fitted: names of the parameters in question, which nothing here sets.
    silent: whether noise is off.

    Raises InputError where the tick or the speed is outside of what the model allows.
    """
    model = find_model(name)
    fixed: dict[str, Any] = {}
    notes: list[str] = []
    body, default = model.body, model.parameters()
    if body.unit == "s":
        time = parameter_behind(model.parameters, body.lasts)
        if time is not None:
            if time.name in fitted or time.name in settings:
                raise InputError(
                    f"{time.name} of {name} is the time of a tick, which is that of the tracks, "
                    f"{scale.seconds:.4g} s: say with --tick-frames how many frames a tick is"
                )
            demand_within(time, scale.seconds, name, "a tick, see --tick-frames")
            fixed[time.name] = scale.seconds
            notes.append(f"{time.name} = {scale.seconds:.4g} s, the time of a tick")
        elif not math.isclose(body.lasts(default), scale.seconds, rel_tol=0.01):
            raise InputError(
                f"a tick of {name} is {body.lasts(default):g} s, that of the tracks "
                f"{scale.seconds:.4g} s: say with --tick-frames how many frames a tick is"
            )
    if body.speed is not None:
        pace = parameter_behind(model.parameters, body.speed)
        if pace is not None and pace.name not in fitted and pace.name not in settings:
            seconds = scale.seconds if body.unit == "ticks" else 1.0
            own = speed / scale.length * seconds
            demand_within(pace, own, name, "the speed of the tracks, see --length")
            fixed[pace.name] = own
            notes.append(f"{pace.name} = {own:.4g} {pace.unit}, the median speed of the tracks")
    for declaration in declared(model.parameters):
        if not (silent and declaration.noise) or declaration.name in fitted:
            continue
        if settings.get(declaration.name, 0):
            raise InputError(
                f"{declaration.name} = {settings[declaration.name]} is not allowed: it is noise, "
                "and a prediction has none"
            )
        if declaration.default:
            fixed[declaration.name] = 0.0
            notes.append(f"{declaration.name} = 0: a prediction has no noise")
    checked(model.parameters, dict(settings), "--set")
    fixed |= settings
    return ScaledModel(name, fixed, tuple(notes), 1.0 if body.unit == "s" else scale.seconds)


def demand_within(declaration: NumberParameter, value: float, model: str, what: str) -> None:
    """Raise InputError where a value that follows from the tracks is not allowed."""
    if not declaration.low <= value <= declaration.high:
        raise InputError(
            f"{declaration.name} = {value:.4g} is outside {declaration.allowed} of {model}: it is "
            f"{what}"
        )
