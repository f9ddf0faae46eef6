"""A flight from trim, with a push at its start."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.flight.flight_motion import MOVING, THETA, Q, U, W, fly
from agents.flight.power import FlightHistory, history
from agents.flight.trim import Trim, trim
from app.flight.request import FlightRequest, check_range
from app.settings import assignment
from worlds.input_error import InputError, unknown
from worlds.number_text import counted

PER_BEAT = 96
"""Instants of a wing beat that are kept."""
PUSHES = {"u": (U, 5.0, "m/s"), "w": (W, 5.0, "m/s"), "q": (Q, 360.0, "deg/s"),
          "theta": (THETA, 60.0, "deg")}  # fmt: skip
"""What can be pushed: its place in the state, how far either way, and its unit."""


def parse_pushes(settings: list[str]) -> dict[int, float]:
    """Pushes by their place in the state, m/s, rad/s and rad, from `NAME=VALUE`. Raises
    InputError."""
    parsed = {}
    for text in settings:
        if "=" not in text:
            raise InputError(f"--push {text} is not of the form NAME=VALUE")
        name, value = assignment(text)
        if name not in PUSHES:
            raise unknown("push", name, PUSHES, "--push")
        place, most, unit = PUSHES[name]
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"--push {text}: {value!r} is not a number")
        check_range(f"--push {name} =", value, -most, most, unit)
        parsed[place] = math.radians(value) if unit.startswith("deg") else float(value)
    return parsed


@dataclass(frozen=True)
class ComparedFlight:
    """A flight and what it is compared with."""

    trim: Trim
    flown: FlightHistory
    level: FlightHistory
    """The same without a push, at the same instants."""
    left: np.ndarray
    """(BEATS + 1,) distance from the trim at the start of every beat, over that of the first one;
    nan without a push."""

    per_beat: int = PER_BEAT

    @property
    def beats(self) -> int:
        """Whole wing beats that were flown."""
        return (self.flown.time.size - 1) // self.per_beat

    def value(self) -> dict[str, Any]:
        """The flight as JSON has it; angles in degrees."""
        whole_beats = slice(0, self.beats * self.per_beat or None)
        track = self.flown
        return {
            "speed": self.trim.speed,
            "frequency": self.trim.frequency,
            "amplitude": math.degrees(self.trim.amplitude),
            "tail": math.degrees(self.trim.tail),
            "seconds": float(track.time[-1]),
            "beats": self.beats,
            "mean_speed": float(track.distance[-1] / track.time[-1]),
            "climbed": float(track.height[-1]),
            "mean_lift": float(track.lift[whole_beats].mean()),
            "weight": self.trim.aircraft.weight,
            "mean_power": float(track.power[whole_beats].mean()),
            "largest_multiplier": float(np.abs(self.trim.multipliers[0])),
            "left_of_push": [float(number) for number in self.left],
        }

    def lines(self) -> list[str]:
        """The flight for people."""
        value = self.value()
        lines = [
            f"{value['seconds']:g} s from trim at {value['speed']:g} m/s"
            f" (A = {value['amplitude']:.2f} deg, tail {value['tail']:.2f} deg),"
            f" {value['beats']} whole wing beats",
            f"  mean speed   {value['mean_speed']:.3f} m/s forward",
            f"  climbed      {value['climbed']:+.3f} m",
            f"  mean lift    {value['mean_lift']:.3f} N   (weight {value['weight']:.3f} N)",
            f"  mean power   {value['mean_power']:.3f} W",
        ]
        if np.isfinite(self.left[-1]):
            beats = counted(len(self.left) - 1, "beat")
            lines.append(
                f"  of the push  {self.left[-1]:.2g} is left after {beats};"
                f" largest |mu| = {value['largest_multiplier']:.3f}"
            )
        return lines


def fly_pushed(
    request: FlightRequest,
    speed: float,
    seconds: float,
    push: dict[int, float],
    at: Callable[[float], None],
) -> ComparedFlight:
    """Trim, push and fly for a time (s). Raises InputError."""

    def searching(share: float) -> None:
        at(0.3 * share)

    start_trim = trim(
        request.aircraft, speed, frequency=request.frequency, twist=request.twist, at=searching
    )
    start = start_trim.state.copy()
    for place, by in push.items():
        start[place] += by
    beat = 1.0 / request.frequency
    beats = int(seconds / beat + 1e-9)
    step = beat / PER_BEAT
    times = step * np.arange(int(seconds / step + 1e-9) + 1)
    track = fly(
        request.aircraft,
        start_trim.controls,
        start,
        float(times[-1]),
        times,
        lambda s: at(0.3 + 0.7 * s),
    )
    # The unpushed flight repeats its beat; only its place goes on.
    places = np.arange(times.size) % PER_BEAT
    level_track = fly(
        request.aircraft, start_trim.controls, start_trim.state, beat, step * np.arange(PER_BEAT)
    )
    level = history(level_track)
    repeated = {name: getattr(level, name)[places] for name in FlightHistory._fields}
    repeated["time"] = times
    distance = np.arange(times.size) // PER_BEAT * beat * speed
    repeated["distance"] = repeated["distance"] + distance
    apart = track.state[: beats * PER_BEAT + 1 : PER_BEAT][:, MOVING] - start_trim.state[MOVING]
    size = np.linalg.norm(apart[:, :4], axis=1)
    left = size / size[0] if push and size[0] > 0.0 else np.full(size.size, np.nan)
    return ComparedFlight(start_trim, history(track), FlightHistory(**repeated), left)
