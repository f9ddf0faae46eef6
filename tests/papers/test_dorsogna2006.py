"""D'Orsogna et al. 2006 in small: some places of the map, and the room that particles keep."""

from dataclasses import replace

import numpy as np
import pytest

from agents import Flock
from app.studies.claims.claims import claims, verdicts
from app.studies.experiment_reader import read_experiment
from app.studies.experiment_runner import run_experiment
from app.studies.figures.phases import map_points
from app.studies.figures.swarming import room, shape_of
from app.studies.judge.verdict import verdicts_on


def carried_out(whole, folder, keep, runs=2):
    """The cases that are to be kept, carried out."""
    experiment = replace(whole, cases=[case for case in whole.cases if keep(case)])
    done = run_experiment(
        experiment, folder, runs=runs, seed=1, workers=1, tell=None, at=lambda *_: None
    )
    return verdicts(experiment, done.measured)


def test_a_mill_a_ring_and_one_that_disperses(tmp_path):
    """A third of the runs of the mill's place still has two mills at their end."""
    places = {(0.4, 1.0): "mill", (0.6, 0.6): "ring", (0.6, 4.0): "disperses"}
    whole = read_experiment("dorsogna2006")
    made = carried_out(whole, tmp_path, lambda case: (case.value, case.at) in places, runs=25)
    assert {(spot.x, spot.y): spot.phase for spot in map_points(made)} == places
    assert {one.summary.mean for one in verdicts_on(made, "side")} == {1.0}


def test_the_room_that_particles_keep(tmp_path):
    whole = read_experiment("dorsogna2006-size")
    made = carried_out(whole, tmp_path, lambda case: case.agents in (30, 120))
    found = {
        (one.case.label, one.case.agents): one.summary.mean for one in verdicts_on(made, "radius")
    }
    near = {
        (one.case.label, one.case.agents): one.summary.mean for one in verdicts_on(made, "spacing")
    }
    assert found["catastrophic", 120] == pytest.approx(found["catastrophic", 30], rel=0.05)
    assert near["catastrophic", 120] == pytest.approx(0.5 * near["catastrophic", 30], rel=0.1)
    assert found["H-stable", 120] == pytest.approx(2.0 * found["H-stable", 30], rel=0.15)
    assert near["H-stable", 120] == pytest.approx(near["H-stable", 30], rel=0.15)
    words = {one.text.split(":")[0]: one.word for one in claims(made, whole.said)}
    assert list(words) == ["catastrophic, N = 30, 120", "H-stable, N = 30, 120"]
    assert "does not hold" not in words.values()


def test_a_ring_that_turns_has_the_measures_of_one():
    turn = 2.0 * np.pi * np.arange(10) / 10
    out = np.column_stack([np.cos(turn), np.sin(turn)])
    heading = np.column_stack([-out[:, 1], out[:, 0]])
    heading[::2] *= -1.0
    start = {"position": 5.0 + 2.0 * out, "heading": heading}
    flock = Flock("dorsogna", start=start, world="open", size=9.0, C_r=4.0, C_a=2.0, l_r=0.5)
    p, m, either, radius, spacing, hole = shape_of(flock)
    assert (m, either, radius) == (
        pytest.approx(0.0, abs=1e-14), pytest.approx(1.0), pytest.approx(2.0),
    )  # fmt: skip
    assert p < 0.2
    assert spacing == pytest.approx(4.0 * np.sin(np.pi / 10))
    assert hole == pytest.approx(1.0)
    assert room(flock) == pytest.approx(0.5)
