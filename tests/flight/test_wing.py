"""The air on wings and tail against vectors in space."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from oracles.flight_wing import across, tail_forces, wing_forces

from agents.flight.air_forces import SHARE, STRIPS, Flapping, tail_air, wing_air
from agents.flight.aircraft import Aircraft

TIME = 0.31


def motion_of(seed):
    """A random smooth motion of body and wings, and the aircraft."""
    draw = np.random.default_rng(seed)
    craft = Aircraft(
        centre_of_mass=draw.uniform(0.0, 0.2), twist_axis=draw.uniform(0.0, 0.3),
        stall=draw.uniform(0.1, 0.4), suction=draw.uniform(0.0, 1.0),
    )  # fmt: skip
    flapping = Flapping(
        draw.uniform(0.1, 0.6), draw.uniform(0.0, 0.5), draw.uniform(1.0, 2.0),
        phase=draw.uniform(0.0, 6.0), twist_phase=draw.uniform(0.0, 6.0),
    )  # fmt: skip
    start = np.array([4.0, 0.3, 0.0]) + draw.normal(0.0, 0.4, 3)
    slope = draw.normal(0.0, 4.0, 3)

    def speed(k):
        return lambda t: start[k] + slope[k] * (t - TIME)

    moved = SimpleNamespace(
        phi=lambda t: float(flapping.flap(t).angle),
        tip=lambda t: float(flapping.tip_twist(t).angle),
        u=speed(0), w=speed(1), q=speed(2),
    )  # fmt: skip
    return craft, flapping, moved, start, slope, draw


@pytest.mark.parametrize("seed", range(12))
def test_forces_and_torques_on_the_wings(seed):
    craft, flapping, moved, start, slope, draw = motion_of(seed)
    slowed = draw.normal(0.4, 0.3, STRIPS)
    air = wing_air(craft, *start, flapping.flap(TIME), flapping.tip_twist(TIME), slowed)
    made = np.array([air.X, air.Z, air.M, air.flap, air.twist]) - air.mass @ slope
    assert made == pytest.approx(wing_forces(craft, moved, TIME, slowed), rel=2e-6, abs=2e-6)


def test_what_slows_the_inflow_is_the_one_at_three_quarters_of_the_chord():
    craft, flapping, moved, start, _, draw = motion_of(99)
    slowed = draw.normal(0.4, 0.3, STRIPS)
    air = wing_air(craft, *start, flapping.flap(TIME), flapping.tip_twist(TIME), slowed)
    C2 = 0.181 + 0.772 / craft.aspect_ratio
    rate = C2 * 2.0 * math.hypot(start[0], start[1]) / craft.chord
    for k, share in enumerate(SHARE):
        rear = across(craft, moved, TIME, share * craft.half_span, 0.75 * craft.chord, 1.0)
        assert air.slowing[k] == pytest.approx(rate * (rear - slowed[k]), rel=1e-6, abs=1e-6)


def test_many_instants_at_once_are_those_one_by_one():
    craft, flapping, _, start, _, draw = motion_of(5)
    times, slowed = np.linspace(0.0, 1.0, 7), draw.normal(0.4, 0.3, (7, STRIPS))
    speeds = start[:, None] + draw.normal(0.0, 0.2, (3, 7))
    all_of = wing_air(craft, *speeds, flapping.flap(times), flapping.tip_twist(times), slowed)
    for k in range(7):
        at = times[k]
        one = wing_air(craft, *speeds[:, k], flapping.flap(at), flapping.tip_twist(at), slowed[k])
        for many, single in zip(all_of, one, strict=True):
            assert many[k] == pytest.approx(single, rel=1e-12, abs=1e-12)


def test_the_apparent_mass_is_symmetric_and_takes_energy_to_move():
    craft, flapping, _, start, _, draw = motion_of(7)
    slowed = draw.normal(0.4, 0.3, STRIPS)
    air = wing_air(craft, *start, flapping.flap(TIME), flapping.tip_twist(TIME), slowed)
    square = air.mass[:3]
    assert square == pytest.approx(square.T, abs=1e-12)
    assert np.linalg.eigvalsh(square).min() > -1e-12


@pytest.mark.parametrize("seed", range(8))
def test_forces_on_the_tail(seed):
    draw = np.random.default_rng(seed)
    craft = Aircraft(downwash=draw.uniform(0.0, 0.8), stall=draw.uniform(0.1, 0.4))
    u, w, q, tail = 4.0 + draw.normal(), draw.normal(0, 0.5), draw.normal(0, 1), draw.normal(0, 0.2)
    made = tail_air(craft, u, w, q, tail)
    assert np.array(made) == pytest.approx(tail_forces(craft, u, w, q, tail), rel=1e-12, abs=1e-12)
