"""Kane's equations keep energy and momentum; as printed they do not."""

import numpy as np
import pytest
from oracles import flight_masses as masses
from scipy.integrate import solve_ivp

from agents.flight.air_forces import Flapping, swing
from agents.flight.aircraft import GRAVITY, Aircraft
from agents.flight.flight_motion import CORRECTED, PRINTED, forcing, hinge_torques, inertia

CRAFT = Aircraft(wing_mass=0.05)
BEAT = Flapping(0.5, 0.3, 1.7, phase=0.4)


def gained(speeds, theta, flap, tip, force, gravity, sign=CORRECTED):
    """(u', w', q') under a force (3,)."""
    right = forcing(CRAFT, speeds, theta, flap, tip, gravity, sign) + force
    return np.linalg.solve(inertia(CRAFT, flap, sign), right)


def slope(state, at, force, gravity):
    """d(state)/dt of u, w, q, theta, x, z with beating wings."""
    u, w, q, theta = state[:4]
    c, s = np.cos(theta), np.sin(theta)
    made = gained(state[:3], theta, BEAT.flap(at), BEAT.tip_twist(at), force, gravity)
    return np.array([*made, q, u * c + w * s, w * c - u * s])


def couple_work(sign):
    """Energy gained less the work of a couple on the aircraft with its wings held up, J."""
    held, couple = swing(0.6, 0.0, np.pi / 2, 0.0), 0.01
    still = swing(0.0, 1.0, 0.0, 0.0)

    def rates(_, y):
        made = gained(y[:3], 0.0, held, still, np.array([0.0, 0.0, couple]), 0.0, sign)
        return [*made, couple * y[2]]

    begin = [3.0, 0.5, 0.2, 0.0]
    made = solve_ivp(rates, (0.0, 1.5), begin, rtol=1e-11, atol=1e-12).y[:, -1]
    energy = [
        masses.energy(CRAFT, [*y[:3], 0.0, 0.0, 0.0], 0.6, 0.0, 0.0, 0.0) for y in (begin, made)
    ]
    return energy[1] - energy[0] - made[3], made[3]


def test_the_work_of_a_couple_is_the_energy_gained():
    """d(KE)/dt = M q."""
    error, work = couple_work(CORRECTED)
    assert work > 0.005
    assert abs(error) < 1e-9


def test_with_the_printed_sign_it_is_not():
    error, work = couple_work(PRINTED)
    assert abs(error) > 0.05 * abs(work)


def test_momentum_is_kept_while_the_wings_beat():
    """No air, no weight: linear and angular momentum of the masses in space."""

    def values(state, at):
        flap, tip = BEAT.flap(at), BEAT.tip_twist(at)
        return masses.momentum(CRAFT, state, flap.angle, flap.rate, tip.rate)

    begin = np.array([3.0, 0.4, 0.8, 0.2, 0.0, 0.0])
    end = solve_ivp(
        lambda t, y: slope(y, t, np.zeros(3), 0.0), (0.0, 1.3), begin, rtol=1e-11, atol=1e-12
    ).y[:, -1]
    assert np.linalg.norm(end[:4] - begin[:4]) > 0.5
    assert values(end, 1.3) == pytest.approx(values(begin, 0.0), abs=1e-8)


@pytest.mark.parametrize("seed", range(6))
def test_the_work_of_shafts_and_forces_is_the_energy_gained(seed):
    draw = np.random.default_rng(seed)
    state, force, h = draw.normal(0.0, 1.0, 6), draw.normal(0.0, 0.5, 3), 1e-5
    at = draw.uniform(0.0, 1.0)
    flap, tip = BEAT.flap(at), BEAT.tip_twist(at)
    rates = slope(state, at, force, GRAVITY)

    def energy(sign):
        there = state + sign * h * rates  # along the flight, exact to second order in the middle
        one, other = BEAT.flap(at + sign * h), BEAT.tip_twist(at + sign * h)
        return masses.energy(CRAFT, there, one.angle, one.rate, other.rate, GRAVITY)

    grows = (energy(1) - energy(-1)) / (2.0 * h)
    torque = hinge_torques(CRAFT, state[:3], rates[:3], state[3], flap, tip)
    given = torque[0] * flap.rate + torque[1] * tip.rate + force @ state[:3]
    assert grows == pytest.approx(given, rel=1e-6, abs=1e-6)


def test_with_wings_held_flat_it_is_a_fixed_wing():
    flat = swing(0.0, 1.0, 0.0, 0.0)
    made = gained(np.array([4.0, 1.0, 0.5]), 0.1, flat, flat, np.array([1.0, 2.0, 0.3]), GRAVITY)
    total = CRAFT.body_inertia + 2.0 * CRAFT.wing_inertia
    assert made == pytest.approx(
        [
            1.0 / CRAFT.mass - GRAVITY * np.sin(0.1) - 0.5 * 1.0,
            2.0 / CRAFT.mass + GRAVITY * np.cos(0.1) + 0.5 * 4.0,
            0.3 / total,
        ]
    )
