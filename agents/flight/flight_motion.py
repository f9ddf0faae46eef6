"""Flight in time: the state, its rates, and their integration by SciPy.

The state is u, w (m/s), q (rad/s), theta (rad), x, z (m; z downward) and, for every strip of the
wing, the inflow slowed by its shed wake (m/s, see `agents.flight.section.felt`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from agents.flight.aircraft import Aircraft
from agents.flight.kane import forcing, inertia
from agents.flight.kinematics import Flapping
from agents.flight.strips import STRIPS, WingForces, wing_air
from agents.flight.tail import tail_air
from worlds.input_error import InputError

U, W, Q, THETA, X, Z = range(6)
"""Places in a state."""
SIZE = 6 + STRIPS
MOVING = [U, W, Q, THETA, *range(6, SIZE)]
"""What of a state must come back after a wing beat; the place need not."""
RELATIVE = 1e-9
"""Tolerance of the integration; the absolute one is a tenth of it."""
WILD = 100.0
"""A state larger than this is no flight: m/s, rad/s, rad."""


@dataclass(frozen=True)
class Controls:
    """What a pilot sets."""

    flapping: Flapping
    tail: float | np.ndarray
    """Tail angle, rad, nose up."""


def level(speed: float, pitch: float = 0.0) -> np.ndarray:
    """A state (SIZE,) that flies level at a speed (m/s) with a pitch (rad), nothing slowed yet."""
    state = np.zeros(SIZE)
    state[U], state[W], state[THETA] = speed * np.cos(pitch), speed * np.sin(pitch), pitch
    state[6:] = state[W]
    return state


def accelerations(
    craft: Aircraft, controls: Controls, time, state
) -> tuple[np.ndarray, WingForces]:
    """(u', w', q') (..., 3) of states (..., SIZE) at times (...,), and the air on the wings."""
    u, w, q, theta = (state[..., k] for k in (U, W, Q, THETA))
    flap, tip = controls.flapping.flap(time), controls.flapping.tip_twist(time)
    air = wing_air(craft, u, w, q, flap, tip, state[..., 6:])
    tail = tail_air(craft, u, w, q, controls.tail)
    force = np.stack((air.X + tail.X, air.Z + tail.Z, air.M + tail.M), axis=-1)
    force = force + forcing(craft, state[..., :3], theta, flap, tip)
    mass = inertia(craft, flap) + air.mass[..., :3, :]
    return np.linalg.solve(mass, force[..., None])[..., 0], air


def rates(craft: Aircraft, controls: Controls, time, state) -> np.ndarray:
    """d(state)/dt (..., SIZE) of states (..., SIZE) at times (...,) in s."""
    u, w, q, theta = (state[..., k] for k in (U, W, Q, THETA))
    gained, air = accelerations(craft, controls, time, state)
    cos, sin = np.cos(theta), np.sin(theta)
    place = np.stack((q, u * cos + w * sin, w * cos - u * sin), axis=-1)
    return np.concatenate((gained, place, air.slowing), axis=-1)


@dataclass(frozen=True)
class FlightTrack:
    """A flight in time."""

    craft: Aircraft
    controls: Controls
    time: np.ndarray
    """(K,), s."""
    state: np.ndarray
    """(K, SIZE)."""


def fly(
    craft: Aircraft,
    controls: Controls,
    start: np.ndarray,
    duration: float,
    times: np.ndarray | None = None,
    at: Callable[[float], None] | None = None,
) -> FlightTrack:
    """Fly from a state (SIZE,) at time 0 for a duration (s), by SciPy's DOP853.

    `times` (K,) are those to keep, by default the first and the last; `at` gets the share done.
    Raises InputError where the motion cannot be followed.
    """
    kept = np.array([0.0, duration]) if times is None else np.asarray(times, float)
    made = integrate(craft, controls, np.asarray(start, float)[None], duration, kept, at)
    return FlightTrack(craft, controls, kept, made[:, 0])


def integrate(
    craft: Aircraft,
    controls: Controls,
    starts: np.ndarray,
    duration: float,
    times: np.ndarray,
    at: Callable[[float], None] | None = None,
    relative: float = RELATIVE,
) -> np.ndarray:
    """States (K, B, SIZE) at times (K,) of B flights that start in (B, SIZE) and share their steps.

    Sharing the steps makes the difference of two neighbouring flights smooth, as derivatives by
    differences need it. Raises InputError.
    """
    shape = starts.shape

    def slope(time: float, flat: np.ndarray) -> np.ndarray:
        if at is not None:
            at(time / duration)
        state = flat.reshape(shape)
        if not (np.abs(state[..., :4]) < WILD).all():
            raise InputError(f"the aircraft tumbles at {time:.3g} s: its motion cannot be followed")
        return rates(craft, controls, time, state).ravel()

    with np.errstate(over="ignore"):  # far beyond the stall exp() is inf, and its inverse 0
        made = solve_ivp(
            slope,
            (0.0, duration),
            starts.ravel(),
            method="DOP853",
            t_eval=times,
            rtol=relative,
            atol=0.1 * relative,
        )
    if not made.success:
        raise InputError(f"the flight cannot be followed beyond {made.t[-1]:.3g} s: {made.message}")
    return made.y.T.reshape(len(times), *shape)
