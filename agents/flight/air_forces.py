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

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from agents.flight.aircraft import AIR, Aircraft

# How the wings are driven: flap (2.1) and twist (2.2), with their derivatives.

LEAD = math.pi / 2.0
"""Phase by which the twist leads the flap, rad: nose down while the wing goes down."""


class Swing(NamedTuple):
    """An angle that swings, rad, rad/s, rad/s^2; three arrays of one shape."""

    angle: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray


def swing(amplitude, frequency: float, phase: float, time) -> Swing:
    """a sin(2 pi f t + phase) and its two derivatives, in closed form.

    `amplitude` (rad) and `time` (s) are numbers or arrays whose shapes fit each other.

    >>> [round(float(one), 3) for one in swing(0.1, 0.5, 0.0, 0.5)]
    [0.1, 0.0, -0.987]
    """
    omega = 2.0 * math.pi * frequency
    at = omega * np.asarray(time, float) + phase
    angle = amplitude * np.sin(at)
    return Swing(angle, amplitude * omega * np.cos(at), -(omega**2) * angle)


@dataclass(frozen=True)
class Flapping:
    """What drives the wings.

    The flap angle phi lifts the wing tip; the twist eta is nose up and grows in proportion with
    the distance from the body (a free choice: the thesis twists the wing as a whole).
    """

    amplitude: float | np.ndarray
    """A (2.1), rad; an array flies several copies at once."""
    twist: float = math.radians(20.0)
    """R (2.2), rad, of the wing tip."""
    frequency: float = 1.5
    """f_1 (2.1), Hz."""
    twist_frequency: float | None = None
    """f_2 (2.2), Hz; None: f_1."""
    phase: float = 0.0
    """theta_1 (2.1), rad."""
    twist_phase: float = LEAD
    """theta_2 (2.2), rad."""

    @property
    def period(self) -> float:
        """One wing beat, s."""
        return 1.0 / self.frequency

    def flap(self, time) -> Swing:
        """phi (2.1) at times in s."""
        return swing(self.amplitude, self.frequency, self.phase, time)

    def tip_twist(self, time) -> Swing:
        """eta (2.2) of the wing tip at times in s."""
        return swing(self.twist, self.twist_frequency or self.frequency, self.twist_phase, time)


# Air forces on a section of a flapping wing, after DeLaurier (1993), per metre of span.
#
# What DeLaurier writes as flight speed times an angle is here a velocity, so that the section may
# belong to a body that flies freely:
#
#     inflow   velocity of the air across the chord, from below, at three quarters of the chord:
#              U alpha of DeLaurier, mean pitch included
#     felt     what of it makes circulation: finite span and shed wake slow it down
#              (see `effective_inflow`)
#     middle   the same velocity at half of the chord, U alpha - 3/4 c theta' + 1/2 c theta'
#     forward  V_x, velocity of the section along its chord
#     rate     theta', nose up
#
# Sections are uncambered: alpha_0 = 0 and C_mac = 0.


class Flow(NamedTuple):
    """The air about sections; arrays that fit each other, m/s and rad/s."""

    forward: np.ndarray
    felt: np.ndarray
    middle: np.ndarray
    rate: np.ndarray | float
    speed: np.ndarray
    """U, flight speed."""


class Loads(NamedTuple):
    """Forces on sections."""

    normal: np.ndarray
    """At a quarter of the chord, upward across it, N/m."""
    chordwise: np.ndarray
    """Along the chord, forward, N/m."""
    separated: np.ndarray
    """Share of the flow that has left the section, [0, 1]."""


def finite_span(aspect_ratio: float) -> float:
    """AR / (AR + 2): what a wing's lift slope is of 2 pi."""
    return aspect_ratio / (aspect_ratio + 2.0)


def wake_terms(aspect_ratio: float) -> tuple[float, float]:
    """C_1 and C_2 of DeLaurier's F' and G', which describe the shed wake."""
    return 0.5 * aspect_ratio / (2.32 + aspect_ratio), 0.181 + 0.772 / aspect_ratio


def effective_inflow(inflow, downwash, aspect_ratio: float):
    """The inflow that makes circulation, m/s; shapes fit each other.

    DeLaurier multiplies an inflow of reduced frequency k by AR / (AR + 2) (F'(k) + i G'(k)) with
    F' + i G' = 1 - C_1 i k / (i k + C_2). That is the answer of a lag, so for any motion it is

        felt = AR / (AR + 2) (inflow - C_1 (inflow - slowed)),
        slowed' = C_2 (2 U / c) (inflow - slowed),                           see `slowing`

    without a frequency, and the mean flow comes out as DeLaurier's too.
    """
    c1, _ = wake_terms(aspect_ratio)
    return finite_span(aspect_ratio) * (inflow - c1 * (inflow - downwash))


def slowing(inflow, downwash, speed, chord: float, aspect_ratio: float):
    """d(slowed)/dt, m/s^2."""
    _, c2 = wake_terms(aspect_ratio)
    return c2 * 2.0 * speed / chord * (inflow - downwash)


def separated_flow_share(angle, craft: Aircraft):
    """Share of the flow that has left a section at an angle of attack (rad), in [0, 1].

    DeLaurier switches at the stall angle; this blends over `stall_width`, so that what is
    integrated is smooth: one half at +-`stall`.

    >>> from flockscope.flight import Aircraft
    >>> craft = Aircraft()
    >>> angles = [a * craft.stall for a in (0.0, 0.7, 1.0, 1.3, -1.0)]
    >>> [round(float(separated_flow_share(angle, craft)), 3) for angle in angles]
    [0.0, 0.057, 0.5, 0.943, 0.5]
    """
    stalled_above = 1.0 / (1.0 + np.exp((craft.stall - angle) / craft.stall_width))
    stalled_below = 1.0 / (1.0 + np.exp((craft.stall + angle) / craft.stall_width))
    return stalled_above + stalled_below


def loads(flow: Flow, chord: float, craft: Aircraft) -> Loads:
    """Forces on sections without those of the apparent mass, in N/m."""
    half = 0.5 * AIR * chord
    turning = chord * flow.rate
    speed = np.sqrt(flow.forward**2 + (flow.felt - 0.5 * turning) ** 2)
    circulation = 2.0 * math.pi * half * speed * flow.felt
    suction = craft.suction * 2.0 * math.pi * half * (flow.felt - 0.25 * turning) ** 2
    suction *= speed / flow.speed
    friction = craft.friction * half * flow.forward * np.abs(flow.forward)
    crossing = craft.cross_flow * half * np.sqrt(flow.forward**2 + flow.middle**2) * flow.middle
    separated_share = separated_flow_share((flow.felt - 0.75 * turning) / flow.speed, craft)
    return Loads(
        (1.0 - separated_share) * circulation + separated_share * crossing,
        (1.0 - separated_share) * (suction - friction),
        separated_share,
    )


def apparent_mass(chord: float) -> float:
    """rho pi c^2 / 4, kg per metre of span: air that moves with the chord."""
    return 0.25 * AIR * math.pi * chord**2


def apparent_inertia(chord: float) -> float:
    """rho pi c^4 / 128, kg m^2 per metre of span: air that turns with the chord."""
    return AIR * math.pi * chord**4 / 128.0


def turning_moment(rate, speed, chord: float):
    """Moment against a turning section, N m per metre of span, nose up; DeLaurier's -dM_a less
    the part of the apparent inertia."""
    return -AIR * math.pi * chord**3 / 16.0 * rate * speed


# Air forces on the tail: two plates that turn as one elevator, in the downwash of the wing.


class TailForces(NamedTuple):
    """Forces of the air on the tail; arrays (...,)."""

    X: np.ndarray
    """Along x_b, N."""
    Z: np.ndarray
    """Along z_b, downward, N."""
    M: np.ndarray
    """About y_b, nose up, N m."""


def tail_air(craft: Aircraft, u, w, q, tail) -> TailForces:
    """Forces on the tail at an angle `tail` (rad, nose up against x_b); u, w, q as (...,).

    It is a steady section without apparent mass, both plates in one span. The downwash takes the
    share `downwash` of w; the pitch rate adds q times the arm.
    """
    c, s = np.cos(tail), np.sin(tail)
    down = w * (1.0 - craft.downwash) + q * craft.tail_arm
    along, inflow = u * c - down * s, u * s + down * c
    width = 2.0 * craft.tail_width
    felt = finite_span(width / craft.tail_chord) * inflow
    flow = Flow(along, felt, inflow, 0.0, np.sqrt(u**2 + w**2))
    tail_loads = loads(flow, craft.tail_chord, craft)
    X = width * (tail_loads.chordwise * c - tail_loads.normal * s)
    Z = width * (-tail_loads.chordwise * s - tail_loads.normal * c)
    return TailForces(X, Z, craft.tail_arm * Z)


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
    partials = PartialVelocities(*np.zeros((3, *shape, 5)))
    partials.across[..., 0] = -s
    partials.across[..., 1] = -cos * c
    partials.across[..., 2] = reach * cos * c + y * sin * s
    partials.across[..., 3] = y * c
    partials.along[..., 0] = c
    partials.along[..., 1] = -cos * s
    partials.along[..., 2] = reach * cos * s - y * sin * c
    partials.along[..., 3] = y * s
    partials.turning[..., 2] = cos
    partials.turning[..., 4] = SHARE
    return partials


def wing_air(craft: Aircraft, u, w, q, flap: Swing, tip: Swing, downwash) -> WingForces:
    """Forces of the air on both wings.

    Parameters
    ----------
    u, w, q: (...,), m/s and rad/s. flap, tip: the flap and the twist of the wing tip, (...,).
    slowed: (..., STRIPS), the slowed inflow of every strip, m/s (see `effective_inflow`).
    """
    u, w, q = (np.asarray(motion, float)[..., None] for motion in (u, w, q))
    phi, dphi, ddphi = (np.asarray(derivative)[..., None] for derivative in flap)
    eta, deta, ddeta = (np.asarray(one)[..., None] * SHARE for one in tip)
    chord, ratio = craft.chord, craft.aspect_ratio
    y = SHARE * craft.half_span
    reach = craft.centre_of_mass - craft.twist_axis
    cos, sin, c, s = np.cos(phi), np.sin(phi), np.cos(eta), np.sin(eta)

    forward = u - q * y * sin
    up = dphi * y - (w - q * reach) * cos
    along = forward * c + up * s
    across = up * c - forward * s
    rate = deta + q * cos
    speed = np.sqrt(u**2 + w**2)
    inflow = -across + rate * (0.75 * chord - craft.twist_axis)
    middle = -across + rate * (0.50 * chord - craft.twist_axis)
    flow = Flow(along, effective_inflow(inflow, downwash, ratio), middle, rate, speed)
    section_loads = loads(flow, chord, craft)

    # Apparent mass: d(middle)/dt in two parts, the one of u', w', q' by partial velocities.
    d_ahead = -q * y * dphi * cos
    d_up = ddphi * y + (w - q * reach) * dphi * sin
    d_rate = ddeta - q * dphi * sin
    d_middle = deta * along - d_up * c + d_ahead * s + d_rate * (0.5 * chord - craft.twist_axis)
    moved_mass = apparent_mass(chord) * (1.0 - 0.5 * section_loads.separated)
    turned_inertia = apparent_inertia(chord)

    place = partial_velocities(craft, phi, eta)
    quarter, half = (share * chord - craft.twist_axis for share in (0.25, 0.50))
    lifted = moved_mass * d_middle
    couple = turning_moment(rate, speed, chord) - turned_inertia * d_rate
    couple = couple - quarter * section_loads.normal - half * lifted
    width = 2.0 * craft.half_span / STRIPS
    shares = width * (
        np.einsum("...s,...sk->...k", section_loads.normal + lifted, place.across)
        + np.einsum("...s,...sk->...k", section_loads.chordwise, place.along)
        + np.einsum("...s,...sk->...k", couple, place.turning)
    )
    centre = place.across - half * place.turning
    turn = place.turning
    mass = width * (
        np.swapaxes(centre * moved_mass[..., None], -1, -2) @ centre[..., :3]
        + turned_inertia * (np.swapaxes(turn, -1, -2) @ turn[..., :3])
    )
    X, Z, M, flapping, twisting = np.moveaxis(shares, -1, 0)
    slower = slowing(inflow, downwash, speed, chord, ratio)
    return WingForces(X, Z, M, flapping, twisting, mass, slower, section_loads.separated)
