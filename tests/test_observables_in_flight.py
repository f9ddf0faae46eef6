"""What is observed of flocks that crash, and of what birds save by flying behind others."""

import math

import numpy as np
import pytest

from agents import Flock
from agents.observables.catalogue import OBSERVABLES
from agents.observables.of_flocks import INDUCED
from agents.run_records import follow

AT_ONE_TICK = [one.name for one in OBSERVABLES.values() if one.over is None]


def flyers(position, model="safe", **more):
    position = np.array(position)
    start = {"position": position, "heading": np.tile([1.0, 0.0, 0.0], (len(position), 1))}
    return Flock(model, start=start, rng=1, **more)


def two_that_touch_and_three_that_fly():
    return flyers([[5.0, 5, 5], [5.3, 5, 5], [12, 12, 12], [12, 14, 12], [20, 20, 20]])


def test_crashes_are_counted_and_the_crashed_are_no_longer_measured():
    flock = two_that_touch_and_three_that_fly()
    assert flock.observe("crashes") == 0
    assert flock.observe("groups") == 3
    assert flock.observe("largest-group") == 2
    assert flock.observe("nearest-neighbour") == pytest.approx(0.3)
    flock.run(1)
    assert flock.observe("crashes") == 2
    assert flock.observe("groups") == 2
    assert flock.observe("group-sizes") == {2: 1, 1: 1}
    assert flock.observe("nearest-neighbour") > 1.0


def test_a_flock_that_cannot_crash_has_no_number_of_crashes():
    assert math.isnan(Flock("vem", agents=5, rng=1).observe("crashes"))


def test_the_agents_of_a_series_are_those_that_fly():
    series = follow(two_that_touch_and_three_that_fly(), 3, ["crashes", "binder"])
    assert series.agents.tolist() == [3, 3, 3]
    assert series.values["crashes"].tolist() == [2, 2, 2]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", AT_ONE_TICK)
def test_a_flock_of_which_nobody_flies_any_more_can_be_observed(name):
    flock = flyers([[5.0, 5, 5], [5.3, 5, 5]])
    flock.run(1)
    assert not flock.active.any()
    empty = {
        "polarisation": 0.0,
        "consistency": 1.0,
        "angular-momentum": 0.0,
        "velocity-spread": 0.0,
        "gyration-radius": 0.0,
        "groups": 0,
        "largest-group": 0,
        "group-sizes": {},
        "group-table": {},
        "mean-neighbours": 0.0,
        "number-seen": 0.0,
        "connectivity": 0.0,
        "layers": {},
        "inside-obstacles": 0,
        "crashes": 2,
        "lane-order": 0.0,
        "nearest-neighbour": math.inf,
        "obstacle-distance": math.inf,
    }
    value = flock.observe(name)
    assert value == empty[name] if name in empty else math.isnan(value)


def test_what_is_saved_is_the_mean_of_those_that_fly_in_percent():
    flock = flyers([[5.0, 5, 5], [3.0, 5.7, 5], [5.0, 12, 12], [5.1, 12, 12]], model="thesis")
    assert math.isnan(flock.observe("drag-saved"))
    flock.run(2)
    assert flock.active.tolist() == [True, True, False, False]
    share = flock.signal("saved")
    drag = flock.observe("drag-saved")
    assert drag == pytest.approx(100.0 * (share[0] + share[1]) / 2.0)
    assert drag != 0.0
    assert flock.observe("energy-saved") == pytest.approx(INDUCED * drag)


def test_models_that_measure_no_saving_have_none():
    flock = Flock("couzin", agents=5, rng=1)
    flock.run(1)
    assert math.isnan(flock.observe("drag-saved"))
    assert math.isnan(flock.observe("energy-saved"))


def test_every_observable_is_described():
    for name, one in OBSERVABLES.items():
        assert name == one.name
        assert one.title
        assert one.unit
        assert one.range
