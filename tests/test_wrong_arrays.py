"""Arrays that are not as described are refused in one line; nobody at all has a value."""

import math

import numpy as np
import pytest

from agents.catalogue import model
from agents.observables import (
    consistency,
    correlation,
    energy,
    following,
    formation,
    groups,
    neighbours,
    order,
)
from agents.observables.neighbours import groups_within
from tests.left_out import quietly
from worlds.input_error import InputError

P = model("boundary-points").parameters()
U = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])
X = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 1.0]])
BOX = np.array([10.0, 10.0]), np.zeros(2, bool)
WRONG = {
    "a whole track": (lambda: order.polarisation(np.ones((5, 3, 2))), r"heading has shape \(5, 3"),
    "angles": (lambda: order.polarisation(np.ones(3)), r"heading has shape \(3,\)"),
    "four axes": (lambda: order.polarisation(np.ones((3, 4))), r"heading has shape \(3, 4\)"),
    "velocities": (lambda: order.polarisation(2.0 * U), "heading has a row of length 2"),
    "who stands": (lambda: order.polarisation(0.0 * U), "heading has a row of length 0"),
    "one of zeros": (
        lambda: order.angular_momentum(X, U * [[1.0], [0.0], [1.0]], *BOX),
        "length 0: unit vectors are needed, or nan",
    ),
    "objects": (lambda: order.polarisation(U.astype(object)), "heading holds object values"),
    "complex": (lambda: order.polarisation(U + 1j), "heading holds complex128 values"),
    "words": (lambda: order.polarisation([["a", "b"]]), "heading holds <U1 values"),
    "ragged": (lambda: order.polarisation([[1.0], [1.0, 2.0]]), "rows have different lengths"),
    "nothing": (lambda: order.polarisation(None), "heading holds object values"),
    "lengths": (
        lambda: order.angular_momentum(X[:2], U, *BOX),
        "rows: position 2, heading 3",
    ),
    "axes": (
        lambda: order.angular_momentum(np.ones((3, 3)), U, np.ones(3), np.zeros(3, bool)),
        r"shapes: position \(3, 3\), heading \(3, 2\)",
    ),
    "a box of zero": (lambda: order.centre(X, [10.0, 0.0], BOX[1]), r"size = \[10.0, 0.0\]"),
    "a box of nan": (lambda: groups_within(X, 1.0, [math.nan] * 2, BOX[1]), "size = "),
    "a box of three": (lambda: neighbours.links(X, 1.0, np.ones(3), BOX[1]), r"size has shape \(3"),
    "a box of one number": (lambda: neighbours.links(X, 1.0, 10.0, BOX[1]), r"size has shape \(\)"),
    "images of floats": (lambda: neighbours.links(X, 1.0, BOX[0], [0.0, 1.0]), "images has shape"),
    "reach nan": (lambda: neighbours.links(X, math.nan, *BOX), "r = nan"),
    "reach below 0": (lambda: neighbours.mean_neighbours(X, -1.0, *BOX), "r = -1.0"),
    "reach infinite": (lambda: groups_within(X, math.inf, *BOX), "r = inf"),
    "width": (lambda: correlation.correlation(X, U, *BOX, width=0.0), "width = 0.0"),
    "labels of floats": (lambda: groups.polarisations([0.0, 1.0, 1.0], U), "labels holds float"),
    "labels below -1": (lambda: groups.group_sizes([0, -2]), "labels holds -2"),
    "labels too few": (lambda: groups.polarisations([0, 1], U), "rows: labels 2, heading 3"),
    "links beyond": (lambda: groups.group_labels(3, [[0, 3]]), "links holds 3"),
    "links of three": (lambda: groups.group_labels(3, [[0, 1, 2]]), r"links have shape \(1, 3\)"),
    "informed": (lambda: neighbours.layers([[0, 1]], [0.0, 1.0]), "informed holds float64 values"),
    "layers": (lambda: neighbours.layer_histogram([1.5, 2.0]), "layer holds float64 values"),
    "reference zero": (lambda: consistency.consistency(U, [0.0, 0.0]), r"reference = \[0.0, 0.0\]"),
    "reference nan": (lambda: consistency.consistency(U, math.nan), r"reference = \[nan\]"),
    "reference of three": (
        lambda: consistency.consistency(U, [1.0, 0.0, 0.0]),
        "reference has 3 axes and heading 2",
    ),
    "degrees": (lambda: consistency.convergence_time(np.ones((2, 2))), "degrees has shape"),
    "series": (lambda: order.binder(np.ones((2, 2))), "series has shape"),
    "agents": (lambda: order.susceptibility([0.5], -1), "n = -1"),
    "goal": (lambda: energy.hamiltonian(X, U, [[0.0, 0.0]], [], P), "goal = "),
    "points": (
        lambda: energy.hamiltonian(X, U, np.zeros((2, 2)), np.ones((1, 3)), P),
        "points have 3 axes",
    ),
    "energy": (lambda: energy.furthest(-1.0, P), "energy = -1.0"),
    "places": (lambda: neighbours.separation(X, np.ones((2, 2)), *BOX), "do not match"),
    "upwash": (lambda: formation.upwash_share([1, 2], [1, 2, 3]), "do not match"),
    "flock of one number": (lambda: formation.saved_shares(X[0], U[0], 1.0), "position has shape"),
    "trace": (lambda: following.nearest_pairs(X, np.zeros((2, 2))), "trace has shape"),
    "least2": (
        lambda: following.nearest_pairs(np.zeros((1, 2, 3)), np.zeros((2, 2))),
        r"least2 is float64 \(2, 2\): an array float \(3, 3\) is needed",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_not_as_described_is_refused_in_one_line(name):
    call, words = WRONG[name]
    with pytest.raises(InputError, match=words) as said:
        quietly(call)
    assert "\n" not in str(said.value)


@pytest.mark.parametrize("empty", [[], np.empty((0, 2)), np.empty((0, 3))])
def test_nobody_has_a_value_and_no_warning(empty):
    dim = np.shape(empty)[-1] or 2
    box = np.ones(dim), np.ones(dim, bool)
    found = {
        "polarisation": quietly(order.polarisation, empty)[0],
        "consistency": quietly(consistency.consistency, empty)[0],
        "momentum": quietly(order.angular_momentum, empty, empty, *box)[0],
        "neighbours": quietly(neighbours.mean_neighbours, empty, 1.0, *box)[0],
        "links": len(quietly(neighbours.links, empty, 1.0, *box)[0]),
        "groups": len(quietly(groups_within, empty, 1.0, *box)[0]),
    }
    assert list(found.values()) == [0.0, 1.0, 0.0, 0.0, 0, 0]
    assert np.isnan(quietly(order.centre, empty, *box)[0]).all()
    assert math.isnan(quietly(correlation.correlation_length, empty, empty, *box)[0])
