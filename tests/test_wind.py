"""Wind carries every agent along, beside its own motion."""

from __future__ import annotations

import math

import numpy as np
import pytest

from agents import Flock
from agents.conditions import Conditions, Wind
from agents.spec import Spec
from worlds.input_error import InputError

ALONE = {"position": [[5.0, 5.0]], "heading": [[1.0, 0.0]]}


def alone(**wind):
    """One agent that keeps its heading, 0.03 a tick, in the open."""
    return Flock("vem", start=ALONE, size=10.0, world="open", rng=1, v0=0.03, eta=0.0, **wind)


def test_constant_wind_is_a_drift():
    flock = alone(wind=0.2, wind_heading=90.0)
    flock.run(50)
    np.testing.assert_allclose(flock.position, [[5.0 + 50 * 0.03, 5.0 + 50 * 0.2]], atol=1e-12)
    assert flock.heading.tolist() == [[1.0, 0.0]]
    assert flock.speed.tolist() == [0.03]


def test_it_is_a_speed_whatever_the_length_of_a_tick():
    calm, windy = (
        Flock("reynolds", agents=9, world="open", size=900.0, rng=3, wind=wind)
        for wind in (0.0, 0.5)
    )
    assert calm.dt != 1.0
    for flock in (calm, windy):
        flock.run(1)
    moved = windy.position - calm.position
    np.testing.assert_allclose(moved, np.tile([0.5 * calm.dt, 0.0], (9, 1)), atol=1e-9)


def test_upwards_there_is_only_in_space():
    start = {"position": [[5.0, 5.0, 5.0]], "heading": [[1.0, 0.0, 0.0]]}
    flock = Flock("vem", start=start, size=10.0, dim=3, world="open", rng=1, eta=0.0, wind_up=-0.1)
    flock.run(10)
    assert flock.position[0, 2] == pytest.approx(4.0)
    flat = alone(wind_up=0.1)
    flat.run(10)
    assert flat.position[0, 1] == 5.0


def test_a_pulse_has_a_beginning_and_an_end():
    flock = alone(pulse=0.5, pulse_at=10.0, pulse_lasts=4.0, wind_heading=90.0)
    where = flock.trace(30)[:, 0, 1]
    assert where[9] == 5.0
    assert where[13] == pytest.approx(7.0)
    assert where[-1] == pytest.approx(7.0)


def test_gusts_are_an_ornstein_uhlenbeck_process():
    """Stationary from tick 0: variance sigma^2, correlation exp(-t / T), and the drift they make.

    Var of the integral: 2 sigma^2 T^2 (t / T - 1 + exp(-t / T)), for ticks much shorter than T.
    """
    sigma, lasts, dt, ticks = 0.7, 0.5, 0.02, 400
    gusty = Conditions(gusts=sigma, gust_time=lasts)
    blown = np.array([Wind(gusty, seed, dt, 3).displacements(0, ticks) for seed in range(700)]) / dt
    assert blown.shape == (700, ticks, 3)
    many = np.concatenate([blown[:, :, axis] for axis in range(3)])
    assert many.mean() == pytest.approx(0.0, abs=0.05)
    for at in (0, 1, 200, 399):
        assert many[:, at].std() == pytest.approx(sigma, rel=0.06)
    for lag in (5, 25, 50):
        found = np.corrcoef(many[:, 100], many[:, 100 + lag])[0, 1]
        assert found == pytest.approx(math.exp(-lag * dt / lasts), abs=0.07)
    drift = many.sum(axis=1) * dt
    t = ticks * dt
    expected = math.sqrt(2.0 * sigma**2 * lasts**2 * (t / lasts - 1.0 + math.exp(-t / lasts)))
    assert drift.std() == pytest.approx(expected, rel=0.06)


def test_gusts_depend_on_seed_and_tick_alone():
    gusty = Conditions(gusts=1.0, wind=0.1, gust_time=3.0)
    whole = Wind(gusty, 5, 0.1, 2).displacements(0, 60)
    again = Wind(gusty, 5, 0.1, 2)
    parts = [again.displacements(0, 7), again.displacements(7, 1), again.displacements(8, 52)]
    assert np.array_equal(np.concatenate(parts), whole)
    assert np.array_equal(again.displacements(20, 10), whole[20:30])
    assert not np.array_equal(Wind(gusty, 6, 0.1, 2).displacements(0, 60), whole)
    assert (whole[:, 2] == 0.0).all()


@pytest.mark.parametrize("way", ["run", "step", "members", "load"])
def test_every_way_of_running_has_the_same_wind(way, tmp_path):
    one, other = (Flock("hwvem", agents=30, rng=4, gusts=0.1, wind=0.05) for _ in range(2))
    one.run(12)
    if way == "run":
        other.run(5)
        other.run(7)
    elif way == "step":
        for _ in range(12):
            other.step()
    elif way == "members":
        for _ in range(12):
            for member in other.members:
                member.step()
    else:
        other.run(5)
        other.save(tmp_path / "state.parquet")
        other = Flock.load(tmp_path / "state.parquet")
        other.run(7)
    assert np.array_equal(one.position, other.position)


@pytest.mark.parametrize("model", ["vem", "hwvem-nav", "couzin", "olfati-saber"])
def test_nobody_is_blown_into_what_is_solid(model):
    flock = Flock(
        model, agents=15, world="obstacles", rng=2, wind=2.0, gusts=2.0, wind_heading=30.0
    )
    for _ in range(40):
        flock.run(5)
        assert flock.stray() is None


@pytest.mark.parametrize(
    "wrong", [{"wind": -1.0}, {"gust_time": 0.0}, {"wind_heading": 400.0}, {"pulse": math.inf}]
)
def test_what_cannot_be_is_one_line(wrong):
    with pytest.raises(InputError, match=f"{next(iter(wrong))} = .* is not allowed: a number in"):
        Spec("vem", **wrong)


def test_a_run_with_wind_is_written_and_read_and_one_without_says_nothing_of_it():
    windy = Spec("vem", wind=0.3, gusts=0.1, delay=2.0)
    assert Spec.from_toml(windy.to_toml()) == windy
    assert "wind" not in Spec("vem").to_toml()
