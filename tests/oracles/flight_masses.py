"""Body and wings as masses in space: their energy and momentum from places and velocities.

Earth axes: x forward, z down. Angles and rates as in the thesis; twist of the tip, linear in span.
"""

import math

import numpy as np


def to_earth(theta):
    """Turns body axes (x_b, y_b, z_b) into earth axes."""
    c, s = math.cos(theta), math.sin(theta)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def wings(craft, state, phi, d_phi):
    """Places and velocities of the two wings' centres of mass in earth axes."""
    u, w, q, theta, x, z = state[:6]
    l2 = craft.wing_centre
    turn = to_earth(theta)
    made = []
    for side in (1.0, -1.0):
        r = np.array([0.0, side * l2 * math.cos(phi), -l2 * math.sin(phi)])
        dr = d_phi * np.array([0.0, -side * l2 * math.sin(phi), -l2 * math.cos(phi)])
        v = np.array([u, 0.0, w]) + np.cross([0.0, q, 0.0], r) + dr
        made.append((np.array([x, 0.0, z]) + turn @ r, turn @ v))
    return made


def energy(craft, state, phi, d_phi, d_tip, gravity):
    """Kinetic energy and energy of height, J."""
    u, w, q, _, _, z = state[:6]
    body = craft.mass - 2.0 * craft.wing_mass
    made = 0.5 * body * (u * u + w * w) + 0.5 * craft.body_inertia * q * q - body * gravity * z
    for at, v in wings(craft, state, phi, d_phi):
        made += 0.5 * craft.wing_mass * v @ v - craft.wing_mass * gravity * at[2]
        made += 0.5 * craft.flap_inertia * d_phi**2
        shares = (np.arange(4000) + 0.5) / 4000.0
        made += 0.5 * craft.wing_inertia * float(np.mean((q + shares * d_tip) ** 2))
    return made


def momentum(craft, state, phi, d_phi, d_tip):
    """Forward, downward (kg m/s) and pitching (kg m^2/s, nose up, about the earth's origin)."""
    u, w, q, theta, x, z = state[:6]
    body = craft.mass - 2.0 * craft.wing_mass
    parts = [(body, np.array([x, 0.0, z]), to_earth(theta) @ np.array([u, 0.0, w]))]
    parts += [(craft.wing_mass, at, v) for at, v in wings(craft, state, phi, d_phi)]
    linear = sum(mass * v for mass, _, v in parts)
    turning = sum(mass * np.cross(at, v) for mass, at, v in parts)
    spin = craft.body_inertia * q + 2.0 * craft.wing_inertia * (q + 0.5 * d_tip)
    return np.array([linear[0], linear[2], turning[1] + spin])
