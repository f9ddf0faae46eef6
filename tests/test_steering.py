"""Check agents that are steered from outside: they do what they are told within their limits."""

from __future__ import annotations

import numpy as np
import pytest

from agents.flock import Flock
from agents.kinds import Kind
from agents.spec import Spec
from worlds.input_error import InputError


def steered(model="vem", **parameters):
    """A flock with three steered agents, without noise."""
    robots = Kind("robot", 3, steered=True)
    return Flock(Spec(model, agents=20, seed=2, kinds=[robots], parameters=parameters))


@pytest.mark.parametrize("activation", ["synchronous", "random"])
@pytest.mark.parametrize("interpret", [False, True])
def test_a_heading_that_is_wished_is_taken(activation, interpret):
    robots = Kind("robot", 3, steered=True)
    spec = Spec("vem", agents=20, seed=2, kinds=[robots], activation=activation)
    flock = Flock(spec.taking(eta=0.0), interpret=interpret)
    wishes = np.array([[1.0, 0.0], [0.0, -1.0], [0.6, 0.8]])
    flock.steer("robot", wishes)
    flock.run(2)
    assert np.allclose(flock.heading[flock.rows_of("robot")], wishes)


def test_a_body_keeps_to_its_limits():
    flock = steered("couzin", sigma=0.0)
    rows = flock.rows_of("robot")
    before = flock.heading[rows].copy()
    flock.steer("robot", -before)
    flock.run(1)
    turned = np.arccos(np.clip((before * flock.heading[rows]).sum(axis=1), -1.0, 1.0))
    assert np.allclose(turned, np.radians(flock.parameters.theta) * flock.parameters.tau)


def test_an_acceleration_is_one_too():
    flock = steered("dorsogna")
    rows = flock.rows_of("robot")
    flock.steer("robot", np.zeros((3, 2)))
    other = steered("dorsogna")
    flock.run(1)
    other.run(1)
    ordinary = np.setdiff1d(np.arange(23), rows)
    assert np.array_equal(flock.position[ordinary], other.position[ordinary])
    assert not np.array_equal(flock.heading[rows], other.heading[rows])


def test_who_is_told_nothing_follows_its_rule():
    flock, free = steered(eta=0.0), steered(eta=0.0)
    flock.steer("robot", np.full((3, 2), np.nan))
    flock.run(10)
    free.run(10)
    assert np.array_equal(flock.position, free.position)


def test_a_saved_flock_is_told_anew(tmp_path):
    flock = steered(eta=0.0)
    flock.steer("robot", [[1.0, 0.0]] * 3)
    flock.run(1)
    flock.save(tmp_path / "state.parquet")
    again = Flock.load(tmp_path / "state.parquet")
    again.steer("robot", [[1.0, 0.0]] * 3)
    again.run(3)
    flock.run(3)
    assert np.array_equal(flock.position, again.position)


@pytest.mark.parametrize(
    ("kind", "wishes", "message"),
    [
        ("robot", [[1.0, 0.0]], r"shape \(1, 2\): \(3, 2\) is needed"),
        ("robot", [["left", 0.0]] * 3, r"\(3, 2\) is needed"),
        ("robot", [[np.inf, 0.0]] * 3, "not all finite numbers"),
        ("flock", np.zeros((20, 2)), "agents of kind flock are not steered"),
        ("robott", np.zeros((3, 2)), "unknown kind 'robott'"),
    ],
)
def test_a_wish_that_is_none_is_refused(kind, wishes, message):
    flock = steered()
    with pytest.raises(InputError, match=message):
        flock.steer(kind, wishes)
    assert np.isnan(flock.arrays.wish).all()
