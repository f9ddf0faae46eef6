"""Air forces on the two flapping wings: strips across the span, added up by partial velocities.

Body axes of the thesis: x_b forward, z_b down; u, w and q are the speeds of the body's centre of
mass and the pitch rate, nose up. A strip at y metres from the body turns with the flap phi about
x_b and with its twist eta about an axis `reach` ahead of the centre of mass. With

    U_x = u - q y sin phi            forward velocity of the axis
    W_n = phi' y - (w - q reach) cos phi       its velocity along the normal of the wing, upward
    V_x = U_x cos eta + W_n sin eta, V_n = W_n cos eta - U_x sin eta    along and across the chord
    theta' = eta' + q cos phi                                            nose up

every force's share in X, Z, M and in the torques of flap and twist is the force times what its
place moves per unit of u, w, q, phi' and eta' (Kane's partial velocities). So the power of the
forces is the sum of these shares times the speeds, exactly.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agents.flight.aircraft import Aircraft
from agents.flight.kinematics import Swing
from agents.flight.section import (
    Flow,
    apparent_inertia,
    apparent_mass,
    felt,
    loads,
    slowing,
    turning_moment,
)

STRIPS = 12
"""Strips per wing; with 24 the power changes by less than 0.1 %."""
SHARE = (np.arange(STRIPS) + 0.5) / STRIPS
"""Places of the strips in half spans, and how much of the tip's twist each has."""


class WingForces(NamedTuple):
    """Forces of the air on the wings; arrays (...,) if nothing else is said.

    They are those without the accelerations u', w', q'; what these add is -`mass` @ (u', w', q').
    """

    X: np.ndarray
    """Along x_b, N."""
    Z: np.ndarray
    """Along z_b, downward, N."""
    M: np.ndarray
    """About y_b, nose up, N m."""
    flap: np.ndarray
    """Torque along the flap of both wings, N m: positive where the air lifts them."""
    twist: np.ndarray
    """Torque along the twist of both wings, N m per radian at the tip."""
    mass: np.ndarray
    """(..., 5, 3): apparent mass, what u', w', q' take away from the five above."""
    slowing: np.ndarray
    """(..., STRIPS): d(slowed)/dt, m/s^2."""
    separated: np.ndarray
    """(..., STRIPS): share of the flow that has left."""


class PartialVelocities(NamedTuple):
    """What the twist axis of a strip does per unit of (u, w, q, phi', eta'), (..., STRIPS, 5)."""

    across: np.ndarray
    """It moves across the chord, upward."""
    along: np.ndarray
    """It moves along the chord, forward."""
    turning: np.ndarray
    """The strip turns, nose up."""


def partial_velocities(craft: Aircraft, flap, twist) -> PartialVelocities:
    """Partial velocities at flap angles (..., 1) and twists (..., STRIPS), rad."""
    y = SHARE * craft.half_span
    reach = craft.centre_of_mass - craft.twist_axis
    cos, sin, c, s = np.cos(flap), np.sin(flap), np.cos(twist), np.sin(twist)
    shape = np.broadcast_shapes(np.shape(flap), np.shape(twist))
    made = PartialVelocities(*np.zeros((3, *shape, 5)))
    made.across[..., 0] = -s
    made.across[..., 1] = -cos * c
    made.across[..., 2] = reach * cos * c + y * sin * s
    made.across[..., 3] = y * c
    made.along[..., 0] = c
    made.along[..., 1] = -cos * s
    made.along[..., 2] = reach * cos * s - y * sin * c
    made.along[..., 3] = y * s
    made.turning[..., 2] = cos
    made.turning[..., 4] = SHARE
    return made


def wing_air(craft: Aircraft, u, w, q, flap: Swing, tip: Swing, slowed) -> WingForces:
    """Forces of the air on both wings.

    Parameters
    ----------
    u, w, q: (...,), m/s and rad/s. flap, tip: the flap and the twist of the wing tip, (...,).
    slowed: (..., STRIPS), the slowed inflow of every strip, m/s (see `section.felt`).
    """
    u, w, q = (np.asarray(one, float)[..., None] for one in (u, w, q))
    phi, dphi, ddphi = (np.asarray(one)[..., None] for one in flap)
    eta, deta, ddeta = (np.asarray(one)[..., None] * SHARE for one in tip)
    chord, ratio = craft.chord, craft.aspect_ratio
    y = SHARE * craft.half_span
    reach = craft.centre_of_mass - craft.twist_axis
    cos, sin, c, s = np.cos(phi), np.sin(phi), np.cos(eta), np.sin(eta)

    ahead = u - q * y * sin
    up = dphi * y - (w - q * reach) * cos
    along = ahead * c + up * s
    across = up * c - ahead * s
    rate = deta + q * cos
    speed = np.sqrt(u**2 + w**2)
    inflow = -across + rate * (0.75 * chord - craft.twist_axis)
    middle = -across + rate * (0.50 * chord - craft.twist_axis)
    flow = Flow(along, felt(inflow, slowed, ratio), middle, rate, speed)
    made = loads(flow, chord, craft)

    # Apparent mass: d(middle)/dt in two parts, the one of u', w', q' by partial velocities.
    d_ahead = -q * y * dphi * cos
    d_up = ddphi * y + (w - q * reach) * dphi * sin
    d_rate = ddeta - q * dphi * sin
    d_middle = deta * along - d_up * c + d_ahead * s + d_rate * (0.5 * chord - craft.twist_axis)
    moved = apparent_mass(chord) * (1.0 - 0.5 * made.separated)
    turned = apparent_inertia(chord)

    place = partial_velocities(craft, phi, eta)
    quarter, half = (share * chord - craft.twist_axis for share in (0.25, 0.50))
    lifted = moved * d_middle
    couple = turning_moment(rate, speed, chord) - turned * d_rate
    couple = couple - quarter * made.normal - half * lifted
    width = 2.0 * craft.half_span / STRIPS
    shares = width * (
        np.einsum("...s,...sk->...k", made.normal + lifted, place.across)
        + np.einsum("...s,...sk->...k", made.chordwise, place.along)
        + np.einsum("...s,...sk->...k", couple, place.turning)
    )
    centre = place.across - half * place.turning
    turn = place.turning
    mass = width * (
        np.swapaxes(centre * moved[..., None], -1, -2) @ centre[..., :3]
        + turned * (np.swapaxes(turn, -1, -2) @ turn[..., :3])
    )
    X, Z, M, flapping, twisting = np.moveaxis(shares, -1, 0)
    slower = slowing(inflow, slowed, speed, chord, ratio)
    return WingForces(X, Z, M, flapping, twisting, mass, slower, made.separated)
