"""The oracles of the observables against cases small enough to work out by hand."""

import math

import numpy as np
import pytest

from oracles import observables
from oracles import vicsek_family as family

BOX = np.array([10.0, 10.0])


def headings(*angles):
    """Unit vectors (N, 2) at the given angles (rad)."""
    return np.array([family.unit(a) for a in angles])


def test_polarisation():
    assert observables.polarisation(headings(1, 1, 1)) == pytest.approx(1)
    assert observables.polarisation(headings(0, math.pi / 2)) == pytest.approx(math.sqrt(0.5))
    assert observables.polarisation(headings(0, math.pi)) == pytest.approx(0, abs=1e-15)


def test_direction():
    assert observables.direction(headings(0.5, -0.5)) == pytest.approx(0)
    assert observables.direction(headings(-2.0)) == pytest.approx(math.degrees(2.0))
    assert observables.direction(np.eye(3)) == pytest.approx(math.degrees(math.acos(3**-0.5)))


def test_fast_in_front():
    velocity = np.array([[1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])
    offset = np.array([[-1.0, 5.0], [0.0, -5.0], [1.0, 0.0]])
    assert observables.fast_in_front(offset, velocity) == 1.0
    assert observables.fast_in_front(-offset, velocity) == -1.0
    assert observables.fast_in_front(offset[[1, 0, 2]], velocity) == 0.5


def test_consistency():
    assert observables.consistency([0.3, 0.3], 0.3) == 1
    assert observables.consistency([0, math.pi / 2], 0.0) == pytest.approx(0.75)
    assert observables.consistency([math.pi] * 4, 0.0) == pytest.approx(0.5)
    across = observables.consistency([0.1], math.tau - 0.1)
    assert across == pytest.approx(1 - 0.2 / math.pi), "differences wrap"
    assert observables.wrapped(-math.pi) == math.pi
    assert observables.wrapped(3 * math.pi) == pytest.approx(math.pi)


def test_consistency_of_headings_is_that_of_their_angles():
    theta = np.random.default_rng(1).uniform(0, math.tau, 30)
    expected = observables.consistency(theta, 0.8)
    got = observables.consistency_of_headings(headings(*theta), family.unit(0.8))
    assert got == pytest.approx(expected, abs=1e-14)
    east_and_up = np.array([[1.0, 0, 0], [0, 0, 1.0]])
    assert observables.consistency_of_headings(east_and_up, [1.0, 0, 0]) == pytest.approx(0.75)


def test_convergence_time():
    assert observables.convergence_time([0.5, 0.9, 0.9984, 1.0]) == 2
    assert observables.convergence_time([0.5, 0.9985, 0.99, 1.0]) == 3
    assert observables.convergence_time([1.0, 1.0]) == 0
    assert observables.convergence_time([1.0, 0.5]) is None


def test_nearest_neighbour_distance():
    x = np.array([[0.5, 5.0], [9.5, 5.0], [4.5, 5.0]])
    near = observables.nearest_neighbour_distance
    assert near(x, BOX, "wrap") == pytest.approx([1, 1, 4])
    assert near(x, BOX, "wrap-plain") == pytest.approx([4, 5, 4])
    assert near(x[:1], BOX, "open").tolist() == [math.inf]
    assert near(np.ones((2, 2)), BOX, "open").tolist() == [0, 0]


def chain(n):
    """Contacts of n agents in a line."""
    gap = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    return gap == 1


def test_groups():
    touch = np.zeros((6, 6), bool)
    for i, j in [(0, 3), (3, 4), (1, 5)]:
        touch[i, j] = touch[j, i] = True
    label, sizes = observables.groups(touch)
    assert label.tolist() == [0, 1, 2, 0, 0, 1]
    assert sizes == [3, 2, 1]
    assert observables.largest_group(touch) == 3
    assert observables.mean_neighbours(touch) == pytest.approx(1.0)


def test_algebraic_connectivity():
    assert observables.algebraic_connectivity(chain(2)) == pytest.approx(2)
    assert observables.algebraic_connectivity(chain(3)) == pytest.approx(1)
    path = 2 * (1 - math.cos(math.pi / 7))  # Fiedler 1973, for the path of 7
    assert observables.algebraic_connectivity(chain(7)) == pytest.approx(path)
    complete = ~np.eye(5, dtype=bool)
    assert observables.algebraic_connectivity(complete) == pytest.approx(5)
    assert observables.algebraic_connectivity(np.zeros((3, 3), bool)) == pytest.approx(0)
    assert observables.algebraic_connectivity(np.zeros((1, 1), bool)) == 0


def test_layer_histogram():
    assert observables.layer_histogram(np.array([1, 2, 2, 5])).tolist() == [1, 2, 0, 0, 1]
