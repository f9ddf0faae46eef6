"""The inertial spin model against its oracle, in exact cases, and what it conserves."""

import math

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import inertial_spin as oracle
from oracles.scenes import unit_vectors

from agents import Flock

STILL = 1e-6
"""A speed at which nobody leaves its place."""


def spins(flock):
    return np.column_stack([flock.signal(f"spin_{axis}") for axis in "xyz"])


def planar(angles):
    return np.column_stack([np.cos(angles), np.sin(angles)])


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 14),
    dim=st.sampled_from((2, 3)),
    world=st.sampled_from(("wrap", "open")),
    eta=st.sampled_from((0.0, 0.3, 30.0)),
    chi=st.sampled_from((0.05, 1.0)),
)
def test_every_tick_is_the_oracles(seed, n, dim, world, eta, chi):
    rng = np.random.default_rng(seed)
    first = {"position": rng.uniform(0.0, 6.0, (n, dim)), "heading": unit_vectors(rng, n, dim)}
    given = {"r": 1.8, "J": 0.8, "eta": eta, "chi": chi, "v0": 1.3, "dt": 0.05}
    flock = Flock("inertial-spin", start=first, world=world, size=6.0, dim=dim, T=0.0, **given)
    side = np.full(dim, 6.0) if world == "wrap" else None
    x, u, s = flock.position.copy(), flock.heading.copy(), spins(flock)
    for _ in range(4):
        x, u, s = oracle.step(x, u, s, given, side)
        flock.run(1)
        assert np.abs(oracle.images(flock.position - x, side)).max() < 1e-9
        np.testing.assert_allclose(flock.heading, u, rtol=0, atol=1e-9)
        np.testing.assert_allclose(spins(flock), s, rtol=0, atol=1e-9)
        x, u, s = flock.position.copy(), flock.heading.copy(), spins(flock)


@pytest.mark.parametrize("dim", [2, 3])
def test_without_friction_and_noise_the_spin_of_the_flock_is_conserved(dim):
    """Neighbours turn each other by opposite torques, whatever they do meanwhile."""
    given = {"r": 2.0, "eta": 0.0, "T": 0.0, "size": 8.0, "dim": dim, "agents": 60, "rng": 4}
    flock = Flock("inertial-spin", **given)
    flock.run(300)
    assert np.abs(spins(flock)).max() > 0.5
    assert np.abs(spins(flock).sum(axis=0)).max() < 1e-10
    across = (spins(flock)[:, :dim] * flock.heading).sum(axis=1)
    assert np.abs(across).max() < 1e-11, "a spin stays across its heading"


def test_two_agents_swing_about_each_other():
    """chi phi'' = -2 J sin phi of the angle between two: at small angles omega^2 = 2 J / chi.

    In ticks of dt, 2 sin(omega dt / 2) = dt sqrt(2 J / chi), exactly.
    """
    angle, J, chi, dt = 1e-5, 0.7, 1.3, 0.1
    first = {"position": [[0.0, 0.0], [1.0, 0.0]], "heading": planar([0.0, angle])}
    flock = Flock(
        "inertial-spin", start=first, world="open", size=9.0, dim=2, r=2.0, J=J, chi=chi, eta=0.0,
        T=0.0, v0=STILL, dt=dt,
    )  # fmt: skip
    omega = 2.0 / dt * math.asin(0.5 * dt * math.sqrt(2.0 * J / chi))
    for _ in range(40):
        flock.run(5)
        between = np.diff(np.arctan2(flock.heading[:, 1], flock.heading[:, 0]))[0]
        t = flock.elapsed
        swing = math.cos(omega * (t + 0.5 * dt)) / math.cos(0.5 * omega * dt)
        assert between == pytest.approx(angle * swing, abs=1e-6 * angle)


@pytest.mark.parametrize("mode", [1, 3, 7])
def test_a_chain_has_the_waves_of_the_linear_theory(mode):
    """omega^2 = (2 J / chi) (1 - cos k a) of a ring of neighbours a apart: sound at small k."""
    n, a, J, chi, dt = 20, 1.0, 1.1, 0.9, 0.05
    k = 2.0 * math.pi * mode / (n * a)
    wave = 1e-5 * np.cos(k * a * np.arange(n))
    position = np.column_stack([a * np.arange(n), np.full(n, 5.0)])
    flock = Flock(
        "inertial-spin", start={"position": position, "heading": planar(wave)}, world="wrap",
        size=(n * a, 10.0), r=1.2 * a, J=J, chi=chi, eta=0.0, T=0.0, v0=STILL, dt=dt,
    )  # fmt: skip
    squared = 2.0 * J / chi * (1.0 - math.cos(k * a))
    omega = 2.0 / dt * math.asin(0.5 * dt * math.sqrt(squared))
    for _ in range(10):
        flock.run(17)
        swing = math.cos(omega * (flock.elapsed + 0.5 * dt)) / math.cos(0.5 * omega * dt)
        found = np.arctan2(flock.heading[:, 1], flock.heading[:, 0])
        np.testing.assert_allclose(found, wave * swing, rtol=0, atol=1e-10)


def test_friction_stops_a_lone_turn():
    """ds/dt = -(eta / chi) s: e^(-eta t / chi) of it is left, and it has turned by its integral."""
    first = {"position": [[0.0, 0.0]], "heading": [[1.0, 0.0]]}
    flock = Flock(
        "inertial-spin", start=first, world="open", size=9.0, dim=2, eta=0.5, chi=2.0, T=0.0, dt=0.1
    )
    flock.arrays.memory[2, 0] = 0.4
    flock.run(10)
    left = math.exp(-0.5 * 1.0 / 2.0)
    assert spins(flock)[0] == pytest.approx([0.0, 0.0, 0.4 * left])
    turned = 0.4 / 0.5 * (1.0 - left)
    assert flock.heading[0] == pytest.approx([math.cos(turned), math.sin(turned)])
    assert flock.speed[0] == 1.0


LAWS = [
    (0.05, 5.0, 0.05),
    (0.001, 100.0, 1.0),
    (1.5, 3.0, 0.02),
    pytest.param(1.0, 0.1, 0.05, marks=pytest.mark.long),
    pytest.param(100.0, 0.01, 1.0, marks=pytest.mark.long),
]
"""chi, eta and dt from one end of their ranges to the other."""


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize(("chi", "eta", "dt"), LAWS)
def test_alone_the_spin_has_the_energy_of_its_temperature(dim, chi, eta, dt):
    """<s^2> / (2 chi) is T / 2 for each of the d - 1 ways to turn, at any length of a tick."""
    n, T = 200_000 // (dim - 1), 0.01  # the same error: a spin has d - 1 ways
    flock = Flock(
        "inertial-spin",
        agents=n,
        size=2000.0,
        dim=dim,
        rng=2,
        r=0.05,
        J=0.0,
        chi=chi,
        T=T,
        eta=eta,
        dt=dt,
    )
    a = eta * dt / chi
    flock.run(min(25, math.ceil(4.0 / a)))
    passed = 1.0 - math.exp(-2.0 * a * flock.tick)
    per_way = (spins(flock) ** 2).sum(axis=1).mean() / (dim - 1)
    assert per_way == pytest.approx(chi * T * passed, rel=0.01)
    across = (spins(flock)[:, :dim] * flock.heading).sum(axis=1)
    assert np.abs(across).max() < 1e-9 * math.sqrt(chi * T), "a spin stays across its heading"


@pytest.mark.parametrize(("chi", "eta", "dt"), LAWS)
def test_alone_it_turns_at_random_as_far_as_its_law_says(chi, eta, dt):
    """Ornstein and Fuerth: <angle^2> of a spin that begins at 0, in the plane, after t."""
    n, T, ticks = 40_000, 1e-4, 20
    place = np.indices((200, 200)).reshape(2, n).T * 2.0
    first = {"position": place, "heading": planar(np.zeros(n))}
    flock = Flock(
        "inertial-spin", start=first, world="open", dim=2, rng=3, r=0.05, v0=STILL, J=0.0, chi=chi,
        T=T, eta=eta, dt=dt,
    )  # fmt: skip
    flock.run(ticks)
    g, t = eta / chi, ticks * dt
    e = math.exp(-g * t)
    if g * t > 1e-2:
        law = 2.0 * T * eta / (chi * g) ** 2 * (t - 2.0 * (1.0 - e) / g + (1.0 - e * e) / (2.0 * g))
    else:
        law = 2.0 * T * eta / chi**2 * t**3 * (1.0 / 3.0 - g * t / 4.0)
    angle = np.arctan2(flock.heading[:, 1], flock.heading[:, 0])
    assert (angle**2).mean() == pytest.approx(law, rel=5.0 * math.sqrt(2.0 / n))
    assert angle.mean() == pytest.approx(0.0, abs=5.0 * math.sqrt(law / n))


def test_without_inertia_it_is_a_vicsek_model_in_continuous_time():
    """eta dphi/dt = J sum sin(phi_j - phi_i) where chi is nothing beside eta dt."""
    angles = np.array([0.0, 0.7, 2.0])
    first = {"position": [[0.0, 0.0], [1.0, 0.0], [0.5, 0.5]], "heading": planar(angles)}
    given = {"J": 0.5, "eta": 2.0, "dt": 0.01, "v0": STILL, "T": 0.0, "chi": 0.001}
    flock = Flock("inertial-spin", start=first, world="open", size=9.0, dim=2, **given)
    flock.run(200)
    for _ in range(200):
        torque = np.sin(angles[None] - angles[:, None]).sum(axis=1)
        angles = angles + given["dt"] * given["J"] / given["eta"] * torque
    found = np.arctan2(flock.heading[:, 1], flock.heading[:, 0])
    assert found == pytest.approx(angles, abs=0.01)
    assert np.ptp(found) < 0.7, "they have come nearer, from 2"


def test_an_information_agent_keeps_its_heading_and_the_others_come_round():
    n = 30
    rng = np.random.default_rng(1)
    first = {
        "position": rng.uniform(0.0, 4.0, (n, 2)),
        "heading": planar(np.where(np.arange(n) == 0, 1.0, 0.0)),
        "informed": np.arange(n) == 0,
    }
    flock = Flock("inertial-spin", start=first, size=4.0, dim=2, world="wrap", T=0.0, eta=1.0)
    flock.run(3000)
    assert flock.heading[0] == pytest.approx([math.cos(1.0), math.sin(1.0)])
    assert flock.observe("polarisation") > 0.999


def test_a_state_from_before_there_was_a_mean_spin_goes_on(tmp_path):
    """It is written anew in each tick, so that nothing is lost."""
    flock = Flock("inertial-spin", agents=20, rng=1)
    flock.run(20)
    flock.save(tmp_path / "new.parquet")
    flock.run(10)
    table = pq.read_table(tmp_path / "new.parquet")
    old = [name for name in table.column_names if not name.startswith("mean_spin")]
    pq.write_table(table.select(old), tmp_path / "old.parquet")
    again = Flock.load(tmp_path / "old.parquet")
    again.run(10)
    np.testing.assert_array_equal(again.heading, flock.heading)
