"""Air forces on a section of a flapping wing, after DeLaurier (1993), per metre of span.

What DeLaurier writes as flight speed times an angle is here a velocity, so that the section may
belong to a body that flies freely:

    inflow   velocity of the air across the chord, from below, at three quarters of the chord:
             U alpha of DeLaurier, mean pitch included
    felt     what of it makes circulation: finite span and shed wake slow it down (see `felt`)
    middle   the same velocity at half of the chord, U alpha - 3/4 c theta' + 1/2 c theta'
    forward  V_x, velocity of the section along its chord
    rate     theta', nose up

Sections are uncambered: alpha_0 = 0 and C_mac = 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from agents.flight.aircraft import AIR, Aircraft


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


def felt(inflow, slowed, aspect_ratio: float):
    """The inflow that makes circulation, m/s; shapes fit each other.

    DeLaurier multiplies an inflow of reduced frequency k by AR / (AR + 2) (F'(k) + i G'(k)) with
    F' + i G' = 1 - C_1 i k / (i k + C_2). That is the answer of a lag, so for any motion it is

        felt = AR / (AR + 2) (inflow - C_1 (inflow - slowed)),
        slowed' = C_2 (2 U / c) (inflow - slowed),                           see `slowing`

    without a frequency, and the mean flow comes out as DeLaurier's too.
    """
    c1, _ = wake_terms(aspect_ratio)
    return finite_span(aspect_ratio) * (inflow - c1 * (inflow - slowed))


def slowing(inflow, slowed, speed, chord: float, aspect_ratio: float):
    """d(slowed)/dt, m/s^2."""
    _, c2 = wake_terms(aspect_ratio)
    return c2 * 2.0 * speed / chord * (inflow - slowed)


def separated(angle, craft: Aircraft):
    """Share of the flow that has left a section at an angle of attack (rad), in [0, 1].

    DeLaurier switches at the stall angle; this blends over `stall_width`, so that what is
    integrated is smooth: one half at +-`stall`.

    >>> from flockscope.flight import Aircraft
    >>> craft = Aircraft()
    >>> [round(float(separated(a * craft.stall, craft)), 3) for a in (0.0, 0.7, 1.0, 1.3, -1.0)]
    [0.0, 0.057, 0.5, 0.943, 0.5]
    """
    above = 1.0 / (1.0 + np.exp((craft.stall - angle) / craft.stall_width))
    below = 1.0 / (1.0 + np.exp((craft.stall + angle) / craft.stall_width))
    return above + below


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
    left = separated((flow.felt - 0.75 * turning) / flow.speed, craft)
    return Loads(
        (1.0 - left) * circulation + left * crossing, (1.0 - left) * (suction - friction), left
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
