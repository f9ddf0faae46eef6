"""Kane's equations of the aircraft in its plane of symmetry, (2.3) to (2.5) of the thesis.

Body axes: x_b forward, z_b down, origin in the centre of mass of body and tail; u, w, q velocity
and pitch rate (nose up), theta pitch. Wings of mass m_2 have their centre of mass l_2 out along
the wing, so at (0, +-l_2 cos phi, -l_2 sin phi). X, Z, M are the forces of the air:
X = -D cos a + L sin a, Z = -D sin a - L cos a.

    m (u' + q w) - 2 m_2 l_2 (q' sin phi + 2 q phi' cos phi) = X - m g sin theta             (2.3)
    m (w' - q u) + 2 m_2 l_2 (-phi'' cos phi + (q^2 + phi'^2) sin phi) = Z + m g cos theta   (2.4)
    (I_1y + 2 I_2y) q' + 2 I_2y <eta''>
        - 2 m_2 l_2 sin phi (u' + q w - q' l_2 sin phi - 2 q l_2 phi' cos phi + g sin theta) = M
                                                                                             (2.5)

Corrected: (2.4) is printed with phi^2 for phi'^2, with sin phi and cos phi for those of the angle
of attack; (2.5) with a plus before 2 m_2 l_2, with which a couple's work is not the kinetic energy
gained (`PRINTED` keeps it for the test that shows this). eta is nose up here, hence the plus before
its term, and <eta''> is the mean over the wing, since the twist grows with the span.
"""

from __future__ import annotations

import numpy as np

from agents.flight.aircraft import GRAVITY, Aircraft
from agents.flight.kinematics import Swing

CORRECTED, PRINTED = -1.0, 1.0
"""Sign before 2 m_2 l_2 in (2.5)."""
MEAN_SHARE, MEAN_SQUARE = 0.5, 1.0 / 3.0
"""Means over the wing of the twist and of its square, for a tip that twists by 1."""


def inertia(craft: Aircraft, flap: Swing, sign: float = CORRECTED) -> np.ndarray:
    """What multiplies (u', w', q') on the left of (2.3) to (2.5), (..., 3, 3), kg, kg m, kg m^2."""
    sin = np.sin(flap.angle)
    arm = 2.0 * craft.wing_mass * craft.wing_centre * sin
    made = np.zeros((*np.shape(sin), 3, 3))
    made[..., 0, 0] = made[..., 1, 1] = craft.mass
    made[..., 0, 2] = -arm
    made[..., 2, 0] = sign * arm
    made[..., 2, 2] = (
        craft.body_inertia + 2.0 * craft.wing_inertia - sign * arm * craft.wing_centre * sin
    )
    return made


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
    moved = 2.0 * craft.wing_mass * craft.wing_centre
    weight = craft.mass * gravity
    swept = 2.0 * q * craft.wing_centre * flap.rate * cos
    return np.stack(
        (
            -weight * np.sin(pitch) - craft.mass * q * w + 2.0 * craft.wing_mass * swept,
            weight * np.cos(pitch)
            + craft.mass * q * u
            + moved * (flap.acceleration * cos - (q**2 + flap.rate**2) * sin),
            -2.0 * craft.wing_inertia * MEAN_SHARE * tip.acceleration
            - sign * moved * sin * (q * w - swept + gravity * np.sin(pitch)),
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
