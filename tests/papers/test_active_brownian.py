"""Free and crowded active Brownian particles in small: what the commands measure of one run."""

from dataclasses import replace

import numpy as np
import pytest
from oracles import active_brownian as oracle

from agents import Flock
from app.studies.claims.claims import claims, verdicts
from app.studies.experiment_reader import read_experiment
from app.studies.experiment_runner import run_experiment
from app.studies.figures.crowding import CrowdingSettings, velocity_along_heading
from app.studies.figures.diffusion import squared_displacement
from app.studies.judge.verdict import verdicts_on


def carried_out(whole, folder, keep):
    """The cases that are to be kept, two runs of each."""
    experiment = replace(whole, cases=[case for case in whole.cases if keep(case)])
    done = run_experiment(
        experiment, folder, runs=2, seed=1, workers=1, tell=None, at=lambda *_: None
    )
    return verdicts(experiment, done.measured)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_closed_form_is_that_of_the_oracle(dim):
    for t in (0.01, 1.0, 50.0):
        expected = oracle.squared_displacement(t, dim, 1.7, 0.4, 0.1)
        found = squared_displacement(t, dim, 1.0 / ((dim - 1) * 0.4), 1.7, 0.1)
        assert found == pytest.approx(expected, rel=1e-9)


def test_free_particles_keep_to_the_closed_form(tmp_path):
    whole = read_experiment("bechinger2016-msd")
    made = carried_out(whole, tmp_path, lambda case: case.label == "kicked")
    for name, within in (("short", 0.06), ("middle", 0.06), ("long", 0.12), ("D", 0.2)):
        assert verdicts_on(made, name)[0].summary.mean == pytest.approx(1.0, abs=within)
    assert verdicts_on(made, "turned")[0].summary.mean == pytest.approx(1.0, abs=0.15)
    assert "does not hold" not in [one.word for one in claims(made, whole.said)]


def test_crowded_particles_slow_down_on_a_line(tmp_path):
    whole = read_experiment("fily2012-speed")
    made = carried_out(whole, tmp_path, lambda case: case.label in ("0.2", "0.5"))
    few, many = (one.summary.mean for one in verdicts_on(made, "speed"))
    assert many < 0.6 < 0.75 < few < 0.87
    assert verdicts_on(made, "packing")[1].summary.mean == pytest.approx(0.5, abs=1e-4)
    assert verdicts_on(made, "slope")[0].summary.mean == pytest.approx((1.0 - few) / 0.2, rel=1e-3)


def test_a_lone_particle_gets_on_at_its_speed():
    flock = Flock("active-brownian", agents=1, size=3.0, world="wrap", rng=1, v0=2.0, D_r=3.0)
    assert [velocity_along_heading(flock) for _ in range(200)] == pytest.approx(np.full(200, 2.0))
    settings = CrowdingSettings(world="wrap", lasts=0, looks=3, every=2)
    assert settings.run(flock, lambda: None)["speed"] == pytest.approx(1.0)
