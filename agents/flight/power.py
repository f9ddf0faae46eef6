"""Forces and power along a flight."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agents.flight.air_forces import tail_air
from agents.flight.aircraft import Aircraft
from agents.flight.flight_motion import (
    THETA,
    Controls,
    FlightTrack,
    Q,
    U,
    W,
    X,
    Z,
    accelerations,
    hinge_torques,
)


class FlightForces(NamedTuple):
    """What is felt at instants; arrays of the shape of the times."""

    lift: np.ndarray
    """Force of the air against gravity, N."""
    thrust: np.ndarray
    """Force of the air along the ground, forward, N: thrust less drag."""
    pitching: np.ndarray
    """Moment of the air about the body's centre of mass, nose up, N m."""
    power: np.ndarray
    """Power of the shafts, W: what flap and twist take from the drive; < 0 gives back."""
    taken: np.ndarray
    """Power that the air takes from the aircraft, W."""
    separated: np.ndarray
    """Mean share of the wing from which the flow has left, [0, 1]."""


def readings(craft: Aircraft, controls: Controls, time, state) -> FlightForces:
    """What is felt in states (..., SIZE) at times (...,) in s."""
    u, w, q, theta = (state[..., k] for k in (U, W, Q, THETA))
    flap, tip = controls.flapping.flap(time), controls.flapping.tip_twist(time)
    acceleration, air = accelerations(craft, controls, time, state)
    tail = tail_air(craft, u, w, q, controls.tail)
    air_forces = np.stack((air.X, air.Z, air.M, air.flap, air.twist), axis=-1)
    air_forces = air_forces - np.einsum("...kl,...l->...k", air.mass, acceleration)
    along, down = air_forces[..., 0] + tail.X, air_forces[..., 1] + tail.Z
    pitching = air_forces[..., 2] + tail.M
    moving = hinge_torques(craft, state[..., :3], acceleration, theta, flap, tip)
    power = (moving[0] - air_forces[..., 3]) * flap.rate + (
        moving[1] - air_forces[..., 4]
    ) * tip.rate
    air_power = along * u + down * w + pitching * q
    air_power = air_power + air_forces[..., 3] * flap.rate + air_forces[..., 4] * tip.rate
    return FlightForces(
        along * np.sin(theta) - down * np.cos(theta),
        along * np.cos(theta) + down * np.sin(theta),
        pitching,
        power,
        -air_power,
        air.separated.mean(axis=-1),
    )


class FlightHistory(NamedTuple):
    """A flight as people read it; arrays (K,)."""

    time: np.ndarray
    """s."""
    distance: np.ndarray
    """m."""
    height: np.ndarray
    """m above the start."""
    speed: np.ndarray
    """m/s."""
    climb: np.ndarray
    """m/s."""
    pitch: np.ndarray
    """rad."""
    pitch_rate: np.ndarray
    """rad/s."""
    attack: np.ndarray
    """Angle of attack of the body, rad."""
    flap: np.ndarray
    """rad, wings up."""
    twist: np.ndarray
    """Of the tip, rad, nose up."""
    lift: np.ndarray
    """Against gravity, N."""
    thrust: np.ndarray
    """Along the ground, less drag, N."""
    power: np.ndarray
    """Of the shafts, W."""
    separated: np.ndarray
    """[0, 1]."""


def history(track: FlightTrack) -> FlightHistory:
    """What is read off a flight."""
    s, controls = track.state, track.controls
    felt = readings(track.craft, controls, track.time, s)
    u, w, theta = s[:, U], s[:, W], s[:, THETA]
    return FlightHistory(
        time=track.time,
        distance=s[:, X],
        height=-s[:, Z],
        speed=np.hypot(u, w),
        climb=u * np.sin(theta) - w * np.cos(theta),
        pitch=theta,
        pitch_rate=s[:, Q],
        attack=np.arctan2(w, u),
        flap=controls.flapping.flap(track.time).angle,
        twist=controls.flapping.tip_twist(track.time).angle,
        lift=felt.lift,
        thrust=felt.thrust,
        power=felt.power,
        separated=felt.separated,
    )
