"""Cucker and Smale 2007 in small: the bound by itself, and what the command says of two runs."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from agents import Flock
from app.studies.claims.claims import claims, verdicts
from app.studies.experiment_reader import read_experiment
from app.studies.experiment_runner import run_experiment
from app.studies.figures.consensus import ConsensusBound, ConsensusSettings
from app.studies.judge.verdict import verdicts_on
from worlds.input_error import InputError


def test_the_critical_speed_of_two_is_that_of_the_integral():
    """beta = 1, 1 m apart: v = 2 K (pi / 2 - atan 1) between them, half of it for each."""
    x0 = math.sqrt(0.5)
    bound = ConsensusBound(2, 3.0, 1.0, 1.0, x0, 1.0)
    relative = math.sqrt(2.0) * bound.spread_lost(math.inf)
    assert relative == pytest.approx(2.0 * 3.0 * (math.pi / 2.0 - math.pi / 4.0), rel=1e-9)
    assert ConsensusBound(2, 3.0, 1.0, 0.5, x0, 1e6).share == 0.0


@pytest.mark.parametrize("beta", [0.2, 0.5, 0.9])
def test_the_furthest_is_where_all_of_v_is_lost(beta):
    bound = ConsensusBound(20, 0.4, 1.5, beta, 2.0, 1.7)
    lost = (
        20 * quad(lambda s: 0.4 / (1.5**2 + 2.0 * s * s) ** beta, 2.0, bound.furthest_distance)[0]
    )
    assert lost == pytest.approx(1.7, rel=1e-6)
    rate = 20 * 0.4 / (1.5**2 + 2.0 * bound.furthest_distance**2) ** beta
    found = bound.differences(np.array([0.0, 2.0]))
    assert found == pytest.approx([1.7, 1.7 * math.exp(-2.0 * rate)], rel=1e-9)


def test_agents_set_off_straight_apart():
    settings = ConsensusSettings(world="open", radius=0.5, lasts=1, looks=1)
    flock = Flock("cucker-smale", agents=9, size=4.0, world="open", rng=1, v_start=3.0)
    settings.set_headings(flock)
    out = flock.position - flock.position.mean(axis=0)
    assert np.sqrt((out**2).sum(axis=1).mean()) == pytest.approx(0.5)
    assert flock.heading * flock.speed[:, None] == pytest.approx(6.0 * out)
    assert math.sqrt((flock.speed**2).mean()) == pytest.approx(3.0)


def test_a_flock_that_becomes_wider_than_its_reach_is_refused():
    settings = ConsensusSettings(world="open", radius=0.5, lasts=400, looks=4)
    flock = Flock("cucker-smale", agents=2, size=4.0, world="open", rng=1, v_start=9.0, r=5.0)
    with pytest.raises(InputError, match="r = 5 is less than the flock became wide, "):
        settings.run(flock, lambda: None)


def test_two_runs_say_what_the_paper_proves(tmp_path):
    whole = read_experiment("cucker-smale2007")
    few = [case for case in whole.cases if case.agents == 2 or case.label in ("0.45", "1 above")]
    done = run_experiment(
        replace(whole, cases=few), tmp_path, runs=2, seed=1, workers=1, tell=None,
        at=lambda *_: None,
    )  # fmt: skip
    made = verdicts(whole, done.measured)
    left = {(one.case.label, one.case.agents): one.summary for one in verdicts_on(made, "left")}
    assert max(left[label, 2].most for label in ("0.25", "0.45", "0.75 below", "1 below")) < 0.05
    assert left["0.45", 20].most < 1e-6
    assert min(left[label, 2].least for label in ("0.75 above", "1 above")) > 0.15
    assert left["1 above", 20].least > 0.15
    for one in verdicts_on(made, "kept"):
        if one.case.agents == 2:
            assert one.summary.mean == pytest.approx(1.0, abs=0.02)
        else:
            assert one.summary.most < 1.0
    found = claims(made, whole.said)
    assert not [one.text for one in found if one.word == "does not hold"]
    [kept] = [one for one in found if "N = 2: kept" in one.text]
    assert kept.word == "undecided", "of two runs of each"
