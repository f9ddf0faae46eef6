"""Every observable: an exact case by hand in `tests/oracles`, and here the naive version."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import observables as naive
from oracles import topology
from oracles import vicsek_family as family
from oracles.flocks import at_rest, build
from oracles.scenes import contacts_are_clear, scene, scenes, unit_vectors
from oracles.topology import EDGES
from scipy.sparse.csgraph import laplacian

from agents import Flock
from agents.observables import consistency, groups, neighbours, order

SOME = settings(max_examples=100, deadline=None, derandomize=True)


def images(where):
    """Axes along which distances cross the border, (dim,) bool."""
    return np.full(where.dim, where.edges == "wrap")


def touch_of(where):
    """The naive contacts of a scene, whose pairs all are clearly in or out of reach."""
    assume(contacts_are_clear(where.position, where.r, where.size, where.edges))
    return topology.contact(where.position, where.r, where.size, where.edges)


def pairs(touch):
    """Rows (i < j) in contact, (M, 2), sorted."""
    return np.argwhere(np.triu(touch)).reshape(-1, 2)


def links_of(where):
    return neighbours.links(where.position, where.r, np.array(where.size), images(where))


# --- headings ---------------------------------------------------------------------------------


@SOME
@given(n=st.integers(1, 60), dim=st.sampled_from((2, 3)), seed=st.integers(0, 999))
def test_polarisation(n, dim, seed):
    heading = unit_vectors(np.random.default_rng(seed), n, dim)
    assert order.polarisation(heading) == pytest.approx(naive.polarisation(heading), abs=1e-14)


@SOME
@given(n=st.integers(1, 60), dim=st.sampled_from((2, 3)), seed=st.integers(0, 999))
def test_direction(n, dim, seed):
    heading = unit_vectors(np.random.default_rng(seed), n, dim)
    assume(np.linalg.norm(heading.mean(axis=0)) > 1e-3)
    assert order.direction(heading) == pytest.approx(naive.direction(heading), abs=1e-5)


def test_headings_that_cancel_have_no_direction():
    assert math.isnan(order.direction(np.array([[0.6, 0.8], [-0.6, -0.8]])))
    assert order.direction(np.array([[0.0, -1.0]])) == 90.0


@SOME
@given(n=st.integers(3, 40), dim=st.sampled_from((2, 3)), seed=st.integers(0, 999))
def test_fast_in_front(n, dim, seed):
    rng = np.random.default_rng(seed)
    position = rng.uniform(0.0, 9.0, (n, dim))
    velocity = unit_vectors(rng, n, dim) * rng.uniform(0.5, 2.0, (n, 1))
    expected = naive.fast_in_front(position - position.mean(axis=0), velocity)
    size, open_space = np.full(dim, 9.0), np.zeros(dim, bool)
    found = order.fast_in_front(position, velocity, size, open_space)
    assert found == pytest.approx(expected, abs=1e-11)
    # A group across the edge of a torus is where it is without one.
    small = 0.3 * position
    wrapped = (small + 8.0) % 9.0
    found = order.fast_in_front(small, velocity, size, open_space)
    torus = order.fast_in_front(wrapped, velocity, size, np.ones(dim, bool))
    assert torus == pytest.approx(found, abs=1e-11)


def test_who_are_equally_fast_are_in_no_order():
    position, size, wraps = np.arange(8.0).reshape(4, 2), np.ones(2), np.zeros(2, bool)
    heading = unit_vectors(np.random.default_rng(1), 4, 2)
    assert math.isnan(order.fast_in_front(position, 0.3 * heading, size, wraps))
    east = np.array([[1.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 0.0]])
    assert order.fast_in_front(position, east, size, wraps) == pytest.approx(0.8**0.5)
    assert math.isnan(order.fast_in_front(position[:2], east[1:3], size, wraps))


@SOME
@given(
    n=st.integers(1, 60),
    seed=st.integers(0, 999),
    reference=st.floats(-7, 7),
    spread=st.sampled_from((1e-8, 1e-3, 1.0, 10.0)),
)
def test_consistency_with_an_angle(n, seed, reference, spread):
    theta = reference + spread * np.random.default_rng(seed).normal(size=n)
    heading = np.array([family.unit(t) for t in theta])
    got = consistency.consistency(heading, reference)
    assert got == pytest.approx(naive.consistency(theta, reference), abs=1e-13)


@SOME
@given(n=st.integers(1, 60), dim=st.sampled_from((2, 3)), seed=st.integers(0, 999))
def test_consistency_with_a_vector_and_with_the_mean(n, dim, seed):
    rng = np.random.default_rng(seed)
    heading, (reference,) = unit_vectors(rng, n, dim), unit_vectors(rng, 1, dim)
    expected = naive.consistency_of_headings(heading, reference)
    assert consistency.consistency(heading, reference) == pytest.approx(expected, abs=1e-13)
    assert consistency.consistency(heading, 3 * reference) == pytest.approx(expected, abs=1e-13)
    mean = heading.mean(axis=0)
    assume(np.linalg.norm(mean) > 1e-6)
    expected = naive.consistency_of_headings(heading, mean / np.linalg.norm(mean))
    assert consistency.consistency(heading) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("dim", [2, 3])
def test_consistency_of_exact_cases(dim):
    east = np.eye(dim)[0]
    assert consistency.consistency(np.tile(east, (5, 1)), east) == 1.0
    assert consistency.consistency(np.tile(-east, (4, 1)), east) == pytest.approx(0.5, abs=1e-15)
    assert consistency.consistency(np.eye(dim)[:2], east) == pytest.approx(0.75, abs=1e-15)


@SOME
@given(st.lists(st.sampled_from((0.2, 0.9983, 0.9984, 0.9985, 1.0)), min_size=1, max_size=12))
def test_convergence_time(degrees):
    assert consistency.convergence_time(degrees) == naive.convergence_time(degrees)


@pytest.mark.parametrize("model", ["vem", "hwvem"])
@pytest.mark.parametrize("seed", range(4))
def test_a_run_finds_its_convergence_time(model, seed):
    """The compiled search for k_con against the series that a run tick by tick gives."""
    where = scene(np.random.default_rng(seed), 40, 2, "wrap-plain", box=3.0, v0=0.03)
    degrees = []
    flock = build(model, where, eta=0.0)
    mask = flock.informed.astype(bool)
    for _ in range(400):
        reference = flock.heading[mask][0] if model == "hwvem" else flock.heading.mean(axis=0)
        reference = reference / np.linalg.norm(reference)
        degrees.append(naive.consistency_of_headings(flock.heading, reference))
        flock.step()
    k_con = naive.convergence_time(degrees)
    found = build(model, where, eta=0.0).run_until_consistent(399)
    assert found == (k_con if k_con is not None and k_con + 60 <= 399 else None)


# --- positions --------------------------------------------------------------------------------


@SOME
@given(where=scenes())
def test_links_and_what_follows_from_them(where):
    touch = touch_of(where)
    links = links_of(where)
    assert np.array_equal(links, pairs(touch))

    label, sizes = naive.groups(touch)
    ranked = sorted(range(len(sizes)), key=lambda g: (-sizes[g], list(label).index(g)))
    labels = groups.group_labels(len(touch), links)
    assert labels.tolist() == [ranked.index(g) for g in label]
    assert list(groups.group_sizes(labels)) == sorted(sizes, reverse=True)
    unlisted = neighbours.groups_within(
        where.position, where.r, np.array(where.size), images(where)
    )
    assert unlisted.tolist() == labels.tolist()

    fiedler = naive.algebraic_connectivity(touch)
    assert groups.algebraic_connectivity(len(touch), links) == pytest.approx(fiedler, abs=1e-9)

    mean = neighbours.mean_neighbours(where.position, where.r, np.array(where.size), images(where))
    assert mean == pytest.approx(naive.mean_neighbours(touch), abs=1e-12)

    layer = neighbours.layers(links, where.informed)
    assert layer.tolist() == topology.layers(touch, where.informed).tolist()
    counted = naive.layer_histogram(layer)
    assert neighbours.layer_histogram(layer) == {
        k + 1: c for k, c in enumerate(counted.tolist()) if c
    }


@SOME
@given(where=scenes())
def test_nearest_neighbour(where):
    size = np.array(where.size)
    got = neighbours.nearest_neighbour(where.position, size, images(where))
    expected = naive.nearest_neighbour_distance(where.position, size, where.edges)
    assert got == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("edges", EDGES)
@pytest.mark.parametrize("dim", [2, 3])
def test_links_of_lattices(edges, dim):
    """Distances of exactly r, and boxes of 1 and 2 r in which the two images of an agent tie."""
    for size in itertools.product((1, 2, 3, 5) if dim == 2 else (1, 2, 4), repeat=dim):
        x = np.array(list(itertools.product(*[range(s) for s in size])), dtype=float)
        box, wraps = np.array(size, float), np.full(dim, edges == "wrap")
        links = neighbours.links(x, 1.0, box, wraps)
        touch = topology.contact(x, 1.0, size, edges)
        assert np.array_equal(links, pairs(touch))
        mean = neighbours.mean_neighbours(x, 1.0, box, wraps)
        assert mean == pytest.approx(naive.mean_neighbours(touch))
        for r in (1.0, 0.999, math.sqrt(dim)):
            label = neighbours.groups_within(x, r, box, wraps)
            touch = topology.contact(x, r, size, edges)
            assert label.max() + 1 == len(naive.groups(touch)[1])


@pytest.mark.parametrize("n", [0, 1, 2, 5])
def test_agents_on_one_spot_are_groups_of_their_own_until_another_is_near(n):
    box, plain = np.ones(2), np.zeros(2, bool)
    x = np.ones((n, 2))
    assert neighbours.groups_within(x, 1.0, box, plain).tolist() == list(range(n))
    x = np.concatenate([x, [[1.5, 1.0]]])
    assert neighbours.groups_within(x, 1.0, box, plain).tolist() == [0] * (n + 1)
    assert neighbours.groups_within(x, 0.0, box, plain).tolist() == list(range(n + 1))


def test_groups_far_apart_and_crowded_groups_are_found():
    rng = np.random.default_rng(8)
    crowds = [rng.normal(size=(n, 3)) for n in (200, 300, 100)]
    x = np.concatenate([crowds[0], crowds[1] + 1e9, crowds[2] - 1e9])
    label = neighbours.groups_within(x, 8.0, np.ones(3), np.zeros(3, bool))
    assert label.tolist() == [1] * 200 + [0] * 300 + [2] * 100


def test_the_connectivity_of_a_crowd_and_of_a_chain():
    """More agents than the dense method takes: known for a full graph and for a path."""
    n = groups.DENSE_UP_TO + 50
    full = np.argwhere(np.triu(np.ones((n, n)), 1))
    assert groups.algebraic_connectivity(n, full) == pytest.approx(n)
    rows = np.arange(n - 1)
    path = np.c_[rows, rows + 1]
    expected = 2.0 * (1.0 - math.cos(math.pi / n))
    assert groups.algebraic_connectivity(n, path) == pytest.approx(expected, rel=1e-6)


def test_the_connectivity_is_the_same_whichever_way_it_is_found():
    n, box = groups.DENSE_UP_TO + 100, np.full(3, 5.0)
    x = np.random.default_rng(3).uniform(0.0, 5.0, (n, 3))
    links = neighbours.links(x, 1.2, box, np.ones(3, bool))
    matrix = laplacian(groups.graph(n, links).toarray())
    expected = np.linalg.eigvalsh(matrix)[1]
    assert expected > 0.1
    for dim in (2, 3):
        found = groups.algebraic_connectivity(n, links, dim)
        assert found == pytest.approx(expected, rel=1e-8)


def test_nearest_neighbour_of_a_lone_agent_and_of_two_on_one_spot():
    size, plain = np.array([4.0, 4.0]), np.zeros(2, bool)
    assert neighbours.nearest_neighbour(np.ones((1, 2)), size, plain).tolist() == [math.inf]
    assert neighbours.nearest_neighbour(np.ones((2, 2)), size, plain).tolist() == [0, 0]


# --- of a flock -------------------------------------------------------------------------------


@pytest.mark.parametrize("edges", EDGES)
@pytest.mark.parametrize("dim", [2, 3])
def test_observables_of_a_flock(edges, dim):
    where = scene(np.random.default_rng(2), 50, dim, edges, box=4.0)
    flock = build("hwvem", where, eta=0.2)
    flock.run(3)
    touch = topology.contact(flock.position, where.r, where.size, edges)
    sizes = naive.groups(touch)[1]
    reference = flock.heading[where.informed][0]
    nearest = naive.nearest_neighbour_distance(flock.position, where.size, edges)
    counted = naive.layer_histogram(topology.layers(touch, where.informed)).tolist()
    for name, expected in {
        "polarisation": naive.polarisation(flock.heading),
        "consistency": naive.consistency_of_headings(flock.heading, reference),
        "groups": len(sizes),
        "largest-group": max(sizes),
        "mean-neighbours": naive.mean_neighbours(touch),
        "nearest-neighbour": nearest.min(),
        "connectivity": naive.algebraic_connectivity(touch),
        "layers": {k + 1: c for k, c in enumerate(counted) if c},
    }.items():
        assert flock.observe(name) == pytest.approx(expected, abs=1e-9), name


def test_a_flock_without_information_agents_is_measured_against_its_mean():
    flock = at_rest("vem", [[0, 0], [5, 5]], [0.1, 0.3])
    assert flock.observe("consistency") == pytest.approx(naive.consistency([0.1, 0.3], 0.2))


def test_a_flock_that_has_run_already_must_hold_its_consistency_all_the_same():
    flock = Flock("vem", agents=30, size=2.0, rng=1)
    flock.run(300)
    assert flock.observe("consistency") > 0.9984
    assert flock.run_until_consistent(1000, hold=60) == 300
    assert flock.tick == 359
