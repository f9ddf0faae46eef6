"""Air on a section: DeLaurier's formulas, and his wake as a lag."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import flight_section as paper
from scipy.integrate import solve_ivp

from agents.flight.air_forces import Flow, effective_inflow, loads, separated_flow_share, slowing
from agents.flight.aircraft import Aircraft

CRAFT = Aircraft()
CHORD, RATIO = CRAFT.chord, CRAFT.aspect_ratio


@pytest.mark.parametrize("k", [0.05, 0.3, 1.0])
def test_the_lag_is_the_papers_wake_for_a_harmonic_inflow(k):
    """inflow = U (theta_bar + alpha), alpha = a sin(omega t): felt = U (alpha' + theta_bar)."""
    U, theta_bar, a = 3.5, 0.08, 0.2
    omega = 2.0 * k * U / CHORD

    def inflow(t):
        return U * (theta_bar + a * math.sin(omega * t))

    beat = 2.0 * math.pi / omega
    settled = 12 * beat + 12.0 * CHORD / U
    at = settled + beat * np.array([0.0, 0.2, 0.45, 0.8])
    made = solve_ivp(
        lambda t, x: slowing(inflow(t), x, U, CHORD, RATIO),
        (0.0, at[-1]), [U * theta_bar], t_eval=at, rtol=1e-11, atol=1e-12,
    )  # fmt: skip
    for t, slowed in zip(at, made.y[0], strict=True):
        alpha, d_alpha = a * math.sin(omega * t), a * omega * math.cos(omega * t)
        prime = paper.alpha_prime(alpha, d_alpha, k, theta_bar, U, CHORD, RATIO)
        expected = U * (prime + theta_bar)
        assert effective_inflow(inflow(t), slowed, RATIO) == pytest.approx(expected, abs=2e-8)


def test_a_steady_inflow_is_cut_by_the_finite_span_alone():
    assert effective_inflow(0.7, 0.7, RATIO) == pytest.approx(0.7 * RATIO / (RATIO + 2.0))
    assert slowing(0.7, 0.7, 3.5, CHORD, RATIO) == 0.0


flows = st.tuples(
    st.floats(-0.2, 0.2), st.floats(-4.0, 4.0), st.floats(-8.0, 8.0), st.floats(0.5, 9.0),
    st.floats(1.0, 9.0),
)  # fmt: skip


@given(flows)
@settings(max_examples=200, derandomize=True, deadline=None)
def test_forces_are_the_papers(flow):
    angle, middle, rate, Vx, U = flow
    made = loads(Flow(*map(np.float64, (Vx, U * angle, middle, rate, U))), CHORD, CRAFT)
    lead = paper.leading_edge_angle(angle, rate, U, CHORD)
    left = float(separated_flow_share(lead, CRAFT))
    N1, F1 = paper.attached(angle, middle, rate, Vx, U, CHORD, CRAFT.suction, CRAFT.friction)
    N2, F2 = paper.stalled(angle, middle, rate, Vx, U, CHORD, CRAFT.cross_flow)
    assert made.separated == pytest.approx(left, rel=1e-12)
    assert made.normal == pytest.approx((1 - left) * N1 + left * N2, rel=1e-12, abs=1e-12)
    assert made.chordwise == pytest.approx((1 - left) * F1 + left * F2, rel=1e-12, abs=1e-12)


def test_well_below_and_beyond_the_stall_it_is_one_or_the_other():
    low, high = 0.3 * CRAFT.stall, 2.0 * CRAFT.stall
    assert separated_flow_share(low, CRAFT) < 2e-3
    assert separated_flow_share(high, CRAFT) > 1.0 - 1e-4
    assert separated_flow_share(-high, CRAFT) == separated_flow_share(high, CRAFT)
    assert separated_flow_share(CRAFT.stall, CRAFT) == pytest.approx(0.5, abs=1e-8)


def test_full_suction_without_friction_is_the_potential_flow():
    """A steady plate of infinite span has lift, and no drag."""
    craft = Aircraft(suction=1.0, friction=0.0, stall=0.8, stall_width=0.005)
    U, angle = 5.0, 0.02
    flow = Flow(*map(np.float64, (U, U * angle, U * angle, 0.0, U)))
    made = loads(flow, 1.0, craft)
    drag = made.normal * math.sin(angle) - made.chordwise * math.cos(angle)
    lift = made.normal * math.cos(angle) + made.chordwise * math.sin(angle)
    assert lift == pytest.approx(math.pi * angle * 1.225 * U**2, rel=1e-3)
    assert abs(drag) < 1e-3 * lift
