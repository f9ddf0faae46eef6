"""Experiments about cars behind an injected one: what is measured, and where they start."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from agents import Flock
from app.studies.experiment import flock_of
from app.studies.experiment_file import PLAIN, Overrides, Ranks, with_goal
from app.studies.experiment_reader import read_file
from app.studies.experiment_runner import fingerprint
from app.studies.figures.driving import (
    Drive,
    DrivingSettings,
    lags,
    lap_of,
    nearest_car,
    nearest_distances,
)
from app.studies.figures.squash import SquashSettings
from worlds.input_error import InputError
from worlds.layout import world

TEXT = """
kind = "driving"
title = "Small drive"
source = "these tests"
picture = "driving"
runs = 2

[settings]
world = "cars-circle"
limit = 12.0

[[rows]]
model = "squashing-cars"
agents = 2
mission = { speed = 1.2, ranks = { places = [[1.6, -0.6], [1.1, -0.6]], heading = 90.0 } }

[[rows]]
model = "squashing-cars"
agents = 2
"""


def small(folder, text=TEXT):
    """The small experiment, read from a file."""
    path = folder / "small.toml"
    path.write_text(text)
    return read_file(path)


def drive_of(position, met=None, hunts=None, crashes=0):
    """A drive with these positions (T, N, 2)."""
    n = position.shape[1]
    met = np.zeros((n, n), int) if met is None else met
    return Drive(position, met, [], np.zeros(n, bool) if hunts is None else hunts, crashes)


@pytest.mark.parametrize(("beta", "c", "gamma"), [(2, 0.7, 0.214), (0.5, 0.4, 1.5), (9, 0.9, 0.05)])
def test_the_squashing_function_is_the_formula(beta, c, gamma):
    flock = Flock("squashing", agents=2, world="open", size=10.0, r=200.0,
                  rng=1, beta=beta, C=c, gamma=gamma)  # fmt: skip
    found = SquashSettings(world="open", far=100.0, looks=30).run(flock, lambda: None)
    assert found["zero"] == pytest.approx(c * gamma / (1.0 - c), abs=1e-9)
    assert found["formula"] == pytest.approx(c * gamma / (1.0 - c), abs=1e-15)
    assert found["error"] < 1e-12
    assert found["touching"] == pytest.approx(-beta * c, rel=1e-4)
    assert found["distant"] == pytest.approx(beta * (100.0 / (100.0 + gamma) - c), abs=1e-12)


def test_the_lag_is_the_angle_behind_the_injected_car():
    flock = Flock("squashing", agents=3, rng=1)
    lap = lap_of(flock)
    assert lap == round(2.0 * math.pi * 2.0 / 1.1 / 0.01)
    behind = np.radians([0.0, 50.0, -20.0])
    goal = flock.goal_at(np.arange(101, 101 + lap))
    angle = np.arctan2(goal[:, 1], goal[:, 0])[:, None] - behind
    position = 1.3 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    found = lags(flock, position, 100 + lap)
    assert found == pytest.approx(np.tile(behind, (lap, 1)), abs=1e-9)


def test_a_car_is_locked_that_keeps_its_lag():
    settings = DrivingSettings(world="cars-circle", limit=20.0, drift=10.0, spread=30.0)
    time = np.linspace(0.0, 1.0, 101)
    still = np.full(101, 0.9)
    waves = 0.9 + np.radians(14.0) * np.sin(2.0 * np.pi * time)
    wide = 0.9 + np.radians(16.0) * np.sin(2.0 * np.pi * time)
    falls_back = 0.9 + np.radians(11.0) * time
    assert settings.is_locked(np.column_stack([still, waves]))
    assert not settings.is_locked(np.column_stack([still, wide]))
    assert not settings.is_locked(np.column_stack([still, falls_back]))


def test_distances_are_those_of_pairs():
    position = np.random.default_rng(2).normal(size=(4, 5, 2))
    for frame, found in zip(position, nearest_distances(position), strict=True):
        for i in range(5):
            others = [(math.dist(frame[i], frame[j]), j) for j in range(5) if j != i]
            assert found[i] == pytest.approx(min(others)[0])
            assert nearest_car(frame, i) == min(others)[1]


def test_what_a_predator_does_is_no_collision():
    place = np.zeros((2, 3, 2))
    hunts = np.array([True, False, False])
    met = np.zeros((3, 3), int)
    assert not drive_of(place, met, hunts).has_collision
    met[2, 0] = 1
    assert drive_of(place, met, hunts).has_caught
    assert not drive_of(place, met, hunts).has_collision
    assert drive_of(place, met, hunts, crashes=1).has_collision
    met[1, 2] = 1
    assert drive_of(place, met, hunts).has_collision


@pytest.mark.parametrize(("reverse", "stuck"), [(False, 100), (True, 0)])
def test_cars_that_meet_head_on_are_stuck_unless_they_back_out(reverse, stuck):
    start = {"position": [[0.0, -0.4], [0.0, 0.4]], "heading": [[0.0, 1.0], [0.0, -1.0]]}
    flock = Flock("squashing-cars", start=start, world="cars-circle", rng=1, reverse=reverse,
                  beta=0.0, noise_xy=0.0, noise_yaw=0.0)  # fmt: skip
    settings = DrivingSettings(world="cars-circle", limit=12.0)
    drive = settings.drive(flock)
    assert drive.has_collision
    assert {row for _, row in drive.touched} <= {0, 1}
    found = settings.measure_drive(flock, drive, lap_of(flock))
    assert (found["collision"], found["stuck"], found["ok"]) == (100, stuck, 0)


def test_a_car_that_leaves_the_area_is_outside():
    settings = DrivingSettings(world="cars-circle", limit=12.0)
    flock = Flock("squashing", agents=2, rng=1)
    lap = lap_of(flock)
    goal = flock.goal_at(np.arange(lap + 1))
    position = np.stack([goal, 0.7 * goal], axis=1)
    found = settings.measure_drive(flock, drive_of(position), lap)
    assert (found["ok"], found["locked"], found["outside"]) == (100, 100, 0)
    assert found["lag"] == pytest.approx(0.0, abs=1e-9)
    assert found["apart"] == pytest.approx(0.3 * np.linalg.norm(goal, axis=1).mean())
    position[5, 1] = 3.06, 0.0
    found = settings.measure_drive(flock, drive_of(position), lap)
    assert (found["ok"], found["locked"], found["outside"]) == (0, 100, 100)
    assert [found[name] for name in ("collision", "stuck", "caught", "chased")] == [None] * 4


@pytest.mark.parametrize("speed", [0.3, 0.5, 0.8])
def test_one_car_that_turns_on_the_spot_lags_as_its_speed_has_it(speed):
    """Across the line of sight to the injected car: d = R sin(lag), speed omega R cos(lag)."""
    radius = 2.0

    def left(lag):
        d = radius * math.sin(lag)
        return 2.0 * (d / (d + 0.214) - 0.7) - speed * math.cos(lag)

    flock = Flock(
        "squashing",
        agents=1,
        rng=1,
        world=with_goal(world("cars-circle"), Overrides(speed=speed)),
    )
    found = DrivingSettings(world="cars-circle", limit=130.0).run(flock, lambda: None)
    assert found["locked"] == 100
    assert found["lag"] == pytest.approx(math.degrees(brentq(left, 0.3, 1.5)), abs=0.2)


def test_ranks_are_places_in_order():
    ranks = Ranks(places=[(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)], heading=90.0, speed=0.5)
    start = ranks.start(2, 1)
    assert start["position"].tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert start["heading"] == pytest.approx(np.array([[0.0, 1.0]] * 2))
    assert start["speed"].tolist() == [0.5, 0.5]
    loose = ranks.model_copy(update={"off": 0.1, "turned": 5.0})
    assert (loose.start(3, 4)["position"] == loose.start(3, 4)["position"]).all()
    assert (loose.start(3, 4)["position"] != loose.start(3, 5)["position"]).all()
    many = [loose.start(3, seed) for seed in range(400)]
    assert np.std([one["position"] - ranks.places for one in many]) == pytest.approx(0.1, rel=0.1)
    angle = [np.degrees(np.arctan2(-one["heading"][:, 0], one["heading"][:, 1])) for one in many]
    assert np.std(angle) == pytest.approx(5.0, rel=0.1)
    with pytest.raises(InputError, match="only 3 have a place"):
        ranks.start(4, 1)


def test_a_row_may_override_its_mission(tmp_path):
    experiment = small(tmp_path)
    first, plain = experiment.cases
    flock = flock_of(first, 1)
    assert flock.position.tolist() == [[1.6, -0.6], [1.1, -0.6]]
    assert flock.world.mission.goal.speed == 1.2
    assert flock_of(plain, 1).world == world("cars-circle")
    prints = {fingerprint(first, experiment.settings), fingerprint(plain, experiment.settings)}
    quick = replace(first, row=first.row.model_copy(update={"mission": PLAIN}))
    assert fingerprint(quick, experiment.settings) in prints
    assert len(prints) == 2


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("speed = 1.2", "speed = 0.0", "> 0"),
        ("places = [[1.6, -0.6], [1.1, -0.6]]", "places = []", "places"),
        ("heading = 90.0", "haeding = 90.0", "haeding|heading"),
        ("agents = 2\nmission", "agents = 2\nsize = 9.0\nmission", "no mission"),
        ("limit = 12.0", "limit = 0.0", "settings.limit"),
    ],
)
def test_a_wrong_file_is_refused(tmp_path, before, after, words):
    with pytest.raises(InputError, match=words):
        small(tmp_path, TEXT.replace(before, after, 1))


def test_a_drive_needs_an_injected_car_that_goes_round_within_it():
    settings = DrivingSettings(world="cars-circle", limit=11.0)
    with pytest.raises(
        InputError, match=r"limit = 11 s is less than a lap.* 11\.4 s in cars-circle"
    ):
        settings.run(Flock("squashing", agents=1, rng=1), lambda: None)
    alone = Flock("squashing", agents=1, rng=1, world="open", size=5.0)
    with pytest.raises(InputError, match="'open' has no injected car"):
        settings.run(alone, lambda: None)
    with pytest.raises(InputError, match="'open' has no goal"):
        with_goal(world("open", 2, 5.0), Overrides(speed=1.0))
