"""The air on flapping wings by vectors in space: places, velocities and moments, strip by strip.

Written apart from the code: places of the wing are functions of time, velocities and accelerations
are differences of these, forces are vectors and their moments cross products. Both wings are gone
through, right and left.
"""

import math

import numpy as np

from oracles import flight_section as section

H = 1e-5
STEP = 1e-4


def frame(phi, eta, side):
    """Unit vectors of a strip: chord (forward), normal (upward), span (outward)."""
    span = np.array([0.0, side * math.cos(phi), -math.sin(phi)])
    up = np.array([0.0, -side * math.sin(phi), -math.cos(phi)])
    forward = np.array([1.0, 0.0, 0.0])
    chord = math.cos(eta) * forward + math.sin(eta) * up
    return chord, math.cos(eta) * up - math.sin(eta) * forward, span


def place(craft, motion, t, y, behind, side):
    """A point of the wing in body axes, `behind` the leading edge."""
    phi, eta = motion.phi(t), motion.tip(t) * y / craft.half_span
    chord, _, span = frame(phi, eta, side)
    axis = np.array([craft.centre_of_mass - craft.twist_axis, 0.0, 0.0]) + y * span
    return axis - (behind - craft.twist_axis) * chord


def velocity(craft, motion, t, y, behind, side):
    """Its velocity against the air at rest, in body axes."""
    moved = place(craft, motion, t + H, y, behind, side)
    moved = (moved - place(craft, motion, t - H, y, behind, side)) / (2.0 * H)
    turn = np.cross([0.0, motion.q(t), 0.0], place(craft, motion, t, y, behind, side))
    return np.array([motion.u(t), 0.0, motion.w(t)]) + turn + moved


def pitching(craft, motion, t, y):
    """theta' of a strip, nose up about its span."""
    d_eta = (motion.tip(t + H) - motion.tip(t - H)) / (2.0 * H) * y / craft.half_span
    return d_eta + motion.q(t) * math.cos(motion.phi(t))


def across(craft, motion, t, y, behind, side):
    """Velocity of the air across the chord, from below."""
    eta = motion.tip(t) * y / craft.half_span
    _, normal, _ = frame(motion.phi(t), eta, side)
    return -velocity(craft, motion, t, y, behind, side) @ normal


def wing_forces(craft, motion, t, slowed):
    """X, Z, M, torque of the flap and torque of the twist per radian of the tip, at time t.

    motion: functions phi, tip, u, w, q of time. slowed: the slowed inflow per strip, m/s.
    """
    c, AR = craft.chord, craft.aspect_ratio
    C1 = 0.5 * AR / (2.32 + AR)
    n = len(slowed)
    force, moment, flap, twist = np.zeros(3), np.zeros(3), 0.0, 0.0
    for side in (1.0, -1.0):
        for k in range(n):
            y = (k + 0.5) / n * craft.half_span
            phi, eta = motion.phi(t), motion.tip(t) * y / craft.half_span
            chord, normal, span = frame(phi, eta, side)
            U = math.hypot(motion.u(t), motion.w(t))
            rate = pitching(craft, motion, t, y)
            Vx = velocity(craft, motion, t, y, craft.twist_axis, side) @ chord
            rear = across(craft, motion, t, y, 0.75 * c, side)
            middle = across(craft, motion, t, y, 0.5 * c, side)
            angle = AR / (2.0 + AR) * (rear - C1 * (rear - slowed[k])) / U
            lead = section.leading_edge_angle(angle, rate, U, c)
            left = 1.0 / (1.0 + math.exp((craft.stall - lead) / craft.stall_width))
            left += 1.0 / (1.0 + math.exp((craft.stall + lead) / craft.stall_width))
            N1, F1 = section.attached(angle, middle, rate, Vx, U, c, craft.suction, craft.friction)
            N2, F2 = section.stalled(angle, middle, rate, Vx, U, c, craft.cross_flow)
            d_middle = across(craft, motion, t + STEP, y, 0.5 * c, side)
            d_middle -= across(craft, motion, t - STEP, y, 0.5 * c, side)
            N_a = section.RHO * math.pi * c**2 / 4.0 * d_middle / (2.0 * STEP) * (1.0 - 0.5 * left)
            d_rate = pitching(craft, motion, t + STEP, y) - pitching(craft, motion, t - STEP, y)
            M_a = -section.RHO * math.pi * c**3 * rate * U / 16.0
            M_a -= section.RHO * math.pi * c**4 * d_rate / (2.0 * STEP) / 128.0
            held = (
                (0.25 * c, ((1.0 - left) * N1 + left * N2) * normal),
                (0.50 * c, N_a * normal),
                (craft.twist_axis, ((1.0 - left) * F1 + left * F2) * chord),
            )
            axis = place(craft, motion, t, y, craft.twist_axis, side)
            about_axis = M_a
            nose_up = side * span  # y_b for the right and for the left wing
            for behind, f in held:
                at = place(craft, motion, t, y, behind, side)
                force += f
                moment += np.cross(at, f)
                flap += -side * np.cross(at, f)[0]
                about_axis += np.cross(at - axis, f) @ nose_up
            moment += M_a * nose_up
            twist += about_axis * y / craft.half_span
    width = craft.half_span / n
    return width * np.array([force[0], force[2], moment[1], flap, twist])


def tail_forces(craft, u, w, q, tail):
    """X, Z, M of the tail by vectors."""
    chord = np.array([math.cos(tail), 0.0, -math.sin(tail)])
    normal = np.array([-math.sin(tail), 0.0, -math.cos(tail)])
    at = np.array([-craft.tail_arm, 0.0, 0.0])
    wind = np.array([u, 0.0, (1.0 - craft.downwash) * w]) + np.cross([0.0, q, 0.0], at)
    U, Vx, middle = math.hypot(u, w), float(wind @ chord), float(-wind @ normal)
    AR = 2.0 * craft.tail_width / craft.tail_chord
    angle = AR / (AR + 2.0) * middle / U
    left = 1.0 / (1.0 + math.exp((craft.stall - angle) / craft.stall_width))
    left += 1.0 / (1.0 + math.exp((craft.stall + angle) / craft.stall_width))
    c = craft.tail_chord
    N1, F1 = section.attached(angle, middle, 0.0, Vx, U, c, craft.suction, craft.friction)
    N2, F2 = section.stalled(angle, middle, 0.0, Vx, U, c, craft.cross_flow)
    force = ((1.0 - left) * N1 + left * N2) * normal + ((1.0 - left) * F1 + left * F2) * chord
    force = 2.0 * craft.tail_width * force
    return np.array([force[0], force[2], np.cross(at, force)[1]])
