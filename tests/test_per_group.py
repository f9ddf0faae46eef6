"""Order within each group: exact cases, and the functions of a whole flock group by group."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import observables as naive
from oracles import order_over_groups
from oracles.scenes import scenes
from test_rotation import mill

from agents import Flock
from agents.observables import neighbours
from agents.observables.groups import (
    angular_momenta,
    centres,
    group_labels,
    group_table,
    polarisations,
    size_histogram,
)
from agents.observables.order import angular_momentum, centre, polarisation

SIZE, OPEN = np.array([40.0, 40.0]), np.zeros(2, bool)


def a_mill_and_a_column():
    """12 that mill, one alone, and 4 that fly east in line."""
    position, heading = mill(12, centre_at=(10.0, 10.0))
    column = np.array([[30.0, 30.0], [31.0, 30.0], [32.0, 30.0], [33.0, 30.0]])
    east = np.tile([1.0, 0.0], (4, 1))
    return (
        np.concatenate([position, [[3.0, 35.0]], column]),
        np.concatenate([heading, [[0.0, 1.0]], east]),
        np.repeat([0, 2, 1], [12, 1, 4]),
    )


def test_a_mill_and_a_column_are_told_apart():
    position, heading, label = a_mill_and_a_column()
    assert polarisations(label, heading) == pytest.approx([0.0, 1.0, 1.0], abs=1e-12)
    found = angular_momenta(label, position, heading, SIZE, OPEN)
    assert found == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    assert centres(label, position, SIZE, OPEN) == pytest.approx(
        np.array([[10.0, 10.0], [31.5, 30.0], [3.0, 35.0]])
    )
    assert size_histogram(label) == {12: 1, 4: 1, 1: 1}


def test_a_flock_observes_its_groups():
    position, heading, _ = a_mill_and_a_column()
    start = {"position": position, "heading": heading}
    flock = Flock("vem", start=start, size=40.0, rng=1, r=1.5)
    assert flock.observe("groups") == 3
    assert flock.observe("group-polarisation") == pytest.approx(0.0, abs=1e-12)
    assert flock.observe("group-angular-momentum") == pytest.approx(1.0)
    assert flock.observe("group-sizes") == {12: 1, 4: 1, 1: 1}
    table = flock.observe("group-table")
    assert [row["agents"] for row in table.values()] == [12, 4, 1]
    assert [row["polarisation"] for row in table.values()] == pytest.approx([0, 1, 1], abs=1e-12)
    assert [row["angular-momentum"] for row in table.values()] == pytest.approx(
        [1, 0, 0], abs=1e-12
    )


def test_a_mill_across_the_seam_is_the_same_mill():
    images = np.ones(2, bool)
    position, heading = mill(12, centre_at=(0.2, 39.5))
    label = np.zeros(12, int)
    found = angular_momenta(label, position % SIZE, heading, SIZE, images)
    assert found == pytest.approx([1.0])
    assert centres(label, position % SIZE, SIZE, images)[0] == pytest.approx([0.2, 39.5])


def test_nobody_has_no_groups():
    none, empty = np.empty(0, int), np.empty((0, 2))
    assert polarisations(none, empty).tolist() == []
    assert angular_momenta(none, empty, empty, SIZE, OPEN).tolist() == []
    assert size_histogram(none) == {}
    assert group_table(none, empty, empty, SIZE, OPEN) == {}


@settings(max_examples=100, deadline=None, derandomize=True)
@given(where=scenes())
def test_each_group_is_measured_as_if_it_were_alone(where):
    size, images = np.array(where.size), np.full(where.dim, where.edges == "wrap")
    links = neighbours.links(where.position, where.r, size, images)
    label = group_labels(len(where.position), links)
    phi = polarisations(label, where.heading)
    momentum = angular_momenta(label, where.position, where.heading, size, images)
    middle = centres(label, where.position, size, images)
    rows = order_over_groups.groups_of(label.tolist())
    assert len(rows) == len(phi) == len(momentum)
    for k, group in enumerate(rows):
        x, u = where.position[group], where.heading[group]
        assert phi[k] == pytest.approx(order_over_groups.length_of_mean(u.tolist()), abs=1e-12)
        assert phi[k] == pytest.approx(naive.polarisation(u), abs=1e-12)
        apart = np.abs(middle[k] - centre(x, size, images))
        assert np.minimum(apart, size - apart * images) == pytest.approx(0.0, abs=1e-6)
        if len(group) == 1:
            assert momentum[k] == 0.0
        elif np.ptp(x, axis=0).max() > 1e-6 * size.max():
            expected = angular_momentum(x, u, size, images)
            assert momentum[k] == pytest.approx(expected, abs=1e-6)
    histogram = size_histogram(label)
    assert sum(n * count for n, count in histogram.items()) == len(label)
    assert sum(histogram.values()) == len(rows)
    assert list(histogram) == sorted(histogram, reverse=True)
    assert histogram == {n: [len(g) for g in rows].count(n) for n in histogram}


@settings(max_examples=50, deadline=None, derandomize=True)
@given(n=st.integers(1, 40), seed=st.integers(0, 999))
def test_one_group_is_the_whole_flock(n, seed):
    rng = np.random.default_rng(seed)
    position, heading = rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    label, size, images = np.zeros(n, int), np.ones(3), np.zeros(3, bool)
    assert polarisations(label, heading)[0] == pytest.approx(polarisation(heading))
    found = angular_momenta(label, position, heading, size, images)[0]
    expected = angular_momentum(position, heading, size, images) if n > 1 else 0.0
    assert found == pytest.approx(expected, abs=1e-12)
    assert not math.isnan(found)
