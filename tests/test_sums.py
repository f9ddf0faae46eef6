"""A sum said once: what an agent listens to, and what moves it, follow from the sum itself."""

from __future__ import annotations

import math

import numpy as np
import pytest

from agents import Flock
from agents.bodies import constant_speed, point_mass
from agents.catalogue import MODELS
from agents.engine.block import Decision, adjacent
from agents.models.declare import Parameters, Rule, parameter
from agents.models.model import Model
from agents.rules.terms.sums import mean_heading, sum_of
from agents.rules.vicsek import Vicsek
from worlds.compilation import compiled

START = {
    "position": [[1.0, 1.0], [1.4, 1.0], [1.0, 1.8], [5.0, 5.0]],
    "heading": [[1.0, 0.0], [0.0, 1.0], [-0.6, 0.8], [1.0, 0.0]],
}


@compiled
def fading(me, near, j, p):
    """exp(-d) for neighbours."""
    dx, dy = near.x[j] - me.x, near.y[j] - me.y
    return adjacent(me, near, j, p.r) * math.exp(-math.sqrt(dx * dx + dy * dy))


class Springs(Parameters):
    """Stiffness and friction."""

    r: float = parameter(1.0, "Reach", symbol="r", source="none", low=0.1, high=2.0)
    k: float = parameter(3.0, "Stiffness", symbol="k", source="none", low=0.0, high=9.0)
    c: float = parameter(0.5, "Friction", symbol="c", source="none", low=0.0, high=9.0)


@compiled
def pull(me, near, j, p):
    """k (x_j - x_i)."""
    h = p.k * adjacent(me, near, j, p.r)
    return Decision(h * (near.x[j] - me.x), h * (near.y[j] - me.y), h * (near.z[j] - me.z))


@compiled
def likeness(me, near, j, p):
    """c (u_j - u_i)."""
    h = p.c * adjacent(me, near, j, p.r)
    return Decision(h * (near.ux[j] - me.ux), h * (near.uy[j] - me.uy), h * (near.uz[j] - me.uz))


@pytest.fixture
def flocks(monkeypatch):
    """A flock of a sum of headings, and one of a sum of forces."""
    words = ("Sum", "A sum.", "x", "none")
    mean = Rule("mean", *words, Vicsek, **mean_heading(fading))
    force = Rule("springs", *words, Springs, **sum_of(pull=pull, likeness_of_heading=likeness))
    monkeypatch.setitem(MODELS, "mean", Model(mean, constant_speed.BODY))
    monkeypatch.setitem(MODELS, "springs", Model(force, point_mass.BODY))

    def made(name, interpret):
        return Flock(name, start=START, world="open", rng=1, interpret=interpret)

    return made


@pytest.mark.parametrize("interpret", [False, True])
def test_weights_follow_from_the_sum_of_headings(flocks, interpret):
    flock = flocks("mean", interpret)
    seen = flock.inspect(0)
    assert seen.neighbours.tolist() == [1, 2]
    assert seen.weights == pytest.approx(np.exp([-0.4, -0.8]))
    flock.run(1)
    expected = np.array([1.0, 0.0]) + seen.weights @ np.array(START["heading"])[[1, 2]]
    assert flock.heading[0] == pytest.approx(expected / np.linalg.norm(expected))


@pytest.mark.parametrize("interpret", [False, True])
def test_forces_follow_from_the_sum_of_forces_and_add_up_to_the_wish(flocks, interpret):
    flock = flocks("springs", interpret)
    forces = flock.inspect(0).forces
    assert forces["pull"] == pytest.approx([3.0 * 0.4, 3.0 * 0.8])
    assert forces["likeness of heading"] == pytest.approx([0.5 * (-1.0 - 1.6), 0.5 * 1.8])
    flock.run(1)
    velocity = flock.speed[0] * flock.heading[0]
    assert velocity == pytest.approx(sum(forces.values()) * flock.parameters.dt)
