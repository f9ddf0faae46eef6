"""Real cars are told what simulated ones would be, to the bit, wherever both are."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from agents.bodies.car_commands import SIGNALS
from agents.catalogue import cars_for_rule
from agents.flock import Flock
from app.live.control.injected_target import InjectedTarget
from app.live.control.pose import Pose, seen, unseen
from app.live.emulation.emulated_room import EmulatedPlant
from app.live.operating.flock_driver import FlockDriver, world_of
from live.rooms import LAB, lab
from worlds.input_error import InputError

SQUASHING = LAB.replace('rule = "none"', 'rule = "squashing"')
PERFECT = {"noise_xy": 0.0, "noise_yaw": 0.0, "latency": 0.0, "hop": 0.0}
TARGET = Pose(2.0, 0.0, 1.5)


def with_parameters(**values):
    table = "\n".join(f"{name} = {value}" for name, value in values.items())
    return SQUASHING.replace("[area]", f"[parameters]\n{table}\n\n[area]")


def text_of(cars):
    """A laboratory of so many cars."""
    more = "".join(f"\n[cars.c{k}]\naddress = {k + 1}\n" for k in range(cars))
    return SQUASHING[: SQUASHING.index("[cars.red]")] + more


@pytest.fixture(scope="module")
def driver():
    return FlockDriver(lab(SQUASHING))


def naive(
    poses, target, beta=2.0, c=0.7, gamma=0.214, alpha=0.4, most=math.pi / 4, sure=lambda _: None
):
    """(steer, throttle) of each car by (2) and (3), written from the paper.

    `sure` is told of each car whether rounding cannot turn its wheels the other way.
    """
    told = []
    for i, me in enumerate(poses):
        total = 0j
        for j, other in enumerate([*poses, target]):
            if i != j:
                v = complex(other.x - me.x, other.y - me.y)
                total += beta * v / abs(v) * (-c + abs(v) / (abs(v) + gamma))
        angle = math.remainder(math.atan2(total.imag, total.real) - me.yaw, 2.0 * math.pi)
        sure(abs(total) > 1e-6 and abs(angle) < 3.1415)
        wheel = min(max(angle, -most), most)
        told.append((wheel / most, max(0.0, 1.0 - alpha * abs(wheel))))
    return told


coordinate = st.floats(-2.5, 2.5)
poses = st.builds(Pose, coordinate, coordinate, st.floats(-3.1, 3.1))


def apart(found):
    return all(
        math.hypot(a.x - b.x, a.y - b.y) > 1e-3 for k, a in enumerate(found) for b in found[:k]
    )


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(poses, min_size=3, max_size=3).filter(apart))
def test_a_command_is_that_of_the_papers_equations(found):
    *cars, target = found
    made = FlockDriver(lab(SQUASHING)).drive(
        0.0, tuple(seen(n, p) for n, p in zip(("blue", "red"), cars, strict=True)), target, True
    )
    for name, told in zip(("blue", "red"), naive(cars, target, sure=assume), strict=True):
        assert made[name] == pytest.approx(told, rel=1e-6, abs=1e-9)


def simulated(text, tracks, targets):
    """What the computer of simulated cars sends at each tick, put where the tracks have them."""
    one = lab(text)
    n = len(one.cars)
    flock = Flock(
        cars_for_rule(one.rule).name,
        world=world_of(one),
        start={"position": np.zeros((n, 2)), "heading": np.tile((1.0, 0.0), (n, 1))},
        rng=0,
        **(PERFECT | one.parameters),
    )
    first = flock.model.columns.index("fresh")
    for cars, target in zip(tracks, targets, strict=True):
        flock.position[:] = [(pose.x, pose.y) for pose in cars]
        flock.heading[:] = [(math.cos(pose.yaw), math.sin(pose.yaw)) for pose in cars]
        flock.speed[:] = flock.arrays.memory[first + SIGNALS.index("pace")] = 0.0
        flock.engine.surroundings.route[0, :2] = target.x, target.y
        flock.advance(1)
        at = first + SIGNALS.index("wheel sent 1")
        most = math.radians(flock.parameters.wheel_max)
        yield [
            (float(wheel) / most, float(throttle))
            for wheel, throttle in flock.arrays.memory[at : at + 2].T
        ]


@pytest.mark.parametrize(
    ("rule", "parameters"),
    [
        ("squashing", {}),
        ("squashing", {"k": 1.0, "c_align": 0.5, "alpha_turn": 0.7, "wheel_max": 30.0}),
        ("squashing", {"derivative": 0.1}),
        ("squashing", {"yields": "true"}),
        ("hwvem", {"r": 2.0}),
    ],
)
def test_driver_and_simulation_give_the_same_commands_to_the_bit(rule, parameters):
    rng = np.random.default_rng(5)
    names = [f"c{k}" for k in range(4)]
    text = text_of(4).replace('"squashing"', f'"{rule}"')
    table = "\n".join(f"{name} = {value}" for name, value in parameters.items())
    text = text.replace("[area]", f"[parameters]\n{table}\n\n[area]")
    tracks = [
        [Pose(*rng.uniform(-2.5, 2.5, 2), rng.uniform(-3.0, 3.0)) for _ in names] for _ in range(50)
    ]
    targets = [Pose(*rng.uniform(-2.0, 2.0, 2), 0.0) for _ in tracks]
    one = FlockDriver(lab(text))
    if one.parameters.yields:  # looks at speeds too, which are those of cars that stand
        near = [Pose(0.3 * k, 0.1 * k, 2.0 * k) for k in range(4)]
        tracks = [near] * len(tracks)
    for k, sent in enumerate(simulated(text, tracks, targets)):
        sightings = tuple(seen(*pair) for pair in zip(names, tracks[k], strict=True))
        told = one.drive(0.01 * k, sightings, targets[k], True)
        assert [told[name] for name in names] == sent


def closed_form(radius=2.0, target=1.1, top=1.0, alpha=0.4, circle=0.95):
    """Lag (deg) of one car behind a target on a circle: the reading's closed form."""
    turn = target / radius
    length = 0.5 * circle
    delta = 0.0
    for _ in range(200):
        r = top * (1.0 - alpha * delta) / turn
        delta = math.atan(length / r)
    return math.degrees(0.5 * math.pi + delta - math.asin(r * math.cos(delta) / radius))


def test_one_emulated_car_settles_at_the_closed_forms_lag():
    text = SQUASHING[: SQUASHING.index("[cars.blue]")]
    one = lab(text)
    driver, plant, injected = (
        FlockDriver(one),
        EmulatedPlant(one),
        InjectedTarget(one.injected, one.area),
    )
    plant(0.0, {})
    told = {1: (0.0, 0.0)}
    lags = []
    for k in range(1, 4001):
        now = 0.01 * k
        plant(now, told)
        pose = plant.poses()["red"]
        target = injected.pose_at(now, True, ())
        told = {1: driver.drive(now, (seen("red", pose),), target, True)["red"]}
        lags.append(math.atan2(target.y, target.x) - math.atan2(pose.y, pose.x))
    lag = math.degrees(np.mean(np.remainder(lags[-500:], 2.0 * math.pi)))
    assert closed_form() == pytest.approx(55.9, abs=0.05)
    assert lag == pytest.approx(closed_form(), abs=1.0)


def test_nobody_is_told_anything_until_all_have_been_seen():
    driver = FlockDriver(lab(SQUASHING))
    red, blue = seen("red", Pose(0.0, 0.0, 0.0)), seen("blue", Pose(0.0, 1.0, 0.0))
    assert driver.drive(0.0, (), TARGET, True) == {}
    assert driver.drive(0.01, (red,), TARGET, True) == {}
    assert driver.drive(0.02, (blue, red), TARGET, True).keys() == {"red", "blue"}


def test_a_car_that_is_not_seen_is_told_nothing_and_heard_where_it_was_last():
    lone, both = (FlockDriver(lab(SQUASHING)) for _ in range(2))
    red, blue = seen("red", Pose(0.0, 0.0, 0.0)), seen("blue", Pose(0.0, 1.0, 0.0))
    for driver in (lone, both):
        driver.drive(0.0, (blue, red), TARGET, True)
    some = lone.drive(0.01, (red, unseen("blue"), seen("stranger", TARGET)), TARGET, True)
    assert some == {"red": both.drive(0.01, (red, blue), TARGET, True)["red"]}


def test_without_its_injected_car_nobody_is_told_anything():
    cars = seen("red", Pose(0.0, 0.0, 0.0)), seen("blue", Pose(0.0, 1.0, 0.0))
    assert FlockDriver(lab(SQUASHING)).drive(0.0, cars, None, True) == {}
    alone = SQUASHING.replace('path = "circle"\nradius = 2.0', 'path = "none"')
    # two cars 1 m apart attract each other: red is below blue and looks along x
    told = FlockDriver(lab(alone)).drive(0.0, cars, None, True)
    assert told["red"][0] == 1.0
    assert told["blue"][0] == -1.0


def test_tuning_changes_what_is_told_and_a_refusal_changes_nothing(driver):
    cars = seen("red", Pose(0.0, 0.0, 0.0)), seen("blue", Pose(0.0, 1.0, 0.0))
    before = driver.drive(0.0, cars, TARGET, True)
    for values, words in [
        ({"beta": 1.0, "gama": 1.0}, "unknown parameter 'gama'"),
        ({"alpha_turn": 9.0}, "alpha_turn = 9.* is outside"),
        ({"noise_xy": 0.1}, "noise_xy = .* is not allowed: it is of simulated cars"),
    ]:
        with pytest.raises(InputError, match=words):
            driver.tune(values)
    assert driver.drive(0.01, cars, TARGET, True) == before
    driver.tune({"alpha_turn": 0.0})
    assert {throttle for _, throttle in driver.drive(0.02, cars, TARGET, True).values()} == {1.0}


@pytest.mark.parametrize(
    ("rule", "words"),
    [
        ("squashin", "unknown rule 'squashin': did you mean 'squashing'"),
        ("reynolds", "rule reynolds cannot drive cars: it wishes acceleration"),
        ("boundary-points", "rule boundary-points cannot drive cars: it wishes acceleration"),
    ],
)
def test_a_rule_that_cannot_drive_cars_is_refused(rule, words):
    with pytest.raises(InputError, match=words):
        FlockDriver(lab(SQUASHING.replace('"squashing"', f'"{rule}"')))


def test_parameters_of_the_laboratory_are_checked():
    with pytest.raises(InputError, match="unknown parameter 'bet': did you mean 'beta'"):
        FlockDriver(lab(with_parameters(bet=1.0)))
    with pytest.raises(InputError, match=r"dropout = 0\.5 is not allowed"):
        FlockDriver(lab(with_parameters(dropout=0.5)))
