"""Model disturbances: old, lost and inexact messages, and wind. Part of every run's options.

Time delay and disturbance are what Wu et al. 2023 (section 6) leave to be looked at. They belong to
the engine, so that every model can be run under them.
"""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict

from agents.engine.message_past import MessageDelays
from agents.engine.noise import GUSTS, NO_WIND, uniform_numbers
from agents.option import between, option
from worlds.input_error import InputError

MOST_SECONDS = 1e6
MOST_SPEED = 1e6
MOST_LENGTH = 1e6
UNHEARD = 1e-6
"""Share of the messages that are older than the past reaches back, at most: they are not heard."""
MOST_TICKS = 10_000
"""How far the past reaches back at most."""


class Conditions(BaseModel):
    """How old and how exact what agents know of each other is, and what wind carries them along.

    Times are in the model's unit of time, of which a tick is `dt`; they are rounded to ticks.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    delay: Annotated[float, between(0.0, MOST_SECONDS)] = option(
        "Delay",
        "What an agent knows of the others is at least so old (time); of itself it knows the "
        "present",
        0.0,
        kind=float,
        unit="time",
        most=10.0,
        step=0.1,
    )
    jitter: Annotated[float, between(0.0, MOST_SECONDS)] = option(
        "Jitter",
        "Mean of what each message takes beyond the delay (time): exponentially distributed, drawn "
        "for each message of each pair of agents",
        0.0,
        kind=float,
        unit="time",
        most=10.0,
        step=0.1,
    )
    lost: Annotated[float, between(0.0, 0.99)] = option(
        "Lost",
        "Share of the messages that get lost; the last one that came stands",
        0.0,
        kind=float,
        most=0.99,
        step=0.05,
    )
    place_error: Annotated[float, between(0.0, MOST_LENGTH)] = option(
        "Place error",
        "Standard deviation, along each axis, of where an agent takes each of the others to be "
        "(length): normal, drawn for each tick and each pair of agents",
        0.0,
        kind=float,
        unit="length",
        most=10.0,
        step=0.05,
    )
    wind: Annotated[float, between(0.0, MOST_SPEED)] = option(
        "Wind",
        "Constant wind: every agent is carried along at this speed (length per time)",
        0.0,
        kind=float,
        unit="length/time",
        most=100.0,
        step=0.1,
    )
    wind_heading: Annotated[float, between(-360.0, 360.0, "degrees")] = option(
        "Wind to (deg)",
        "Where wind and pulse blow to, degrees anticlockwise from the x axis",
        0.0,
        kind=float,
        most=360.0,
        step=15.0,
    )
    wind_up: Annotated[float, between(-MOST_SPEED, MOST_SPEED)] = option(
        "Wind upwards",
        "Upward speed of the constant wind, in space only (length per time)",
        0.0,
        kind=float,
        unit="length/time",
        least=-100.0,
        most=100.0,
        step=0.1,
    )
    gusts: Annotated[float, between(0.0, MOST_SPEED)] = option(
        "Gusts",
        "Standard deviation of the gusts along each axis (length per time): an Ornstein-Uhlenbeck "
        "process, the same for all agents",
        0.0,
        kind=float,
        unit="length/time",
        most=100.0,
        step=0.1,
    )
    gust_time: Annotated[float, between(1e-6, MOST_SECONDS)] = option(
        "Gusts last",
        "Correlation time of the gusts (time)",
        1.0,
        kind=float,
        unit="time",
        least=0.01,
        most=100.0,
        step=0.1,
    )
    pulse: Annotated[float, between(0.0, MOST_SPEED)] = option(
        "Pulse",
        "A pulse of wind, beside the constant one: its speed (length per time)",
        0.0,
        kind=float,
        unit="length/time",
        most=100.0,
        step=0.1,
    )
    pulse_at: Annotated[float, between(0.0, MOST_SECONDS)] = option(
        "Pulse at", "When the pulse begins (time)", 0.0, kind=float, unit="time", most=1000.0
    )
    pulse_lasts: Annotated[float, between(0.0, MOST_SECONDS)] = option(
        "Pulse lasts",
        "How long the pulse lasts (time)",
        1.0,
        kind=float,
        unit="time",
        most=100.0,
        step=0.1,
    )

    @property
    def is_late(self) -> bool:
        """Whether what agents know of others may be old, or inexact."""
        return any((self.delay, self.jitter, self.lost, self.place_error))

    @property
    def is_windy(self) -> bool:
        """Whether something carries agents along."""
        return any((self.wind, self.wind_up, self.gusts, self.pulse))


def messages(conditions: Conditions, dt: float) -> MessageDelays:
    """Delay and loss of messages in ticks of `dt`, and how exact they are."""
    late = round(conditions.delay / dt), conditions.jitter / dt, conditions.lost
    return MessageDelays(*late, conditions.place_error)


def ticks_back(conditions: Conditions, dt: float) -> int:
    """Ticks of the past that are kept, the present among them; 0 where nothing is late.

    Raises InputError if they are too many.
    """
    if not conditions.is_late:
        return 0
    delay, jitter, loss, _ = messages(conditions, dt)
    lost_in_a_row = math.ceil(math.log(UNHEARD) / math.log(loss)) if loss > 0.0 else 0
    ages = delay + math.ceil(-math.log(UNHEARD) * jitter) + lost_in_a_row + 1
    if ages > MOST_TICKS:
        raise InputError(
            f"delay = {conditions.delay:g}, jitter = {conditions.jitter:g}, "
            f"lost = {conditions.lost:g}: messages would be up to {ages} ticks of {dt:g} old; "
            f"the most is {MOST_TICKS}"
        )
    return ages


def gust_noise(seed: int, first: int, end: int) -> np.ndarray:
    """Normal numbers of deviation 1 along each axis for the ticks [first, end), (ticks, 3)."""
    chance = uniform_numbers(seed, GUSTS, np.arange(first, end), 6)
    return np.sqrt(-2.0 * np.log(1.0 - chance[:, 0::2])) * np.cos(2.0 * np.pi * chance[:, 1::2])


class Wind:
    """The wind of a run, the same for all agents, as displacements for each tick.

    Constant wind, a pulse, and gusts: along each axis an Ornstein-Uhlenbeck process of standard
    deviation `gusts` and correlation time `gust_time`, stationary from tick 0 on and exact for any
    tick (Gillespie 1996, (1.9)). It depends on the seed and the tick alone.
    """

    def __init__(self, conditions: Conditions, seed: int, dt: float, dim: int):
        self.conditions = conditions
        self.seed = seed
        self.dt = dt
        self.dim = dim
        angle = math.radians(conditions.wind_heading)
        self.along = np.array([math.cos(angle), math.sin(angle), 0.0])
        self.persistence = math.exp(-dt / conditions.gust_time)
        self._reset_gusts()

    def _reset_gusts(self) -> None:
        """The gusts as they are before tick 0."""
        self.next_tick = 0
        self.last = gust_noise(self.seed, 0, 1)[0] if self.conditions.gusts else np.zeros(3)

    def displacements(self, tick: int, ticks: int) -> np.ndarray:
        """Displacement of agents in each of `ticks` ticks from `tick` on, length, (ticks, 3)."""
        conditions = self.conditions
        if not conditions.is_windy:
            return NO_WIND
        speed = np.tile(conditions.wind * self.along, (ticks, 1))
        speed[:, 2] += conditions.wind_up
        if conditions.pulse:
            time = np.arange(tick, tick + ticks) * self.dt
            blows = (time >= conditions.pulse_at) & (
                time < conditions.pulse_at + conditions.pulse_lasts
            )
            speed[blows] += conditions.pulse * self.along
        if conditions.gusts:
            speed += conditions.gusts * self.gusts(tick, ticks)
        speed[:, self.dim :] = 0.0
        return speed * self.dt

    def gusts(self, tick: int, ticks: int) -> np.ndarray:
        """Gusts of standard deviation 1 in each of the ticks, (ticks, 3)."""
        from scipy.signal import lfilter

        if tick < self.next_tick:
            self._reset_gusts()
        noise = gust_noise(self.seed, self.next_tick + 1, tick + ticks + 1)
        spread = math.sqrt(1.0 - self.persistence**2)
        process, _ = lfilter(
            [spread], [1.0, -self.persistence], noise, axis=0, zi=self.persistence * self.last[None]
        )
        if len(process):
            self.last = process[-1]
        self.next_tick = tick + ticks
        return process[len(process) - ticks :]
