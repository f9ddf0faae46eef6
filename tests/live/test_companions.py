"""Simulated cars beside real ones: they hear each other, and stop when the real ones stop."""

from __future__ import annotations

import gc
import math
import re
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from agents.bodies.car_commands import separation
from agents.catalogue import cars_for_rule
from agents.flock import Flock
from app.live.control.arm import OperatorRequest
from app.live.control.car_control import CarControl
from app.live.control.pose import CompanionDriver, MocapFrame, Pose, seen, unseen
from app.live.links.link import RUN, STOP
from app.live.operating.flock_driver import APART, FlockDriver, world_of
from live.rooms import lab
from live.test_flock_driver import PERFECT, SQUASHING, naive, text_of
from worlds.input_error import InputError

ROOT = Path(__file__).parents[2]
TARGET = Pose(2.0, 0.0, 0.5 * math.pi)
PLACES = (Pose(-1.0, 0.0, 0.3), Pose(-1.0, 1.5, -2.0), Pose(1.0, -1.5, 1.0), Pose(0.0, 2.0, 2.0))


def beside(text=SQUASHING, cars=2, **more):
    """A laboratory with simulated cars."""
    return (
        text
        + "\n[simulated]\n"
        + "".join(f"{name} = {value}\n" for name, value in {"cars": cars, **more}.items())
    )


def driving(**values):
    """The laboratory of two cars with parameters."""
    table = "".join(f"{name} = {value}\n" for name, value in values.items())
    return SQUASHING.replace("[area]", f"[parameters]\n{table}\n[area]")


def sightings(driver, places=PLACES):
    return tuple(seen(*pair) for pair in zip(driver.names, places, strict=False))


def begun(text, target=TARGET):
    """A driver whose cars were all seen once; they do not run yet."""
    driver = FlockDriver(lab(text))
    driver.drive(0.0, sightings(driver), target, False)
    return driver


def drive(driver, ticks, running=True, target=TARGET, since=0.0):
    """Let it drive real cars that stand; its last commands."""
    for k in range(1, ticks + 1):
        told = driver.drive(since + 0.01 * k, sightings(driver), target, running)
    return told


def at(driver):
    """The poses of the simulated cars."""
    return [one.pose for one in driver.companions]


def test_they_begin_once_all_real_cars_were_seen():
    driver = FlockDriver(lab(beside(cars=3)))
    assert isinstance(driver, CompanionDriver)
    red, blue = seen("red", PLACES[0]), seen("blue", PLACES[1])
    assert driver.drive(0.0, (red, unseen("blue")), TARGET, True) == {}
    assert driver.companions == ()
    driver.accompany(2)
    assert driver.companions == ()
    assert driver.drive(0.01, (red, blue), TARGET, False).keys() == {"red", "blue"}
    assert [(one.name, one.steer) for one in driver.companions] == [("sim 1", 0.0), ("sim 2", 0.0)]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("speed", [1.1, -1.1])
def test_they_begin_apart_within_the_fence_along_the_circle(seed, speed):
    text = beside(cars=8, seed=seed).replace("radius = 2.0", f"radius = 2.0\nspeed = {speed}")
    driver = begun(text)
    places = [*PLACES[:2], TARGET, *at(driver)]
    assert len(places) == 11
    for k, a in enumerate(places):
        assert all(math.hypot(a.x - b.x, a.y - b.y) >= APART for b in places[:k])
    for pose in at(driver):
        assert lab().area.distance_inside(pose.x, pose.y) >= 0.0
        moment = pose.x * math.sin(pose.yaw) - pose.y * math.cos(pose.yaw)
        assert moment == pytest.approx(math.copysign(math.hypot(pose.x, pose.y), speed))


def test_where_they_begin_follows_from_the_seed():
    assert at(begun(beside(seed=4))) == at(begun(beside(seed=4)))
    assert at(begun(beside(seed=4))) != at(begun(beside(seed=5)))
    loose = beside(seed=4).replace('path = "circle"\nradius = 2.0', 'path = "hand"')
    assert len({pose.yaw for pose in at(begun(loose.replace("cars = 2", "cars = 8")))}) == 8


def test_real_ones_hear_them():
    driver = begun(beside(cars=3))
    for k in range(1, 200):
        simulated = at(driver)
        told = driver.drive(0.01 * k, sightings(driver), TARGET, True)
        places = [*PLACES[:2], *simulated]
        for name, wanted in zip(driver.names, naive(places, TARGET), strict=False):
            assert told[name] == pytest.approx(wanted, rel=1e-6, abs=1e-9)
    driver.accompany(0)
    alone = driver.drive(2.0, sightings(driver), TARGET, True)
    for name, wanted in zip(driver.names, naive(PLACES[:2], TARGET), strict=True):
        assert alone[name] == pytest.approx(wanted, rel=1e-6, abs=1e-9)
    assert alone["red"] != told["red"]


def test_they_drive_as_in_a_simulation_to_the_bit_and_hear_the_real_ones():
    one = lab(beside(text_of(2), cars=2, seed=3))
    driver = begun(beside(text_of(2), cars=2, seed=3))
    poses = [*PLACES[:2], *at(driver)]
    flock = Flock(
        cars_for_rule(one.rule).name,
        world=world_of(one),
        start={
            "position": [(pose.x, pose.y) for pose in poses],
            "heading": [(math.cos(pose.yaw), math.sin(pose.yaw)) for pose in poses],
        },
        rng=0,
        **PERFECT,
    )
    flock.position[2:], flock.heading[2:] = driver.position[2:], driver.heading[2:]
    rng = np.random.default_rng(8)
    wandering = np.array([(pose.x, pose.y, pose.yaw) for pose in PLACES[:2]])
    for k in range(1, 301):
        wandering += rng.normal(scale=0.02, size=(2, 3))
        real = [Pose(*map(float, row)) for row in wandering]
        target = Pose(2.0 * math.cos(0.0055 * k), 2.0 * math.sin(0.0055 * k), 0.0)
        driver.drive(0.01 * k, sightings(driver, real), target, True)
        flock.position[:2] = wandering[:, :2]
        flock.heading[:2] = [(math.cos(pose.yaw), math.sin(pose.yaw)) for pose in real]
        flock.engine.surroundings.route[0, :2] = target.x, target.y
        flock.advance(1)
        assert np.array_equal(driver.position[2:], flock.position[2:])
        assert np.array_equal(driver.heading[2:], flock.heading[2:])
        wheels = [0.25 * math.pi * one.steer for one in driver.companions]
        assert wheels == pytest.approx(flock.signal("steering")[2:], rel=1e-12)
    assert math.dist(driver.position[2], (poses[2].x, poses[2].y)) > 0.5


@pytest.mark.parametrize("rule", ["squashing", "squashing-best"])
def test_they_never_drive_into_a_real_one(rule):
    text = beside(SQUASHING.replace('"squashing"', f'"{rule}"'), cars=1)
    driver, least = begun(text), math.inf
    parked = [Pose(0.0, 2.0, 0.7), Pose(-2.0, 0.0, 0.0)]  # on the circle that it would go round
    for k in range(1, 3000):
        target = Pose(2.0 * math.cos(0.0055 * k), 2.0 * math.sin(0.0055 * k), 0.0)
        driver.drive(0.01 * k, sightings(driver, parked), target, True)
        me = at(driver)[0]
        for pose in parked:
            mine, other = ((math.cos(yaw), math.sin(yaw)) for yaw in (me.yaw, pose.yaw))
            between = pose.x - me.x, pose.y - me.y
            least = min(least, separation(*between, *mine, *other, 0.22, 0.12))
    assert 0.0 < least < 1.0


def test_while_the_cars_do_not_run_they_stand():
    driver = begun(beside(cars=4))
    began = at(driver)
    drive(driver, 50, running=False)
    assert at(driver) == began
    drive(driver, 100)
    went = driver.companions
    assert all(pose.x != old.x for pose, old in zip(at(driver), began, strict=True))
    told = drive(driver, 100, running=False)
    assert driver.companions == went
    assert told.keys() == {"red", "blue"}  # what is wanted goes on; it is the safety that stops
    driver.drive(5.0, sightings(driver), TARGET, True)
    for old, new in zip(went, driver.companions, strict=True):
        far = math.hypot(new.pose.x - old.pose.x, new.pose.y - old.pose.y)
        assert 0.0 < far < 0.001  # from standstill, as the real ones


def test_they_stand_while_the_injected_car_is_not_seen():
    driver = begun(beside())
    drive(driver, 50)
    stands = driver.companions
    for k in range(10):
        assert driver.drive(1.0 + 0.01 * k, sightings(driver), None, True) == {}
    assert driver.companions == stands


@pytest.mark.parametrize("ticks", [190, 270])  # one would be about to back out, and backing out
@pytest.mark.parametrize("simulated", [0, 2])
@pytest.mark.parametrize("values", [{"reverse": "true"}, {"yields": "true"}])
def test_who_stands_because_it_may_not_drive_is_not_stuck(ticks, simulated, values):
    driver = begun(beside(driving(**values), cars=simulated))
    drive(driver, ticks, running=False)
    for k in range(40):
        told = drive(driver, 1, since=3.0 + 0.01 * k)
        assert all(throttle > 0.0 for _, throttle in told.values())


def test_who_stands_though_told_to_drive_backs_out():
    driver = begun(beside(driving(reverse="true"), cars=0))
    assert all(throttle > 0.0 for _, throttle in drive(driver, 45).values())
    assert all(throttle < 0.0 for _, throttle in drive(driver, 10, since=0.45).values())
    # a stop ends it: whoever is armed again begins forwards
    drive(driver, 1, running=False, since=0.55)
    assert all(throttle > 0.0 for _, throttle in drive(driver, 40, since=0.56).values())


def test_the_number_changes_and_those_that_stay_keep_all():
    driver = begun(beside(cars=3))
    drive(driver, 200)
    other = begun(beside(cars=3))
    drive(other, 200)
    for count in (5, 3, 8, 4, 3):
        before, memory = driver.companions, driver.signals().copy()
        driver.accompany(count)
        kept = min(count, len(before))
        assert driver.companions[:kept] == before[:kept]
        assert len(driver.companions) == count
        rows = 2 + kept
        assert np.array_equal(driver.signals()[:, :rows], memory[:, :rows], equal_nan=True)
    drive(driver, 100, since=2.0)
    drive(other, 100, since=2.0)
    assert driver.companions == other.companions


@pytest.mark.parametrize(
    ("count", "words"),
    [
        (9, r"simulated cars = 9 is not allowed: at most 8 \(the laboratory's file\)"),
        (-1, "simulated cars = -1 is not allowed: at least 0"),
    ],
)
def test_a_number_that_is_not_allowed_changes_nothing(count, words):
    driver = begun(beside())
    before = driver.companions
    with pytest.raises(InputError, match=words):
        driver.accompany(count)
    drive(driver, 1, running=False)
    assert driver.companions == before


def narrow(cars):
    """A laboratory in which there is room for one or two simulated cars."""
    small = SQUASHING.replace("[-3.0, -3.0]", "[-1.5, -1.0]").replace("[3.0, 3.0]", "[1.5, 1.0]")
    return beside(small.replace('path = "circle"\nradius = 2.0', 'path = "hand"'), cars=cars)


def test_where_there_is_no_room_nothing_changes():
    target = Pose(0.0, 0.4, 0.0)
    driver = FlockDriver(lab(narrow(0)))
    places = (Pose(-0.7, -0.4, 0.0), Pose(-0.7, 0.4, 0.0))
    driver.drive(0.0, sightings(driver, places), target, False)
    driver.accompany(1)
    before = driver.companions
    with pytest.raises(
        InputError, match=r"sim \d has no room: none of 200 places within the fence"
    ):
        driver.accompany(8)
    assert driver.companions == before
    told = driver.drive(0.01, sightings(driver, places), target, False)
    assert told.keys() == {"red", "blue"}
    assert driver.companions == before


def test_simulated_cars_that_do_not_fit_an_empty_room_are_refused_before_anything_begins():
    words = r"simulated cars = 8 is not allowed: sim (\d) has no room: .*; (\d) would fit"
    with pytest.raises(InputError, match=words) as refused:
        FlockDriver(lab(narrow(8)))
    first, fit = re.search(words, str(refused.value)).groups()
    assert int(first) == int(fit) + 1
    FlockDriver(lab(narrow(int(fit))))


def test_what_does_not_fit_between_the_real_ones_is_refused_once_and_they_drive():
    text = narrow(1).replace("[-1.5, -1.0]", "[-1.2, -0.8]").replace("[1.5, 1.0]", "[1.2, 0.8]")
    one, now = lab(text), 100.0
    driver = FlockDriver(one)
    control = CarControl(one.safety(), driver)
    target = Pose(0.0, 0.3, 0.0)
    events, modes = [], []
    for number in range(25):
        now += 0.01
        asked = [OperatorRequest("arm", "test")] if number == 5 else []
        far = 0.35 + 1e-6 * number  # no place is 0.6 m from both
        bodies = seen("blue body", Pose(-far, 0.0, 0.0)), seen("red", Pose(far, 0.0, 0.0))
        control.begin_tick(now, asked, (MocapFrame(number, now, bodies),))
        step = control.end_tick(now, target)
        events += step.events
        modes.append(step.verdict.mode)
    refused = [event.words for event in events if event.kind == "refused"]
    assert len(refused) == 1
    assert re.fullmatch(
        r"simulated cars = 1 is not allowed: sim 1 has no room: .*0 would fit", *refused
    )
    assert modes == [STOP] * 5 + [RUN] * 20
    assert set(step.wanted) == {"red", "blue"}
    assert driver.companions == ()


def test_a_change_compiles_nothing_and_is_quick():
    for cars in (1, 4):
        driver = begun(beside(text_of(cars), cars=0))
        compiled = list(driver.loop.advance.signatures)
        took = []
        for k in range(60):
            begins = time.perf_counter()
            driver.accompany(k * 5 % 9)
            took.append(time.perf_counter() - begins)
            drive(driver, 1, since=0.01 * k)
        assert driver.loop.advance.signatures == compiled
        assert np.median(took) < 0.01


def test_many_ticks_keep_nothing():
    driver = begun(beside(text_of(4), cars=8))
    ours = [tracemalloc.Filter(True, str(ROOT / place / "*")) for place in ("app", "agents")]
    tracemalloc.start()
    kept = []
    for since in (0.0, 50.0, 100.0):  # what calls compiled code fills its caches at first
        drive(driver, 4000, since=since)
        gc.collect()
        traces = tracemalloc.take_snapshot().filter_traces(ours).statistics("filename")
        kept.append(sum(one.size for one in traces))
    assert np.isfinite(driver.position).all()
    tracemalloc.stop()
    assert kept[2] - kept[1] < 80_000  # less than a number a tick
