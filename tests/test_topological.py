"""Neighbours that are the nearest, whatever their distance: against the oracle, and its facts."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import nearest as oracle
from oracles.scenes import SEED, apart, scenes, unit_vectors
from oracles.topology import distances

from agents import Flock
from agents.observables.neighbours import nearest_links

CLOSE = 1e-9


def flock_of(where, k, **given):
    """A flock of the nearest in a scene, all ordinary agents."""
    start = {"position": where.position, "heading": where.heading}
    given = {"v0": where.v0, "r": where.r, "eta": 0.0, "k": k} | given
    return Flock("topological", start=start, size=where.size, world=where.edges, rng=SEED, **given)


def crowd(n, side, dim=2, seed=4):
    """A random start in a box of some side."""
    rng = np.random.default_rng(seed)
    return {"position": rng.uniform(0, side, (n, dim)), "heading": unit_vectors(rng, n, dim)}


@settings(max_examples=60, deadline=None, derandomize=True)
@given(where=scenes(most=40), k=st.sampled_from((1, 3, 7, 40)))
def test_it_is_the_mean_of_the_nearest_and_itself(where, k):
    flock = flock_of(where, k)
    for _ in range(2):
        before = flock.position.copy(), flock.heading.copy()
        assume(oracle.is_clear(before[0], k, where.size, where.edges))
        total = oracle.means(*before, k, where.size, where.edges)
        length = np.linalg.norm(total, axis=1)
        assume(length.min() > 1e-6)
        flock.step()
        assert apart(flock.heading, total / length[:, None]) < CLOSE


def test_in_turn_each_sees_what_those_before_it_left():
    start = crowd(30, 5.0)
    flock = Flock(
        "topological", start=start, size=5.0, v0=0.4, k=5, eta=0.0, rng=1, activation="sequential"
    )
    position, heading = start["position"].copy(), start["heading"].copy()
    for i in range(30):
        total = oracle.means(position, heading, 5, (5.0, 5.0), "wrap")[i]
        heading[i] = total / np.linalg.norm(total)
        position[i] = np.mod(position[i] + 0.4 * heading[i], 5.0)
    flock.step()
    assert apart(flock.heading, heading) < CLOSE
    assert apart(flock.position, position, np.full(2, 5.0)) < CLOSE


def test_the_nearest_count_however_far_they_are():
    """Three on a line, far beyond r: each end hears the middle, the middle the nearer end."""
    start = {
        "position": [[0.0, 0.0], [900.0, 0.0], [2000.0, 0.0]],
        "heading": [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]],
    }
    flock = Flock("topological", start=start, world="open", size=9.0, k=1, eta=0.0, rng=1)
    flock.step()
    half = 0.5**0.5
    assert flock.heading == pytest.approx(np.array([[half, half], [half, half], [-half, half]]))


def test_of_one_far_from_a_crowd_everybody_is_looked_at():
    """Cells are as wide as the flock's mean density asks: the crowd is far beyond those of one."""
    rng = np.random.default_rng(7)
    position = np.vstack([rng.normal(0.0, 1.0, (200, 2)), [[500.0, 3.0]]])
    start = {"position": position, "heading": unit_vectors(rng, 201, 2)}
    flock = Flock("topological", start=start, world="open", size=9.0, k=4, eta=0.0, rng=1)
    total = oracle.means(position, flock.heading.copy(), 4, (9.0, 9.0), "open")
    flock.step()
    assert apart(flock.heading, total / np.linalg.norm(total, axis=1)[:, None]) < CLOSE


def test_where_a_flock_is_thin_more_rings_of_cells_are_looked_at():
    """Most are in one clump, so that cells are too small for the others, also across the seam."""
    rng = np.random.default_rng(8)
    thin = rng.uniform(0.0, 40.0, (150, 2))
    position = np.vstack([rng.normal(20.0, 1.0, (350, 2)), thin])
    start = {"position": position, "heading": unit_vectors(rng, 500, 2)}
    flock = Flock("topological", start=start, size=40.0, k=7, eta=0.0, rng=1)
    total = oracle.means(flock.position, flock.heading.copy(), 7, (40.0, 40.0), "wrap")
    side = (40.0**2 * 8 / 500) ** 0.5
    apart_ = distances(flock.position, (40.0, 40.0), "wrap")
    seventh = np.sort(apart_, axis=1)[:, 7]
    assert 20 < (seventh > side).sum() < 500, "some look further, and not all"
    flock.step()
    assert apart(flock.heading, total / np.linalg.norm(total, axis=1)[:, None]) < CLOSE


@pytest.mark.parametrize("factor", [0.125, 8.0])
def test_density_makes_no_difference_to_the_bit(factor):
    """All lengths times a power of 2: the same headings, to the bit."""
    made = []
    for f in (1.0, factor):
        start = crowd(60, 4.0)
        start["position"] = f * start["position"]
        flock = Flock("topological", start=start, size=4.0 * f, v0=0.05 * f, eta=0.5, rng=3)
        flock.run(40)
        made.append(flock.heading)
    assert np.array_equal(*made)


def test_all_within_reach_is_the_other_choice_and_may_be_made_while_it_runs():
    start = crowd(80, 4.0)
    metric, vem = (
        Flock(model, start=start, size=4.0, eta=0.3, rng=2, **given)
        for model, given in (("topological", {"neighbours": "metric"}), ("vem", {}))
    )
    for flock in (metric, vem):
        flock.run(10)
    assert np.array_equal(metric.heading, vem.heading)
    vem.set(neighbours="nearest", k=3)
    metric.set(neighbours="nearest", k=3)
    again = Flock("vem", start={"position": vem.position.copy(), "heading": vem.heading.copy()},
                  size=4.0, eta=0.0, rng=2, neighbours="nearest", k=3)  # fmt: skip
    vem.set(eta=0.0)
    for flock in (vem, again):
        flock.run(5)
    assert apart(vem.heading, again.heading) < CLOSE  # given headings are normalised again
    assert not np.array_equal(vem.heading, metric.heading)


def test_two_threads_give_the_same_bits():
    made = [Flock("topological", agents=300, eta=0.4, rng=5, threads=n) for n in (1, 2)]
    for flock in made:
        flock.split_from = 1
        flock.run(15)
    assert np.array_equal(made[0].position, made[1].position)


@pytest.mark.parametrize("edges", ["wrap", "open"])
def test_links_and_the_inspected_agent_are_those_of_the_oracle(edges):
    start = crowd(50, 6.0)
    flock = Flock("topological", start=start, size=6.0, world=edges, k=4, rng=1)
    rows = oracle.nearest(flock.position, 4, (6.0, 6.0), edges)
    pairs = {tuple(sorted((i, j))) for i in range(50) for j in rows[i]}
    assert {tuple(pair) for pair in flock.links().tolist()} == pairs
    for row in (0, 17):
        assert flock.inspect(row).neighbours.tolist() == sorted(rows[row])


def test_those_in_one_spot_are_nobodys_nearest():
    position = np.array([[0.0, 0.0]] * 5 + [[1.0, 0.0]])
    for k in (1, 5, 9):
        found = nearest_links(position, k, (9.0, 9.0), (False, False)).tolist()
        assert [pair for pair in found if 5 not in pair] == []
        assert len(found) == 5, "all five have the sixth, which has them or one of them"


def test_couzins_zones_of_the_nearest():
    """Those too near repel, the rest align or attract, however far: the zone of attraction ends
    nowhere."""
    start = crowd(40, 30.0)
    flock = Flock(
        "couzin", start=start, world="open", size=30.0, dim=2, rng=1, neighbours="nearest", k=3,
        alpha=360.0, sigma=0.0, theta=1800.0, tau=0.2, s=1.0, r_r=2.0, dr_o=3.0, dr_a=0.5,
    )  # fmt: skip
    rows = oracle.nearest(start["position"], 3, (30.0, 30.0), "open")
    expected = []
    for i, near in enumerate(rows):
        apart_ = start["position"][near] - start["position"][i]
        distance = np.linalg.norm(apart_, axis=1)
        close = distance < 2.0
        unit = apart_ / distance[:, None]
        aligned = np.where((distance < 5.0)[:, None], start["heading"][near], unit)
        total = -unit[close].sum(axis=0) if close.any() else aligned.sum(axis=0)
        expected.append(total / np.linalg.norm(total))
    flock.step()
    assert apart(flock.heading, np.array(expected)) < CLOSE


def test_what_is_no_choice_is_one_line():
    with pytest.raises(ValueError, match="neighbours = 'all' is not allowed: it must be one of"):
        Flock("vem", agents=3, rng=1, neighbours="all")
    with pytest.raises(ValueError, match=r"k = 0 is outside \[1, 100\]"):
        Flock("couzin", agents=3, rng=1, k=0)
    with pytest.raises(ValueError, match="unknown parameter 'neighbours'"):
        Flock("hwvem", agents=3, rng=1, neighbours="nearest")
