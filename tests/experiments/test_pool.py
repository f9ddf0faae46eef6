"""Runs on threads: results, Ctrl-C, failures."""

import threading
import time

import pytest

from app.experiments.conduct import compile_models
from app.experiments.trial import Stopped, Trial, run_trial
from app.experiments.workers.pool import run_all
from experiments.small import TEXT, small


def endless(tmp_path):
    """An experiment whose noise never lets it converge."""
    text = TEXT.replace("eta = 0.0", "eta = 6.0").replace("limit = 400", "limit = 2000000000")
    return small(tmp_path, text)


def test_every_trial_is_kept_once(tmp_path):
    experiment = small(tmp_path)
    compile_models(experiment, None)
    trials = [Trial((case,), seed) for case in experiment.cases for seed in range(5)]
    kept = []
    run_all(trials, experiment.settings, 3, lambda trial, _: kept.append(trial))
    assert sorted(map(id, kept)) == sorted(map(id, trials))


def test_a_run_stops_when_it_is_asked_to(tmp_path):
    experiment = endless(tmp_path)
    compile_models(experiment, None)
    stop = threading.Event()
    threading.Timer(0.3, stop.set).start()
    begun = time.monotonic()
    with pytest.raises(Stopped):
        run_trial(Trial((experiment.cases[0],), 1), experiment.settings, stop)
    assert time.monotonic() - begun < 5.0


@pytest.mark.parametrize("kind", [KeyboardInterrupt, OSError])
def test_what_stops_the_caller_stops_the_runs(tmp_path, kind):
    quick, never = small(tmp_path), endless(tmp_path)
    trials = [Trial((quick.cases[0],), 1), *(Trial((never.cases[0],), seed) for seed in range(50))]
    settings = never.settings
    compile_models(never, None)

    def keep(_trial, _result):
        raise kind

    begun = time.monotonic()
    with pytest.raises(kind):
        run_all([trials[0], *trials[1:]], settings, 2, keep)
    assert time.monotonic() - begun < 10.0


def test_a_run_that_is_given_up_has_no_time(tmp_path):
    text = TEXT.replace("eta = 0.0", "eta = 6.0").replace("limit = 400", "limit = 50")
    experiment = small(tmp_path, text)
    trial = Trial((experiment.cases[0],), 1)
    [result] = run_trial(trial, experiment.settings, threading.Event())
    assert result.measures == {"k_con": None}
