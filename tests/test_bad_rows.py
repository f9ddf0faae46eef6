"""Arrays that are not perfect: rows that are no numbers are left out and counted, all else refused.

Tracks of animals and cars have gaps. What is measured of them is what is measured without the gaps.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents import Flock
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
from agents.observables.array_checks import OmittedRowsWarning
from agents.observables.neighbours import groups_within
from tests.left_out import quietly

P = model("boundary-points").parameters()
SOME = settings(max_examples=60, deadline=None, derandomize=True)


class Tracks:
    """N agents at one tick: places in a box of 10, headings, velocities, groups."""

    def __init__(self, seed, n, dim, wraps):
        rng = np.random.default_rng(seed)
        self.dim, self.seed = dim, seed
        self.position = rng.uniform(0.0, 10.0, (n, dim))
        self.velocity = rng.normal(size=(n, dim))
        self.heading = self.velocity / np.linalg.norm(self.velocity, axis=1, keepdims=True)
        self.label = rng.integers(0, 3, n)
        self.series = rng.uniform(0.0, 1.0, (n, 1))
        self.box = np.full(dim, 10.0), np.full(dim, wraps)

    def spoilt(self, rows, kind):
        """The same with one number of each of these rows of one array, or of all, spoilt."""
        rng = np.random.default_rng(self.seed)
        made = Tracks.__new__(Tracks)
        made.__dict__.update(self.__dict__)
        for name in ("position", "heading", "velocity", "series"):
            array = getattr(self, name).copy()
            array[rows, rng.integers(0, array.shape[1])] = kind
            setattr(made, name, array)
        return made

    def without(self, rows):
        made = Tracks.__new__(Tracks)
        made.__dict__.update(self.__dict__)
        for name in ("position", "heading", "velocity", "label", "series"):
            setattr(made, name, np.delete(getattr(self, name), rows, axis=0))
        return made


WHOLE = {
    "polarisation": lambda t: order.polarisation(t.heading),
    "consistency": lambda t: consistency.consistency(t.heading),
    "consistency with a vector": lambda t: consistency.consistency(t.heading, np.eye(t.dim)[0]),
    "centre": lambda t: order.centre(t.position, *t.box),
    "angular momentum": lambda t: order.angular_momentum(t.position, t.heading, *t.box),
    "correlation length": lambda t: correlation.correlation_length(t.position, t.velocity, *t.box),
    "correlation": lambda t: correlation.correlation(t.position, t.velocity, *t.box),
    "bin width": lambda t: correlation.bin_width(t.position, *t.box),
    "mean neighbours": lambda t: neighbours.mean_neighbours(t.position, 3.0, *t.box),
    "number of links": lambda t: len(neighbours.links(t.position, 3.0, *t.box)),
    "tree": lambda t: neighbours.tree(t.position, *t.box).data,
    "means": lambda t: groups.means(t.label, t.velocity),
    "polarisations": lambda t: groups.polarisations(t.label, t.heading),
    "centres": lambda t: groups.centres(t.label, t.position, *t.box),
    "angular momenta": lambda t: groups.angular_momenta(t.label, t.position, t.heading, *t.box),
    "group table": lambda t: [
        list(row.values())
        for row in groups.group_table(t.label, t.position, t.heading, *t.box).values()
    ],
    "energy": lambda t: energy.hamiltonian(
        t.position, t.velocity, np.zeros((2, t.dim)), t.position + 0.5, P
    ),
    "gyration radius": lambda t: order.gyration_radius(t.position, *t.box),
    "velocity spread": lambda t: order.velocity_spread(t.velocity),
    "susceptibility": lambda t: order.susceptibility(t.series[:, 0], 30),
    "binder": lambda t: order.binder(t.series[:, 0]),
}
"""One number, or one row for each group, of all agents."""
BY_ROW = {
    "nearest neighbour": (lambda t: neighbours.nearest_neighbour(t.position, *t.box), math.nan),
    "groups": (lambda t: groups_within(t.position, 2.5, *t.box), -1),
    "saved": (lambda t: formation.saved_shares(t.position, t.heading, 2.0, *t.box), math.nan),
}
"""A row for each agent, and what it is for one that is left out."""


cases = {
    "seed": st.integers(0, 999),
    "n": st.integers(0, 25),
    "dim": st.sampled_from((2, 3)),
    "wraps": st.booleans(),
    "kind": st.sampled_from((math.nan, math.inf, -math.inf)),
    "data": st.data(),
}


def bad_rows(data, n):
    return sorted(data.draw(st.sets(st.integers(0, max(0, n - 1)), max_size=n)))


@pytest.mark.parametrize("name", WHOLE)
@SOME
@given(**cases)
def test_what_is_measured_is_what_is_measured_without_the_bad_rows(
    name, seed, n, dim, wraps, kind, data
):
    tracks, rows = Tracks(seed, n, dim, wraps), bad_rows(data, n)
    found, said = quietly(WHOLE[name], tracks.spoilt(rows, kind))
    expected, _ = quietly(WHOLE[name], tracks.without(rows))
    if name in ("means", "polarisations", "centres", "angular momenta", "group table"):
        given_groups = int(tracks.label.max(initial=-1)) + 1
        assert len(found) == given_groups
        for k in range(given_groups):
            if (tracks.without(rows).label == k).any():
                np.testing.assert_array_equal(found[k], expected[k])
    elif expected is None:
        assert found is None
    else:
        for one, other in zip(np.atleast_1d(found), np.atleast_1d(expected), strict=True):
            np.testing.assert_array_equal(one, other)
    told = 2 if name == "energy" else 1  # agents, and boundary points
    assert len(said) == (told if rows else 0)
    assert all(one.rows == len(rows) and one.of == n for one in said)


@pytest.mark.parametrize("name", BY_ROW)
@SOME
@given(**cases)
def test_rows_keep_their_places_and_a_bad_one_is_marked(name, seed, n, dim, wraps, kind, data):
    measure, missing = BY_ROW[name]
    tracks, rows = Tracks(seed, n, dim, wraps), bad_rows(data, n)
    found, said = quietly(measure, tracks.spoilt(rows, kind))
    assert len(found) == n
    np.testing.assert_array_equal(np.delete(found, rows), measure(tracks.without(rows)))
    np.testing.assert_array_equal(found[rows], np.full(len(rows), missing))
    assert [one.rows for one in said] == ([len(rows)] if rows else [])


@SOME
@given(**cases)
def test_links_name_the_rows_of_the_whole_array(seed, n, dim, wraps, kind, data):
    tracks, rows = Tracks(seed, n, dim, wraps), bad_rows(data, n)
    found, _ = quietly(neighbours.links, tracks.spoilt(rows, kind).position, 3.0, *tracks.box)
    everyone = neighbours.links(tracks.position, 3.0, *tracks.box)
    np.testing.assert_array_equal(found, everyone[~np.isin(everyone, rows).any(axis=1)])


def test_one_bird_without_a_heading_is_not_order():
    """Today's 1.0 of `min(1.0, nan)`."""
    heading = Tracks(3, 200, 2, False).heading
    heading[7] = math.nan
    with pytest.warns(
        OmittedRowsWarning, match="heading: 1 of 200 row is left out: nan or infinite"
    ) as said:
        found = order.polarisation(heading)
    assert found == order.polarisation(np.delete(heading, 7, axis=0)) < 0.3
    assert said[0].filename == __file__
    assert (said[0].message.rows, said[0].message.of, said[0].message.what) == (1, 200, "heading")


def test_a_masked_number_is_no_number():
    tracks = Tracks(4, 20, 2, False)
    masked = np.ma.masked_array(tracks.heading, np.zeros((20, 2), bool))
    masked[5] = np.ma.masked
    found, said = quietly(order.polarisation, masked)
    assert found == order.polarisation(np.delete(tracks.heading, 5, axis=0))
    assert [one.rows for one in said] == [1]


def test_of_a_group_of_which_nobody_is_left_nothing_is_known():
    heading = np.array([[1.0, 0.0], [math.nan, 0.0], [0.0, 1.0]])
    found, _ = quietly(groups.polarisations, [0, 1, 2], heading)
    np.testing.assert_array_equal(found, [1.0, math.nan, 1.0])
    table, _ = quietly(groups.group_table, [2, 0, 1], heading, heading, [1, 1], [False, False])
    assert table[0]["agents"] == 0
    assert math.isnan(table[0]["polarisation"])


def test_who_is_in_no_group_is_not_measured():
    tracks = Tracks(5, 12, 3, True)
    tracks.position[4] = math.nan
    label, _ = quietly(groups_within, tracks.position, 3.0, *tracks.box)
    found, said = quietly(groups.group_table, label, tracks.position, tracks.heading, *tracks.box)
    assert said == []
    assert sum(row["agents"] for row in found.values()) == 11
    assert groups.group_sizes(label).sum() == 11


# --- over a run -------------------------------------------------------------------------------


def traces(seed=0):
    """Positions (T, dim, N) of 40 ticks of 6 agents, and the same with some of them unknown."""
    whole = np.random.default_rng(seed).uniform(0.0, 4.0, (40, 2, 6))
    spoilt = whole.copy()
    spoilt[3, 0, 1], spoilt[9, 1, 2], spoilt[20, :, 5] = math.nan, math.inf, -math.inf
    return whole, spoilt


def test_the_nearest_pairs_are_those_of_the_ticks_at_which_both_are_known():
    whole, spoilt = traces()
    least2, expected = np.full((6, 6), math.inf), np.full((6, 6), math.inf)
    _, said = quietly(following.nearest_pairs, spoilt, least2)
    known = np.isfinite(spoilt).all(axis=1)
    for t, places in enumerate(whole):
        for i in range(6):
            for j in range(i + 1, 6):
                if known[t, i] and known[t, j]:
                    d2 = np.sum((places[:, i] - places[:, j]) ** 2)
                    expected[i, j] = min(expected[i, j], d2)
    np.testing.assert_allclose(least2, expected, rtol=1e-12)
    assert [(one.rows, one.of) for one in said] == [(3, 240)]


def test_the_least_clearances_are_those_of_the_ticks_at_which_an_agent_is_known():
    surroundings = Flock("vem", agents=2, rng=1, world="corridor").engine.surroundings
    whole, spoilt = traces()
    least = np.full(6, math.inf)
    _, said = quietly(following.least_clearances, spoilt, surroundings, least)
    for i in range(6):
        one = np.full(1, math.inf)
        known = np.isfinite(spoilt[:, :, i]).all(axis=1)
        following.least_clearances(whole[known][:, :, i : i + 1], surroundings, one)
        assert one[0] == least[i]
    assert len(said) == 1


def test_who_is_not_known_at_a_tick_is_not_said_to_be_cut_off():
    places = np.zeros((3, 2, 3))
    places[:, 0] = [0.0, 1.0, 2.0]
    informed = np.array([True, False, False])

    def follows(trace):
        found = np.ones(3, bool)
        working = np.zeros(3, bool), np.zeros(3, np.int64)
        quietly(following.keep_following, trace, informed, 1.0, found, *working)
        return found.tolist()

    assert follows(places) == [True, True, True]
    missing = places.copy()
    missing[1, 0, 2] = math.nan
    assert follows(missing) == [True, True, True]
    missing[1, 0, :] = [0.0, math.nan, 2.0]  # who is between them is not seen: it is cut off
    assert follows(missing) == [True, True, False]
    missing[1, 0, :] = [math.nan, 1.0, 9.0]  # no information agent is known: nothing is said
    assert follows(missing) == [True, True, True]


def test_a_tick_without_a_number_is_not_for_good():
    assert consistency.convergence_time([0.5, 1.0, math.nan, 1.0]) == 3
    assert consistency.convergence_time([1.0, math.nan]) is None
    assert following.settling_tick([1.0, math.nan, 1.0], 2.0) == 2


def test_what_works_element_by_element_has_nan_where_it_is_given_nan():
    gap = np.array([1.0, math.nan, 3.0])
    for found in (
        energy.potential(gap, P),
        energy.urgency(gap, P),
        energy.sigma_norm(gap, 0.5),
        formation.upwash_share(gap, 0.9),
        formation.upwash_share(2.0, gap),
    ):
        assert np.isnan(found).tolist() == [False, True, False]
    assert float(formation.upwash_share(2.0, math.inf)) == 0.0
