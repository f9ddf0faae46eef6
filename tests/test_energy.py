"""The energy of a flock of Wu et al. 2023: exact cases, and theorem 1."""

import math

import numpy as np
import pytest
from oracles.goal_scenes import GoalScene, velocity_of

from agents.catalogue import MODELS
from agents.observables.energy import furthest, hamiltonian, potential, urgency

MODEL = MODELS["boundary-points"]


def test_the_potential_is_nothing_at_d_and_constant_beyond_r():
    p = MODEL.parameters()
    at = potential([4.0, 0.0, 2.0, 5.0, 6.0, 9.0], p)
    assert at[0] == pytest.approx(0.0, abs=1e-12)
    assert at[1] > at[2] > 0.0
    assert 0.0 < at[3] < at[4]
    assert at[4] == pytest.approx(at[5], abs=1e-12)


def test_without_a_bump_the_potential_has_a_closed_form():
    """phi is integrated by hand; h near 1 leaves the bump out for all but the last bit of r."""
    p = MODEL.parameters(h=0.99, r=30.0)
    c = 18.0 / math.sqrt(160.0)

    def primitive(s):
        return 0.5 * (22.0 * math.sqrt(1.0 + (s - 4.0 + c) ** 2) - 18.0 * s)

    for distance in (0.0, 1.0, 6.0, 20.0):
        s = 2.0 * (math.sqrt(1.0 + 0.5 * distance**2) - 1.0)
        expected = primitive(s) - primitive(4.0)
        assert potential(distance, p)[0] == pytest.approx(expected, rel=1e-11, abs=1e-11)


def test_the_energy_of_a_few_agents_by_hand():
    p = MODEL.parameters()
    goal = [[0.0, 0.0], [0.0, 0.0]]
    pair = [[-2.0, 0.0], [2.0, 0.0]]
    rest = np.zeros((2, 2))
    assert hamiltonian(pair, rest, goal, [], p) == pytest.approx(4.0, abs=1e-9)
    assert hamiltonian(pair, rest + 1.0, goal, [], p) == pytest.approx(6.0, abs=1e-9)
    near = potential(3.0, p)[0]
    assert hamiltonian([[0.0, 0.0]], rest[:1], goal, [[3.0, 0.0]], p) == pytest.approx(10.0 * near)
    close = [[-1.5, 0.0], [1.5, 0.0]]
    assert hamiltonian(close, rest, goal, [], p) == pytest.approx(2.25 + 10.0 * near)
    assert urgency([1.0, 3.0, 5.0], p).tolist() == [1e4, 10.0, 0.1]


def test_energy_falls_and_bounds_the_distance_to_the_goal():
    """Theorem 1 where it holds: no obstacles, and nobody nearer than d_e, where eta jumps."""
    goal = np.array([[3.0, 3.0], [0.0, 0.0]])
    position = np.array([[0.0, 0.0], [4.2, 0.0], [0.0, 4.2], [4.2, 4.2]])
    flock = GoalScene(position, np.zeros((4, 2)), (), goal).flock("boundary-points", n_sub=100.0)
    p = flock.parameters
    energy = [hamiltonian(flock.position, velocity_of(flock), goal, [], p)]
    bound = furthest(energy[0], p)
    for _ in range(100):
        flock.run(20)
        energy.append(hamiltonian(flock.position, velocity_of(flock), goal, [], p))
        assert np.linalg.norm(flock.position - goal[0], axis=1).max() <= bound
    assert (np.diff(energy) < 1e-3 * energy[0]).all()
    assert energy[-1] < 0.9 * energy[0]
