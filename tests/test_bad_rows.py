"""Arrays that are not perfect: rows that are no numbers are left out and counted, all else refused.

Tracks of animals and cars have gaps. What is measured of them is what is measured without the gaps.
"""

import math
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents import Flock
from agents.catalogue import MODELS, model
from agents.observables import (
    consistency,
    correlation,
    energy,
    fluctuations,
    following,
    formation,
    groups,
    layers,
    neighbours,
    order,
    per_group,
    rotation,
)
from agents.observables.catalogue import OBSERVABLES
from agents.observables.checks import LeftOut
from agents.observables.components import groups_within
from agents.series import follow
from worlds.refusal import Refusal
from worlds.world import World

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
    "centre": lambda t: rotation.centre(t.position, *t.box),
    "angular momentum": lambda t: rotation.angular_momentum(t.position, t.heading, *t.box),
    "correlation length": lambda t: correlation.correlation_length(t.position, t.velocity, *t.box),
    "correlation": lambda t: correlation.correlation(t.position, t.velocity, *t.box),
    "bin width": lambda t: correlation.bin_width(t.position, *t.box),
    "mean neighbours": lambda t: neighbours.mean_neighbours(t.position, 3.0, *t.box),
    "number of links": lambda t: len(neighbours.links(t.position, 3.0, *t.box)),
    "tree": lambda t: neighbours.tree(t.position, *t.box).data,
    "means": lambda t: per_group.means(t.label, t.velocity),
    "polarisations": lambda t: per_group.polarisations(t.label, t.heading),
    "centres": lambda t: per_group.centres(t.label, t.position, *t.box),
    "angular momenta": lambda t: per_group.angular_momenta(t.label, t.position, t.heading, *t.box),
    "group table": lambda t: [
        list(row.values())
        for row in per_group.group_table(t.label, t.position, t.heading, *t.box).values()
    ],
    "energy": lambda t: energy.hamiltonian(
        t.position, t.velocity, np.zeros((2, t.dim)), t.position + 0.5, P
    ),
    "susceptibility": lambda t: fluctuations.susceptibility(t.series[:, 0], 30),
    "binder": lambda t: fluctuations.binder(t.series[:, 0]),
}
"""One number, or one row for each group, of all agents."""
BY_ROW = {
    "nearest neighbour": (lambda t: neighbours.nearest_neighbour(t.position, *t.box), math.nan),
    "groups": (lambda t: groups_within(t.position, 2.5, *t.box), -1),
    "saved": (lambda t: formation.saved_shares(t.position, t.heading, 2.0, *t.box), math.nan),
}
"""A row for each agent, and what it is for one that is left out."""


def quietly(function, *arguments):
    """What a function gives, and the LeftOut that it warned of; any other warning is an error."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("error")
        warnings.simplefilter("always", LeftOut)
        found = function(*arguments)
    return found, [one.message for one in said]


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
    with pytest.warns(LeftOut, match="heading: 1 of 200 row is left out: nan or infinite") as said:
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
    found, _ = quietly(per_group.polarisations, [0, 1, 2], heading)
    np.testing.assert_array_equal(found, [1.0, math.nan, 1.0])
    table, _ = quietly(per_group.group_table, [2, 0, 1], heading, heading, [1, 1], [False, False])
    assert table[0]["agents"] == 0
    assert math.isnan(table[0]["polarisation"])


def test_who_is_in_no_group_is_not_measured():
    tracks = Tracks(5, 12, 3, True)
    tracks.position[4] = math.nan
    label, _ = quietly(groups_within, tracks.position, 3.0, *tracks.box)
    found, said = quietly(
        per_group.group_table, label, tracks.position, tracks.heading, *tracks.box
    )
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


# --- refused ----------------------------------------------------------------------------------

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
        lambda: rotation.angular_momentum(X, U * [[1.0], [0.0], [1.0]], *BOX),
        "length 0: unit vectors are needed, or nan",
    ),
    "objects": (lambda: order.polarisation(U.astype(object)), "heading holds object values"),
    "complex": (lambda: order.polarisation(U + 1j), "heading holds complex128 values"),
    "words": (lambda: order.polarisation([["a", "b"]]), "heading holds <U1 values"),
    "ragged": (lambda: order.polarisation([[1.0], [1.0, 2.0]]), "rows have different lengths"),
    "nothing": (lambda: order.polarisation(None), "heading holds object values"),
    "lengths": (
        lambda: rotation.angular_momentum(X[:2], U, *BOX),
        "rows: position 2, heading 3",
    ),
    "axes": (
        lambda: rotation.angular_momentum(np.ones((3, 3)), U, np.ones(3), np.zeros(3, bool)),
        r"shapes: position \(3, 3\), heading \(3, 2\)",
    ),
    "a box of zero": (lambda: rotation.centre(X, [10.0, 0.0], BOX[1]), r"size = \[10.0, 0.0\]"),
    "a box of nan": (lambda: groups_within(X, 1.0, [math.nan] * 2, BOX[1]), "size = "),
    "a box of three": (lambda: neighbours.links(X, 1.0, np.ones(3), BOX[1]), r"size has shape \(3"),
    "a box of one number": (lambda: neighbours.links(X, 1.0, 10.0, BOX[1]), r"size has shape \(\)"),
    "images of floats": (lambda: neighbours.links(X, 1.0, BOX[0], [0.0, 1.0]), "images has shape"),
    "reach nan": (lambda: neighbours.links(X, math.nan, *BOX), "r = nan"),
    "reach below 0": (lambda: neighbours.mean_neighbours(X, -1.0, *BOX), "r = -1.0"),
    "reach infinite": (lambda: groups_within(X, math.inf, *BOX), "r = inf"),
    "width": (lambda: correlation.correlation(X, U, *BOX, width=0.0), "width = 0.0"),
    "labels of floats": (lambda: per_group.polarisations([0.0, 1.0, 1.0], U), "labels holds float"),
    "labels below -1": (lambda: groups.group_sizes([0, -2]), "labels holds -2"),
    "labels too few": (lambda: per_group.polarisations([0, 1], U), "rows: labels 2, heading 3"),
    "links beyond": (lambda: groups.group_labels(3, [[0, 3]]), "links holds 3"),
    "links of three": (lambda: groups.group_labels(3, [[0, 1, 2]]), r"links have shape \(1, 3\)"),
    "informed": (lambda: layers.layers([[0, 1]], [0.0, 1.0]), "informed holds float64 values"),
    "layers": (lambda: layers.layer_histogram([1.5, 2.0]), "layer holds float64 values"),
    "reference zero": (lambda: consistency.consistency(U, [0.0, 0.0]), r"reference = \[0.0, 0.0\]"),
    "reference nan": (lambda: consistency.consistency(U, math.nan), r"reference = \[nan\]"),
    "reference of three": (
        lambda: consistency.consistency(U, [1.0, 0.0, 0.0]),
        "reference has 3 axes and heading 2",
    ),
    "degrees": (lambda: consistency.convergence_time(np.ones((2, 2))), "degrees has shape"),
    "series": (lambda: fluctuations.binder(np.ones((2, 2))), "series has shape"),
    "agents": (lambda: fluctuations.susceptibility([0.5], -1), "n = -1"),
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
    with pytest.raises(Refusal, match=words) as said:
        quietly(call)
    assert "\n" not in str(said.value)


@pytest.mark.parametrize("empty", [[], np.empty((0, 2)), np.empty((0, 3))])
def test_nobody_has_a_value_and_no_warning(empty):
    dim = np.shape(empty)[-1] or 2
    box = np.ones(dim), np.ones(dim, bool)
    found = {
        "polarisation": quietly(order.polarisation, empty)[0],
        "consistency": quietly(consistency.consistency, empty)[0],
        "momentum": quietly(rotation.angular_momentum, empty, empty, *box)[0],
        "neighbours": quietly(neighbours.mean_neighbours, empty, 1.0, *box)[0],
        "links": len(quietly(neighbours.links, empty, 1.0, *box)[0]),
        "groups": len(quietly(groups_within, empty, 1.0, *box)[0]),
    }
    assert list(found.values()) == [0.0, 1.0, 0.0, 0.0, 0, 0]
    assert np.isnan(quietly(rotation.centre, empty, *box)[0]).all()
    assert math.isnan(quietly(correlation.correlation_length, empty, empty, *box)[0])


# --- of a flock -------------------------------------------------------------------------------

AT_ONE_TICK = [one.name for one in OBSERVABLES.values() if one.over is None]
ROOM = World(name="room", size=(12.0, 12.0), edges=("solid", "wrap"))


@pytest.mark.parametrize("array", ["position", "heading", "speed"])
@pytest.mark.parametrize("name", AT_ONE_TICK)
def test_an_agent_of_a_flock_that_is_nowhere_is_left_out(name, array):
    def flock(rows):
        rng = np.random.default_rng(8)
        angle = rng.uniform(0.0, math.tau, 30)
        start = {
            "position": rng.uniform(0.5, 11.5, (30, 2)),
            "heading": np.c_[np.cos(angle), np.sin(angle)],
            "speed": rng.uniform(0.5, 1.0, 30),
        }
        return Flock(
            "vem", start={key: value[rows] for key, value in start.items()}, world=ROOM, rng=1
        )

    made, fine = flock(np.arange(30)), flock(np.setdiff1d(np.arange(30), [0, 17]))
    getattr(made, array)[[0, 17]] = math.nan
    found, said = quietly(made.observe, name)
    np.testing.assert_equal(found, fine.observe(name))
    assert [(one.rows, one.of, one.what) for one in said] == [(2, 30, "agents")]


NONE = {
    "polarisation": 0.0, "consistency": 1.0, "angular-momentum": 0.0, "groups": 0,
    "largest-group": 0, "mean-neighbours": 0.0, "nearest-neighbour": math.inf, "connectivity": 0.0,
    "obstacle-distance": math.inf, "inside-obstacles": 0, "group-polarisation": math.nan,
    "group-angular-momentum": math.nan, "correlation-length": math.nan, "goal-distance": math.nan,
    "following": math.nan, "drag-saved": math.nan, "energy-saved": math.nan, "group-sizes": {},
    "group-table": {}, "layers": {},
}  # fmt: skip
"""What a flock of nobody has, but for `crashes`, which goes on telling of those that were."""
ONE = {
    "polarisation": 1.0, "consistency": 1.0, "angular-momentum": 0.0, "groups": 1,
    "largest-group": 1, "group-polarisation": 1.0, "group-angular-momentum": 0.0,
    "mean-neighbours": 0.0, "nearest-neighbour": math.inf, "connectivity": 0.0,
    "correlation-length": math.nan, "group-sizes": {1: 1},
    "group-table": {"agents": 1, "polarisation": 1.0, "angular-momentum": 0.0},
}  # fmt: skip
"""What a lone agent has, whatever it is and wherever; the rest depends on its world."""
MAY_BE_NAN = {
    "correlation-length", "crashes", "goal-distance", "following", "drag-saved", "energy-saved",
}  # fmt: skip
"""What a flock of two may lack."""


def of(name, n, **more):
    """A flock of n ordinary agents and its information agents; of none, all were taken out."""
    flock = Flock(name, agents=max(1, n), rng=1, **more)
    for member in list(flock.members) if n == 0 else []:
        member.remove()
    return flock


@pytest.fixture(scope="module")
def few():
    """Flocks of none, one and two: of every model where it is at home, and in other worlds."""
    elsewhere = [
        ("vem", {"dim": 3}),
        ("vem", {"world": ROOM}),
        ("vem", {"world": "open"}),
        ("vem", {"world": "wrap-plain"}),
        ("couzin", {"world": "rooms-3d"}),
        ("hwvem-nav", {"world": "obstacles"}),
        ("vem", {"informed": 0}),
    ]
    made = {n: [of(name, n) for name in MODELS] for n in (0, 1, 2)}
    for n, flocks in made.items():
        flocks += [of(name, n, **more) for name, more in elsewhere]
        ran = of("vem", n, eta=1.0)
        ran.run(3)
        flocks.append(ran)
    return made


@pytest.mark.parametrize("n", [0, 1, 2])
@pytest.mark.parametrize("name", AT_ONE_TICK)
def test_every_observable_is_defined_of_a_flock_of_none_of_one_and_of_two(name, n, few):
    """Never an exception, never a warning, and nan only where docs/observables.md says so."""
    for flock in few[n]:
        who = flock.model.name, flock.world.name
        value, said = quietly(flock.observe, name)
        assert said == [], who
        agents = len(flock.ids)
        assert agents == (n + flock.spec.informed if n else 0)
        expected = NONE if agents == 0 else ONE if agents == 1 else {}
        if name in expected:
            value = value[0] if name == "group-table" and agents == 1 else value
            assert value == pytest.approx(expected[name], abs=1e-15, nan_ok=True), who
        elif name not in MAY_BE_NAN and not isinstance(value, dict):
            assert not math.isnan(value), who


@pytest.mark.parametrize("name", ["susceptibility", "binder"])
def test_a_run_of_few_has_fluctuations_or_none(name, few):
    for n, expected in (
        (0, {"susceptibility": 0.0, "binder": math.nan}),
        (1, {"susceptibility": 0.0, "binder": 2.0 / 3.0}),
    ):
        series, said = quietly(follow, few[n][-1], 4, [name])
        assert said == []
        assert series.over(name) == pytest.approx(expected[name], abs=1e-12, nan_ok=True)
