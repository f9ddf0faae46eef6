"""Jacobs and Koessler in small: a few runs with fixed seeds.

Lags of cars that turn on the spot are those of the reading, an independent implementation, and so
is the order of the starts; the paper prints no numbers but the zero of its squashing function.
"""

from dataclasses import replace

import pytest

from app.studies.claims.claims import claims, verdicts
from app.studies.experiment_reader import read_experiment
from app.studies.experiment_runner import run_experiment
from papers.flying import borne_out, flown, values

RUNS = 8


def test_figure_2_the_squashing_function_is_zero_at_half_a_metre(tmp_path):
    experiment, made = flown("jacobs-fig2", tmp_path, 1, looks=40)
    assert [one.word for one in claims(made, experiment.said)] == ["holds"] * 2 + ["does not hold"]
    [[zero]] = values(made, "zero").values()
    assert zero == pytest.approx(0.7 * 0.214 / 0.3, abs=1e-9)


def test_figure_3_the_swarm_lags_and_a_pair_settles_at_half_a_metre(tmp_path):
    experiment, made = flown("jacobs-fig3", tmp_path, 3)
    assert borne_out(experiment, made)
    lags = values(made, "lag")
    for speed, reading in (("0.3 m/s", 32.0), ("0.5 m/s", 47.0), ("0.8 m/s", 62.0)):
        assert lags[speed, 4] == pytest.approx([reading] * 3, abs=0.6)
    assert values(made, "apart")["pair alone", 2] == pytest.approx([0.4993] * 3, abs=2e-4)


def test_figure_11_aligned_starts_go_well_and_random_ones_do_not(tmp_path):
    experiment, made = flown("jacobs-fig11", tmp_path, RUNS, [4])
    said = [one for one in experiment.said if getattr(one, "share", 1.0) == 1.0]
    assert borne_out(replace(experiment, said=said), made)
    ok = values(made, "ok")
    assert ok["aligned", 4] == [100] * RUNS
    assert sum(ok["random", 4]) <= 300
    assert sum(values(made, "collision")["random", 4]) >= 500
    best = {name: values(made, name)["best", 4] for name in ("locked", "collision", "stuck")}
    assert best == {"locked": [100] * RUNS, "collision": [0] * RUNS, "stuck": [0] * RUNS}
    assert all(47.0 < lag < 60.0 for lag in values(made, "lag")["aligned", 4])


def test_a_predator_that_repels_less_disturbs_nobody(tmp_path):
    experiment, made = flown("jacobs-predator", tmp_path, 4)
    assert borne_out(replace(experiment, said=experiment.said[1:]), made)
    assert values(made, "collision")["beta_p = 2", 5] == [0] * 4
    assert values(made, "outside")["beta_p = 2", 5] == [100] * 4


def test_gallery_one_car_is_held_and_two_and_three_follow(tmp_path):
    experiment, made = flown("jacobs-gallery1", tmp_path / "1", 4)
    assert borne_out(experiment, made)
    assert max(values(made, "furthest")["one car", 1]) < 1.3
    experiment, made = flown("jacobs-gallery2", tmp_path / "2", 4)
    assert borne_out(experiment, made)


def test_future_work_an_integral_term_makes_cars_lag_and_touch(tmp_path):
    whole = read_experiment("jacobs-future").select(["aligned", "aligned, integral"], [])
    done = run_experiment(whole, tmp_path, runs=4, seed=1, workers=2, tell=None, at=lambda *_: None)
    made = verdicts(whole, done.measured)
    assert values(made, "ok")["aligned", 4] == [100] * 4
    assert sum(values(made, "collision")["aligned, integral", 4]) >= 200
