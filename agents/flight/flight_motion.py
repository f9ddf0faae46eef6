"""Flight in time: the state, its rates, and their integration by SciPy.

The state is u, w (m/s), q (rad/s), theta (rad), x, z (m; z downward) and, for every strip of the
wing, the inflow slowed by its shed wake (m/s, see `agents.flight.air_forces.effective_inflow`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from agents.flight.air_forces import STRIPS, Flapping, Swing, WingForces, tail_air, wing_air
from agents.flight.aircraft import GRAVITY, Aircraft
from worlds.input_error import InputError

# Kane's equations of the aircraft in its plane of symmetry, (2.3) to (2.5) of the thesis.
#
# Body axes: x_b forward, z_b down, origin in the centre of mass of body and tail; u, w, q velocity
# and pitch rate (nose up), theta pitch. Wings of mass m_2 have their centre of mass l_2 out along
# the wing, so at (0, +-l_2 cos phi, -l_2 sin phi). X, Z, M are the forces of the air: X = -D cos a
# + L sin a, Z = -D sin a - L cos a.
#
#     m (u' + q w) - 2 m_2 l_2 (q' sin phi + 2 q phi' cos phi) = X - m g sin theta             (2.3)
#     m (w' - q u) + 2 m_2 l_2 (-phi'' cos phi + (q^2 + phi'^2) sin phi) = Z + m g cos theta   (2.4)
#     (I_1y + 2 I_2y) q' + 2 I_2y <eta''>
#         - 2 m_2 l_2 sin phi (u' + q w - q' l_2 sin phi - 2 q l_2 phi' cos phi + g sin theta) = M
#                                                                                              (2.5)
#
# Corrected: (2.4) is printed with phi^2 for phi'^2, with sin phi and cos phi for those of the angle
# of attack; (2.5) with a plus before 2 m_2 l_2, with which a couple's work is not the kinetic
# energy gained (`PRINTED` keeps it for the test that shows this). eta is nose up here, hence the
# plus before its term, and <eta''> is the mean over the wing, since the twist grows with the span.

CORRECTED, PRINTED = -1.0, 1.0
"""Sign before 2 m_2 l_2 in (2.5)."""
MEAN_SHARE, MEAN_SQUARE = 0.5, 1.0 / 3.0
"""Means over the wing of the twist and of its square, for a tip that twists by 1."""


def inertia(craft: Aircraft, flap: Swing, sign: float = CORRECTED) -> np.ndarray:
    """What multiplies (u', w', q') on the left of (2.3) to (2.5), (..., 3, 3), kg, kg m, kg m^2."""
    sin = np.sin(flap.angle)
    arm = 2.0 * craft.wing_mass * craft.wing_centre * sin
    matrix = np.zeros((*np.shape(sin), 3, 3))
    matrix[..., 0, 0] = matrix[..., 1, 1] = craft.mass
    matrix[..., 0, 2] = -arm
    matrix[..., 2, 0] = sign * arm
    matrix[..., 2, 2] = (
        craft.body_inertia + 2.0 * craft.wing_inertia - sign * arm * craft.wing_centre * sin
    )
    return matrix


def forcing(
    craft: Aircraft,
    speeds,
    pitch,
    flap: Swing,
    tip: Swing,
    gravity: float = GRAVITY,
    sign: float = CORRECTED,
) -> np.ndarray:
    """What stands beside (X, Z, M) on the right, without u', w', q', (..., 3), N, N, N m.

    `speeds` is (..., 3): u, w, q; `pitch` theta (...,), rad.
    """
    u, w, q = np.moveaxis(np.asarray(speeds, float), -1, 0)
    sin, cos = np.sin(flap.angle), np.cos(flap.angle)
    moment = 2.0 * craft.wing_mass * craft.wing_centre
    weight = craft.mass * gravity
    swept = 2.0 * q * craft.wing_centre * flap.rate * cos
    return np.stack(
        (
            -weight * np.sin(pitch) - craft.mass * q * w + 2.0 * craft.wing_mass * swept,
            weight * np.cos(pitch)
            + craft.mass * q * u
            + moment * (flap.acceleration * cos - (q**2 + flap.rate**2) * sin),
            -2.0 * craft.wing_inertia * MEAN_SHARE * tip.acceleration
            - sign * moment * sin * (q * w - swept + gravity * np.sin(pitch)),
        ),
        axis=-1,
    )


def hinge_torques(
    craft: Aircraft, speeds, accelerations, pitch, flap: Swing, tip: Swing
) -> tuple[np.ndarray, np.ndarray]:
    """Torques that move the masses of both wings, N m: along the flap, and along the tip's twist.

    Kane's equations for phi and eta: what the shafts must do beside holding the air's torques.
    """
    u, _, q = np.moveaxis(np.asarray(speeds, float), -1, 0)
    dw, dq = np.asarray(accelerations)[..., 1], np.asarray(accelerations)[..., 2]
    sin, cos, arm = np.sin(flap.angle), np.cos(flap.angle), craft.wing_centre
    sideways = arm * (flap.acceleration * sin + flap.rate**2 * cos)
    downward = dw - q * u - arm * flap.acceleration * cos + arm * (q**2 + flap.rate**2) * sin
    along = arm * (sin * sideways - cos * (downward - GRAVITY * np.cos(pitch)))
    return (
        2.0 * (craft.wing_mass * along + craft.flap_inertia * flap.acceleration),
        2.0 * craft.wing_inertia * (MEAN_SHARE * dq + MEAN_SQUARE * tip.acceleration),
    )


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
    acceleration, air = accelerations(craft, controls, time, state)
    cos, sin = np.cos(theta), np.sin(theta)
    place = np.stack((q, u * cos + w * sin, w * cos - u * sin), axis=-1)
    return np.concatenate((acceleration, place, air.slowing), axis=-1)


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
    sample_times = np.array([0.0, duration]) if times is None else np.asarray(times, float)
    track = integrate(craft, controls, np.asarray(start, float)[None], duration, sample_times, at)
    return FlightTrack(craft, controls, sample_times, track[:, 0])


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
        solution = solve_ivp(
            slope,
            (0.0, duration),
            starts.ravel(),
            method="DOP853",
            t_eval=times,
            rtol=relative,
            atol=0.1 * relative,
        )
    if not solution.success:
        raise InputError(
            f"the flight cannot be followed beyond {solution.t[-1]:.3g} s: {solution.message}"
        )
    return solution.y.T.reshape(len(times), *shape)
