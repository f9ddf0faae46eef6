"""Drawings of rules: what is judged of them, against definitions counted apart."""

import math

import numpy as np
import pytest

from agents import Flock
from app.studies.claims.claims import verdicts
from app.studies.experiment import flock_of
from app.studies.experiment_reader import read_experiment
from app.studies.experiment_runner import run_experiment
from app.studies.figures import draw, zoning
from app.studies.figures.branching import BranchingSettings, add_block, push_on
from app.studies.figures.dodging import DodgingSettings
from app.studies.figures.endurance import column_of
from app.studies.figures.gathering import share_crashed
from app.studies.figures.potential import PotentialSettings, tanner_potential, tanner_slope
from app.studies.figures.projections import ProjectionSettings
from app.studies.figures.regions import RegionSettings, weights
from app.studies.figures.zoning import (
    ALIGNED,
    ATTRACTED,
    BOTH,
    NOBODY,
    REPELLED,
    AgentNeighbours,
    ZoningSettings,
    branch_of,
    expected_wish,
    rule_direction,
    zones_by_rule,
)

SCHEMES = (
    "jacobs-fig1",
    "wu2023-fig1",
    "wu2023-fig2",
    *(f"thesis-fig3.{k}" for k in range(1, 7)),
    *(f"thesis-fig4.{k}" for k in range(1, 7)),
)


def nothing():
    """Between two pieces of a run."""


def settings_of(name, **update):
    """An experiment's settings, and the flock of its first row and seed 3."""
    experiment = read_experiment(name)
    return experiment.settings.model_copy(update=update), flock_of(experiment.cases[0], 3)


def test_tanners_potential_by_hand():
    assert tanner_potential(2.0) == pytest.approx(0.25 + math.log(4.0))
    assert tanner_slope(2.0) == pytest.approx(1.0 - 0.25)
    assert tanner_slope(0.5) == pytest.approx(4.0 - 16.0)


def test_the_potential_is_lowest_where_the_force_is_none():
    settings, flock = settings_of("jacobs-fig1", looks=40)
    assert isinstance(settings, PotentialSettings)
    found = settings.run(flock, nothing)
    assert found["lowest"] == pytest.approx(1.0, abs=1e-5)
    assert found["least"] == pytest.approx(1.0, abs=1e-9)
    assert found["nearer"] < 0.0 < found["farther"]
    assert found["pull"] <= 4.0 / (3.0 * math.sqrt(3.0)) + 1e-9, "its largest value, at sqrt 3"
    assert found["cars"] == pytest.approx(0.7 * 0.214 / 0.3, abs=1e-6)


def test_a_beta_agent_is_the_projection():
    for beside in ("disc", "wall"):
        settings, flock = settings_of("wu2023-fig1", beside=beside, looks=20)
        assert isinstance(settings, ProjectionSettings)
        found = settings.run(flock, nothing)
        assert max(found["place"], found["along"], found["velocity"]) < 1e-6
        assert (found["printed"] > 0.1) == (beside == "disc"), "mu is 1 at a wall"


def test_the_weight_of_a_pair_is_that_of_its_region():
    settings, flock = settings_of("wu2023-fig2", looks=40)
    assert isinstance(settings, RegionSettings)
    assert weights(flock, np.array([1.9, 2.0, 4.0, 4.1])).tolist() == [1e4, 10.0, 10.0, 0.1]
    found = settings.run(flock, nothing)
    assert found["off"] < 1e-6
    assert found["warning"] == pytest.approx(2.0, abs=1e-6)
    assert found["wrong"] == 0
    assert found["separation"] > found["early"] > found["attraction"] > 0.0


def test_zones_of_places_by_hand():
    start = {"position": [[5.0, 5.0]], "heading": [[1.0, 0.0]]}
    flock = Flock("thesis", start=start, world="open", dim=2, size=10.0, rng=1)
    places = np.array([[1.0, 0.0], [2.0, 0.5], [4.0, -3.0], [4.0, 3.9], [-1.0, 0.0], [3.0, 3.1]])
    assert zones_by_rule(flock, 0, places).tolist() == [0, 1, 2, -1, -1, -1]
    start["heading"] = [[0.0, 1.0]]
    all_round = Flock("couzin", start=start, world="open", dim=2, size=10.0, rng=1, dr_o=1, dr_a=2)
    places = np.array([[0.0, -0.9], [0.0, -1.5], [1.5, 0.0], [2.0, -1.0], [0.0, 4.1]])
    assert zones_by_rule(all_round, 0, places).tolist() == [0, -1, 1, 2, -1]


@pytest.mark.parametrize(
    ("zone", "branch"),
    [
        ([], NOBODY),
        ([-1, -1], NOBODY),
        ([0, 1, 2], REPELLED),
        ([1, -1], ALIGNED),
        ([2], ATTRACTED),
        ([1, 2], BOTH),
    ],
)
def test_repulsion_comes_first(zone, branch):
    assert branch_of(np.array(zone, int)) == branch


def test_the_wish_by_hand():
    apart = np.array([[1.0, 0.0], [0.0, 2.0], [0.0, 4.0]])
    heading = np.array([[0.0, 1.0], [1.0, 0.0], [1.0, 0.0]])
    own = np.array([0.6, 0.8])
    near = AgentNeighbours(apart, heading, np.array([0, 1, 2]))
    assert expected_wish(near, own) == pytest.approx([-1.0, 0.0])
    far = AgentNeighbours(apart, heading, np.array([-1, 1, 2]))
    assert expected_wish(far, own) == pytest.approx([math.sqrt(0.5), math.sqrt(0.5)])
    assert expected_wish(AgentNeighbours(apart, heading, np.full(3, -1)), own) == pytest.approx(own)


def test_the_rule_wishes_what_its_equations_say():
    settings, flock = settings_of("thesis-fig3.4", looks=60)
    assert isinstance(settings, ZoningSettings)
    assert np.linalg.norm(rule_direction(flock, 0)) == pytest.approx(1.0)
    found = settings.run(flock, nothing)
    assert found["wrong"] == 0
    assert found["off"] < 1e-4
    assert 0.0 < found["turned"] <= 12.0 + 1e-6
    shares = [found[name] for name in ("nobody", "repelled", "aligned", "attracted", "both")]
    assert sum(shares) == pytest.approx(100.0)


def test_ways_through_the_algorithm_are_counted_once_each():
    settings, flock = settings_of("thesis-fig4.6", limit=40, every=20)
    assert isinstance(settings, BranchingSettings)
    found = settings.run(flock, nothing)
    shares = [found[name] for name in ("nobody", "repelled", "aligned", "attracted", "both")]
    assert sum(shares) == pytest.approx(100.0)
    assert 0.0 < found["obstacle"] < 100.0


def test_a_block_pushes_those_that_have_it_ahead():
    start = {"position": [[7.0, 12.0]], "heading": [[1.0, 0.0]]}
    flock = Flock("thesis", start=start, world="open", dim=2, size=24.0, rng=1)
    blocked = add_block(flock, 3.0)
    d = 12.0 - 1.5 - 7.0 - 0.375
    force = 10.0 * (1.0 / d - 1.0 / 5.0) / d**2
    assert push_on(blocked, 0) == pytest.approx([-force, 0.0])
    blocked.heading[0] = (-1.0, 0.0)
    assert push_on(blocked, 0).tolist() == [0.0, 0.0]
    inside = {"position": [[12.0, 12.0]], "heading": [[1.0, 0.0]]}
    moved = add_block(Flock("thesis", start=inside, world="open", dim=2, size=24.0, rng=1), 3.0)
    assert moved.position[0] == pytest.approx([17.0, 12.0])


def test_slow_agents_get_round_a_block_and_fast_ones_do_not():
    experiment = read_experiment("thesis-fig4.4")
    settings = experiment.settings.model_copy(update={"looks": 20, "flights": 5})
    assert isinstance(settings, DodgingSettings)
    slow, fast = (settings.run(flock_of(case, 3), nothing) for case in experiment.cases)
    assert (slow["hits"], fast["hits"]) == (0, 5)
    assert max(slow["off"], fast["off"]) < 1e-3
    assert slow["unseen"] == fast["unseen"] == 0.0


def test_who_crashes_later_is_a_share_of_those_that_flew():
    assert share_crashed(np.array([0, 0, 5, 9]), 6) == pytest.approx(50.0)
    assert share_crashed(np.zeros(3, int), 3) is None


def test_conditions_of_a_sweep_have_a_column_each():
    cases = read_experiment("wu2023-delay").cases
    columns = list(dict.fromkeys(column_of(case.sweep) for case in cases))
    assert [parameter for parameter, _ in columns] == ["delay"] * 4
    assert len({around for _, around in columns}) == 4
    cases = read_experiment("thesis-delay").cases
    assert {column_of(case.sweep) for case in cases} == {
        ("delay", ""), ("lost", ""), ("place_error", ""),
    }  # fmt: skip


@pytest.mark.parametrize("name", SCHEMES)
def test_every_scheme_is_drawn(name, tmp_path, monkeypatch):
    monkeypatch.setattr(zoning, "CELLS", 12)
    whole = read_experiment(name)
    small = {"looks": 10, "flights": 1, "limit": 40, "every": 20}
    known = {key: value for key, value in small.items() if hasattr(whole.settings, key)}
    object.__setattr__(whole, "settings", whole.settings.model_copy(update=known))
    done = run_experiment(whole, tmp_path, runs=2, seed=1, workers=1, tell=None, at=lambda *_: None)
    files = draw(whole, verdicts(whole, done.measured), tmp_path)
    for path in files.values():
        assert path.stat().st_size > 5000
