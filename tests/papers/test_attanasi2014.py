"""Attanasi et al. 2014 in small: a turn is a wave with inertia, and diffuses without."""

import numpy as np
import pytest

from app.studies.experiment import flock_of
from app.studies.experiment_reader import read_experiment
from app.studies.figures.turns import TurnSettings, distances, sound_speed
from papers.flying import borne_out, flown, values

RUNS = 3


def test_a_turn_goes_as_a_wave_with_inertia_and_diffuses_without(tmp_path):
    experiment, made = flown("attanasi2014", tmp_path, RUNS)
    assert borne_out(experiment, made)
    exponent, ratio = values(made, "exponent"), values(made, "ratio")
    for label in ("inertia", "twice the inertia", "half the alignment"):
        assert min(exponent[label, 1600]) > 0.75
        assert 0.75 < min(ratio[label, 1600]) <= max(ratio[label, 1600]) < 1.2
    assert min(exponent["no inertia", 1600]) > 0.35
    assert max(exponent["no inertia", 1600]) < 0.55
    assert max(ratio["no inertia", 1600]) < 0.2
    speed, order = values(made, "speed"), values(made, "order")
    ordered, shaken = ("in place, T = 0", 1600), ("in place, T = 1", 1600)
    assert order[ordered] == pytest.approx([1.0] * RUNS)
    assert max(order[shaken]) < 0.95
    slower = np.array(speed[shaken]) / np.array(speed[ordered])
    assert 0.85 < slower.mean() < 0.99, "about the root of the order, or its power 1"


def test_a_run_with_noise_goes_on_twice_with_the_same_noise():
    """Word of a turn goes no further than r in a tick: beyond, nothing differs to the bit."""
    experiment = read_experiment("attanasi2014")
    case = next(one for one in experiment.cases if one.label == "in place, T = 1")
    short = experiment.settings.model_copy(update={"settle": 20, "limit": 0.3, "turn": 90.0})
    seen = []

    def keep(self, flock, between):
        seen.append(TurnSettings.headings(self, flock, between))
        return seen[-1]

    watched = type("Watched", (TurnSettings,), {"headings": keep}).model_construct(**dict(short))
    flock = flock_of(case, 2)
    watched.turn_flock(flock)
    without, with_turn = seen
    differs = (without != with_turn).any(axis=2)
    away = distances(flock, int(np.argmax(flock.informed)))
    assert not differs[-1, away > 2.0 * 6].any()
    assert differs[-1, (away > 4.0) & (away < 6.0)].mean() > 0.9
    assert flock.tick == 20 + 6


def test_the_speed_of_sound_is_that_of_a_uniform_flock():
    """n_c neighbours of mean square distance r^2 / 2: c_s = sqrt(J n_c r^2 / (8 chi))."""
    flock = flock_of(read_experiment("attanasi2014").cases[0], 3)
    n_c = np.pi * 2.0**2 * 1601 / 40.0**2
    assert abs(sound_speed(flock) / np.sqrt(n_c * 2.0**2 / 8.0) - 1.0) < 0.03
    away = distances(flock, 5)
    assert away[5] == 0.0
    assert away.max() <= 20.0 * np.sqrt(2.0)
