"""How the wings are driven: flap (2.1) and twist (2.2), with their derivatives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

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
