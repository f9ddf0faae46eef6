"""Couzin et al. 2002 in small: a few cases of the map, the way there and back, and sorting."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import sorting as oracle

from agents import Flock
from agents.individuals import uniform
from app.studies.claims.claims import verdicts
from app.studies.experiment_reader import read_experiment
from app.studies.experiment_runner import run_experiment
from app.studies.figures.phases import map_points, way_points
from app.studies.figures.sorting import SortingSettings, rank_correlation
from papers.flying import borne_out, flown, values
from worlds.input_error import InputError

RUNS = 3
PLACES = {
    (0.0, 14.0): "swarm",
    (2.5, 14.0): "torus",
    (2.5, 10.0): "torus",
    (3.5, 12.0): "dynamic parallel",
    (4.0, 12.0): "dynamic parallel",
    (14.0, 12.0): "highly parallel",
    (14.0, 2.0): "highly parallel",
    (0.0, 2.0): "fragments",
}


def carried_out(folder, keep):
    """The cases that are to be kept, carried out."""
    whole = read_experiment("couzin2002-phases")
    experiment = replace(whole, cases=[case for case in whole.cases if keep(case)])
    done = run_experiment(
        experiment, folder, runs=RUNS, seed=1, workers=2, tell=None, at=lambda *_: None
    )
    return verdicts(experiment, done.measured)


@pytest.fixture(scope="module")
def places(tmp_path_factory):
    """The places of the map that are looked at here."""
    made = carried_out(
        tmp_path_factory.mktemp("map"),
        lambda case: not case.way and (case.value, case.at) in PLACES,
    )
    return {(spot.x, spot.y): spot for spot in map_points(made)}


@pytest.mark.parametrize("place", PLACES)
def test_the_phases_are_where_the_paper_has_them(places, place):
    assert (places[place].phase, places[place].share) == (PLACES[place], 1.0)


def test_a_torus_mills_and_a_parallel_group_goes_straight(places):
    torus, parallel, swarm = (places[at] for at in ((2.5, 14.0), (14.0, 12.0), (0.0, 14.0)))
    assert torus.m.least > 0.65 > 0.4 > torus.p.most
    assert parallel.p.least > 0.99 > 0.2 > parallel.m.most
    assert max(swarm.p.most, swarm.m.most) < 0.4


def test_a_group_remembers_what_it_was(tmp_path):
    """Between the widths at which the torus breaks up and at which the parallel group does."""
    made = carried_out(tmp_path, lambda case: bool(case.way))
    ways = {up.x: (up, down) for up, down in way_points(made)}
    up, down = ways[2.5]
    assert up.p.most < 0.4 < 0.9 < down.p.least
    assert up.m.least > 0.65 > 0.1 > down.m.most
    for width, phase in ((0.0, "swarm"), (5.0, "parallel")):
        assert all(spot.phase.endswith(phase) for spot in ways[width])


def test_the_fast_lead_and_a_small_zone_of_repulsion_leads_to_the_centre(tmp_path):
    """Rank correlations within four standard deviations of those of another implementation."""
    experiment, made = flown("couzin2002-sorting", tmp_path, 4)
    assert borne_out(experiment, made)
    front, centre = ({label: of for (label, _), of in values(made, m).items()} for m in
                     ("front", "centre"))  # fmt: skip
    assert min(front["speed, parallel"]) > 0.94
    assert min(centre["repulsion, torus"]) > 0.87
    assert min(centre["speed, torus"]) > 0.93
    assert 0.15 < np.mean(centre["repulsion, parallel"]) < 0.63
    assert -0.73 < np.mean(front["error, parallel"]) < -0.13
    assert abs(np.mean(centre["speed, parallel"])) < 0.32


SHORT = SortingSettings(world="open", dim=3, settle=20, looks=6, every=5)


@pytest.mark.parametrize("size", [6.0, 40.0])
def test_places_are_those_of_the_oracle(size):
    """In a large box agents are in several groups, and come and go."""
    words = {"agents": 30, "rng": 4, "dim": 3, "world": "open", "size": size, "dr_a": 5.0}
    flock = Flock("couzin", s=uniform(2.0, 4.0), **words)
    again = Flock("couzin", s=uniform(2.0, 4.0), **words)
    again.run(20)
    looks = []
    for _ in range(6):
        again.run(5)
        looks.append((again.position.copy(), again.heading.copy()))
    places = oracle.mean_places(looks, again.reach)
    rows = sorted(places)
    own = again.own["s"][rows].tolist()
    measured = SHORT.run(flock, lambda: None)
    for k, name in enumerate(("centre", "front")):
        expected = oracle.rank_correlation(own, [places[row][k] for row in rows])
        assert measured[name] == pytest.approx(expected, abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=3, max_size=20))
def test_the_rank_correlation_is_spearmans(pairs):
    own, place = np.array(pairs, float).T
    found = rank_correlation(own, place)
    if len(set(own)) == 1 or len(set(place)) == 1:
        assert found is None
    else:
        assert found == pytest.approx(oracle.rank_correlation(list(own), list(place)), abs=1e-9)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({}, "agents differ in nothing"),
        ({"s": uniform(2, 4), "r_r": uniform(1, 2)}, "agents differ in .*r_r"),
    ],
)
def test_agents_that_differ_in_nothing_or_in_two_things_are_refused(words, message):
    flock = Flock("couzin", agents=10, rng=1, dim=3, world="open", size=4.0, **words)
    with pytest.raises(InputError, match=message):
        SHORT.run(flock, lambda: None)
