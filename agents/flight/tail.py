"""Air forces on the tail: two plates that turn as one elevator, in the downwash of the wing."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agents.flight.aircraft import Aircraft
from agents.flight.section import Flow, finite_span, loads


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
    made = loads(flow, craft.tail_chord, craft)
    X = width * (made.chordwise * c - made.normal * s)
    Z = width * (-made.chordwise * s - made.normal * c)
    return TailForces(X, Z, craft.tail_arm * Z)
