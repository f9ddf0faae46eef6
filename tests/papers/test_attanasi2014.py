"""Attanasi et al. 2014 in small: a turn is a wave with inertia, and diffuses without."""

import numpy as np

from app.experiments.experiment import read_experiment
from app.experiments.kinds.turns import distances, sound_of
from app.experiments.trial import flock_of
from papers.flying import borne_out, flown, values

RUNS = 3


def test_a_turn_goes_as_a_wave_with_inertia_and_diffuses_without(tmp_path):
    experiment, made = flown("attanasi2014", tmp_path, RUNS)
    assert borne_out(experiment, made)
    exponent, ratio = values(made, "exponent"), values(made, "ratio")
    for label in ("inertia", "twice the inertia", "half the alignment"):
        assert min(exponent[label, 1600]) > 0.75
        assert 0.75 < min(ratio[label, 1600]) <= max(ratio[label, 1600]) < 1.2
    assert min(exponent["no inertia", 1600]) > 0.38
    assert max(exponent["no inertia", 1600]) < 0.6
    assert max(ratio["no inertia", 1600]) < 0.2


def test_the_speed_of_sound_is_that_of_a_uniform_flock():
    """n_c neighbours of mean square distance r^2 / 2: c_s = sqrt(J n_c r^2 / (8 chi))."""
    flock = flock_of(read_experiment("attanasi2014").cases[0], 3)
    n_c = np.pi * 2.0**2 * 1601 / 40.0**2
    assert abs(sound_of(flock) / np.sqrt(n_c * 2.0**2 / 8.0) - 1.0) < 0.03
    away = distances(flock, 5)
    assert away[5] == 0.0
    assert away.max() <= 20.0 * np.sqrt(2.0)
