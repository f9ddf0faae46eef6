"""Couzin et al. 2002 in small: a few cases of the map, and the way there and back."""

from dataclasses import replace

import pytest

from app.studies.claims.claims import verdicts
from app.studies.experiment_reader import read_experiment
from app.studies.experiment_runner import run_experiment
from app.studies.figures.phases import map_points, way_points

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
