"""The point mass: Newton's second law, exactly, with and without a largest speed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from agents import Flock
from agents.bodies import point_mass
from agents.catalogue import MODELS
from agents.engine.block import Decision
from agents.models.declare import Parameters, Rule, parameter
from agents.models.model import Model
from worlds.compilation import compiled


class Pulled(Parameters):
    """A force."""

    r: float = parameter(1.0, "Reach", symbol="r", source="none", low=0.1, high=2.0)
    k: float = parameter(1.0, "Stiffness", symbol="k", source="none", low=0.0, high=9.0)
    f: float = parameter(0.0, "Force along x", symbol="f", source="none", low=-9.0, high=9.0)


@compiled
def decide(me, near, surroundings, p):  # noqa: ARG001
    """A spring to the origin, and a constant force along x."""
    return Decision(p.f - p.k * me.x, -p.k * me.y, -p.k * me.z)


RULE = Rule("pulled", "Pulled", "Pulled.", "x", "none", Pulled, decide, wish="acceleration")


@pytest.fixture
def pulled(monkeypatch):
    """Makes a flock of one agent on a spring, which may be at rest at first."""
    monkeypatch.setitem(MODELS, "pulled", Model(RULE, point_mass.BODY))

    def made(position, speed=0.0, **settings):
        start = {"position": [position], "heading": [[1.0, 0.0]], "speed": [speed]}
        return Flock("pulled", start=start, world="open", rng=1, interpret=True, **settings)

    return made


def test_a_constant_force_gives_f_over_m_times_t(pulled):
    flock = pulled((1.0, 2.0), k=0.0, f=3.0, m=2.0, dt=0.01)
    flock.run(100)
    assert flock.speed[0] == pytest.approx(3.0 / 2.0 * 1.0)
    # semi-implicit: x = a dt^2 n (n + 1) / 2
    assert flock.position[0] == pytest.approx([1.0 + 1.5 * 0.01**2 * 100 * 101 / 2, 2.0])
    assert flock.elapsed == pytest.approx(1.0)


def test_the_speed_is_limited_only_where_that_is_asked_for(pulled):
    limited, free = (pulled((1.0, 2.0), k=0.0, f=3.0, v_max=v) for v in (0.5, 0.0))
    for flock in (limited, free):
        flock.run(100)
    assert limited.speed[0] == pytest.approx(0.5)
    assert free.speed[0] == pytest.approx(3.0)


def test_a_step_that_is_too_long_for_the_force_shows_in_the_speed(pulled):
    # Semi-implicit Euler swings up where dt sqrt(k / m) > 2.
    stable, unstable = (pulled((1.0, 0.0), k=4.0, m=1.0, dt=dt) for dt in (0.99, 1.0))
    unstable.set(k=9.0)
    stable.run(2000)
    unstable.run(2000)
    assert stable.speed[0] < 100.0
    assert unstable.speed[0] == point_mass.FASTEST
    assert np.isfinite(unstable.position).all()


def test_a_spring_swings_with_its_period_and_keeps_its_energy(pulled):
    flock = pulled((1.0, 0.0), k=4.0, m=1.0, dt=0.01)
    along = flock.trace(3142)[:, 0, 0]  # ten periods of 2 pi / sqrt(k / m)
    assert along.max() <= 1.02
    swings = np.flatnonzero((along[:-1] < 0.0) & (along[1:] >= 0.0))
    assert np.diff(swings) * 0.01 == pytest.approx(np.pi, abs=0.011)
    assert len(swings) == 10


def test_at_rest_the_heading_is_kept_and_any_rule_of_accelerations_may_have_it(pulled):
    flock = pulled((0.0, 0.0), k=1.0)
    flock.run(2)
    assert flock.heading[0].tolist() == [1.0, 0.0]
    Model(replace(MODELS["olfati-saber"].rule, name="mine"), point_mass.BODY)
