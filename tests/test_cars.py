"""Cars that steer: the closed form on a circle, ticks against an oracle, contact, link."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import cars as oracle
from oracles import couzin

from agents import Flock, catalogue
from agents.bodies.car import driving
from agents.bodies.car_commands import separation
from agents.rules import vicsek
from worlds.input_error import InputError
from worlds.mission import mission
from worlds.world import World

OPEN = World(name="open", size=(40.0, 40.0), edges=("open", "open"))
EXACT = {"noise_xy": 0.0, "noise_yaw": 0.0}
PROMPT = {**EXACT, "latency": 0.0, "hop": 0.0}
CAR = {"length": 0.22, "width": 0.12}


def behind(radius, speed, corners=720):
    """An open world with an injected car on a circle about the origin, in as many straight legs."""
    turn = 2.0 * math.pi / corners
    r = radius * 0.5 * turn / math.sin(0.5 * turn)
    route = [[r * math.cos(k * turn), r * math.sin(k * turn)] for k in range(corners)]
    return replace(
        OPEN, mission=mission({"goal": {"route": route, "speed": speed, "closed": True}})
    )


def at_rest(goal):
    """An open world with an injected car at rest."""
    return replace(OPEN, mission=mission({"goal": {"route": [list(goal)]}}))


@pytest.mark.parametrize(
    ("radius", "speed", "more"),
    [
        (2.0, 1.1, {}),
        (2.0, 1.0, {}),
        (2.5, 1.2, {}),
        (3.0, 1.3, {"v_max": 1.2}),
        (2.0, 1.1, {"alpha_turn": 0.0}),
        (2.0, 1.1, {"alpha_turn": 0.8}),
        (2.0, 1.1, {"circle": 1.3}),
        (4.0, 2.4, {"v_max": 2.0, "circle": 1.6, "alpha_turn": 0.6}),
        (1.5, 0.55, {"v_max": 0.5, "circle": 0.6, "lag": 0.4}),
        (2.0, 1.15, {"wheel_max": 30.0, "circle": 1.2, "servo": 3.0}),
    ],
)
def test_one_car_behind_a_circle_is_where_the_closed_form_says(radius, speed, more):
    p = oracle.Cars(**more)
    r, lag = oracle.behind_a_circle(radius, speed, p)
    world = behind(radius, speed)
    start = {"position": [(r * math.cos(-lag), r * math.sin(-lag))], "heading": [(0.5, 1.0)]}
    flock = Flock("squashing-cars", start=start, world=world, rng=1, **PROMPT, **more)
    flock.run(int(5 * 2.0 * math.pi * radius / speed / p.dt))
    gx, gy = flock.goal_at([flock.tick])[0]
    x, y = flock.position[0]
    behind_by = (math.atan2(gy, gx) - math.atan2(y, x)) % (2.0 * math.pi)
    assert math.degrees(behind_by) == pytest.approx(math.degrees(lag), abs=1.0)
    assert math.hypot(x, y) == pytest.approx(r, rel=0.01)


def test_the_closed_form_has_the_readings_figures():
    r, lag = oracle.behind_a_circle(2.0, 1.1, oracle.Cars())
    assert r == pytest.approx(1.609, abs=5e-4)
    assert math.degrees(lag) == pytest.approx(55.9, abs=0.05)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 6),
    latency=st.sampled_from((0.0, 0.02, 0.05)),
    hop=st.sampled_from((0.0, 0.01, 0.03)),
    derivative=st.sampled_from((0.0, 0.05)),
    injected=st.booleans(),
)
def test_ticks_are_the_oracles(seed, n, latency, hop, derivative, injected):
    rng = np.random.default_rng(seed)
    place = rng.permutation(25)[:n]
    position = 1.5 * np.column_stack([place // 5, place % 5]) + rng.uniform(0.0, 0.5, (n, 2))
    angle = rng.uniform(0.0, 2.0 * np.pi, n)
    heading = np.column_stack([np.cos(angle), np.sin(angle)])
    speed = rng.uniform(0.0, 1.0, n)
    more = {
        "latency": latency,
        "hop": hop,
        "derivative": derivative,
        "v_max": rng.uniform(0.5, 2.0),
        "alpha_turn": rng.uniform(0.0, 1.0),
        "wheel_max": rng.uniform(20.0, 60.0),
        "circle": rng.uniform(0.5, 2.0),
        "lag": rng.uniform(0.02, 0.5),
        "servo": rng.uniform(2.0, 20.0),
    }
    goal = np.array([3.0, 2.7]) + rng.uniform(-0.2, 0.2, 2) if injected else None
    world = OPEN if goal is None else at_rest(goal)
    start = {"position": position, "heading": heading, "speed": speed}
    flock = Flock("squashing-cars", start=start, world=world, rng=1, **EXACT, **more)
    plant = oracle.Plant(position, heading, speed, oracle.Cars(**more))
    for _ in range(25):
        assume(turns_clearly(plant, goal))
        flock.run(1)
        plant.tick(goal)
        np.testing.assert_allclose(flock.position, plant.x, atol=1e-7)
        np.testing.assert_allclose(flock.heading, plant.heading, atol=1e-6)
        np.testing.assert_allclose(flock.speed, plant.v, atol=1e-9)
        np.testing.assert_allclose(flock.signal("steering"), plant.steering, atol=1e-6)


def turns_clearly(plant, goal):
    """Whether nobody wishes to go straight back or nowhere, where the last bits decide the side."""
    for i in range(len(plant.x)):
        d = oracle.desired(i, plant.x, plant.heading, goal, plant.p)
        if plant.last[i] is not None:
            d = d + plant.p.derivative * (d - plant.last[i]) / plant.p.dt
        length = np.linalg.norm(d)
        if length < 1e-3 or d @ plant.heading[i] < -0.99999 * length:
            return len(plant.x) == 1 and goal is None
    return True


@settings(max_examples=300, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1))
def test_separation_tells_overlap_and_is_no_more_than_the_distance(seed):
    rng = np.random.default_rng(seed)
    dx, dy = rng.uniform(-0.35, 0.35, 2)
    a, b = rng.uniform(0.0, 2.0 * np.pi, 2)
    length, width = rng.uniform(0.1, 0.4), rng.uniform(0.05, 0.3)
    one = oracle.rectangle(0.0, 0.0, a, length, width)
    other = oracle.rectangle(dx, dy, b, length, width)
    gap = separation(dx, dy, math.cos(a), math.sin(a), math.cos(b), math.sin(b), length, width)
    assume(abs(gap) > 1e-9)
    assert (gap < 0.0) == one.intersects(other)
    assert gap <= one.distance(other) + 1e-12


def test_separation_is_the_distance_where_sides_face():
    assert separation(1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.22, 0.12) == pytest.approx(0.78)
    assert separation(0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.22, 0.12) == pytest.approx(0.88)
    assert separation(1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.22, 0.12) == pytest.approx(0.83)


def head_on(**more):
    """Two cars that drive at each other, each drawn by a car beyond the other."""
    start = {"position": [(1.0, 1.0), (3.0, 1.0)], "heading": [(1.0, 0.0), (-1.0, 0.0)]}
    return Flock("squashing-cars", start=start, world=OPEN, rng=1, C=0.0, hop=0.0, **EXACT, **more)


def test_cars_that_meet_head_on_stop_each_other_and_are_stuck():
    flock = head_on()
    flock.run(1000)
    assert (flock.signal("stops") > 100).all()
    assert abs(flock.signal("clearance")).max() < 0.03
    place = flock.position.copy()
    flock.run(500)
    np.testing.assert_allclose(flock.position, place, atol=0.02)
    assert len(flock.crashes) == 0


def test_a_car_that_is_stuck_backs_out_if_it_may():
    flock = head_on(reverse=True)
    trace = flock.trace(1500)
    apart = np.linalg.norm(trace[:, 1] - trace[:, 0], axis=1)
    assert apart.min() < 0.24
    first = int(apart.argmin())
    assert apart[first:].max() > 0.5


def test_cars_that_crash_are_out_of_the_run():
    flock = head_on(contact="crashes")
    flock.run(1000)
    assert flock.crashes.id.tolist() == [1, 2]
    assert set(flock.crashes.cause.tolist()) == {1}
    assert not flock.active.any()


def test_cars_at_the_very_same_place_crash_and_a_lone_one_does_not():
    start = {
        "position": [(1.0, 1.0), (1.0, 1.0), (3.0, 3.0), (3.0, 3.0), (5.0, 1.0)],
        "heading": [(1.0, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 0.0)],
    }
    flock = Flock(
        "squashing-cars", start=start, world=OPEN, rng=1, C=0.0, hop=0.0, contact="crashes", **EXACT
    )
    flock.run(1)
    assert flock.active.tolist() == [False, False, False, False, True]
    assert set(flock.crashes.cause.tolist()) == {1}


def test_a_wall_stops_a_car():
    walls = World(name="walls", size=(4.0, 4.0), edges=("solid", "solid"))
    goal = replace(walls, mission=mission({"goal": {"route": [[10.0, 2.0]]}}))
    start = {"position": [(2.0, 2.0)], "heading": [(1.0, 0.0)]}
    flock = Flock("squashing-cars", start=start, world=goal, rng=1, **PROMPT)
    flock.run(600)
    assert 3.87 < flock.position[0, 0] <= 3.891
    assert flock.speed[0] == 0.0


def test_a_lost_command_leaves_the_one_before_in_force():
    start = {"position": [(2.0, 2.0)], "heading": [(1.0, 0.0)]}
    world = at_rest((2.0, 6.0))
    deaf = Flock("squashing-cars", start=start, world=world, rng=1, loss=1.0, **PROMPT)
    deaf.run(100)
    np.testing.assert_array_equal(deaf.position, [(2.0, 2.0)])
    half = Flock("squashing-cars", start=start, world=world, rng=1, loss=0.5, **PROMPT)
    kept = []
    for _ in range(400):
        before = half.signal("wheel")[0]
        half.run(1)
        kept.append(half.signal("wheel")[0] == before != half.signal("wheel sent 1")[0])
    assert 0.0 < np.mean(kept) < 0.7
    assert half.position[0, 1] > 3.0


def test_a_car_that_is_not_seen_is_sent_its_last_command_again():
    start = {"position": [(2.0, 2.0)], "heading": [(1.0, 0.0)]}
    flock = Flock(
        "squashing-cars", start=start, world=at_rest((2.0, 6.0)), rng=1, dropout=1.0, **PROMPT
    )
    flock.run(100)
    np.testing.assert_array_equal(flock.position, [(2.0, 2.0)])


def test_commands_come_later_hop_by_hop():
    start = {"position": [(5.0 * k, 0.0) for k in range(4)], "heading": [(1.0, 0.0)] * 4}
    flock = Flock(
        "squashing-cars", start=start, world=at_rest((8.0, 50.0)), rng=1, hop=0.03, **EXACT
    )
    first = np.full(4, -1)
    for tick in range(20):
        flock.run(1)
        first[(flock.speed > 0.0) & (first < 0)] = tick
    np.testing.assert_array_equal(first, [4, 7, 10, 13])  # 6 ms and 30 ms a hop, in ticks of 10 ms


def phase(flock, laps):
    """Lags (rad) behind the injected car, tick by tick over the last lap, (T, N)."""
    goal = flock.world.mission.goal
    lap = int(2.0 * math.pi * 2.0 / goal.speed / flock.dt)
    flock.run(laps * lap)
    begin = flock.tick
    trace = flock.trace(lap)
    gx, gy = flock.goal_at(np.arange(begin + 1, begin + lap + 1)).T
    angle = np.arctan2(gy, gx)[:, None] - np.arctan2(trace[:, :, 1], trace[:, :, 0])
    return np.unwrap(angle, axis=0), trace


def is_locked(flock, laps=4):
    """Whether all cars keep to the injected one for a lap, none stuck, stopped or outside."""
    lag, trace = phase(flock, laps)
    inside = (np.abs(trace) < (3.05, 3.355)).all()
    return bool(
        inside
        and (np.abs(lag[-1] - lag[0]) < math.radians(45.0)).all()
        and (np.ptp(lag, axis=0) < math.radians(90.0)).all()
        and not flock.signal("stops").any()
    )


def aligned(n, seed):
    """Cars in two columns behind the injected car of `cars-circle`: it is at (2, 0), going up."""
    rng = np.random.default_rng(seed)
    k = np.arange(n)
    place = np.column_stack([1.6 - 0.5 * (k % 2), -0.6 - 0.5 * (k // 2)])
    angle = 0.5 * np.pi + rng.normal(0.0, 0.05, n)
    return {
        "position": place + rng.normal(0.0, 0.03, (n, 2)),
        "heading": np.column_stack([np.cos(angle), np.sin(angle)]),
    }


@pytest.mark.parametrize(
    ("model", "n", "least", "most"),
    [
        ("squashing-cars", 4, 6, 6),
        ("squashing-cars", 6, 0, 0),
        pytest.param("squashing-best", 6, 6, 6, marks=pytest.mark.long),
        pytest.param("squashing-best", 8, 6, 6, marks=pytest.mark.long),
    ],
)
def test_aligned_starts(model, n, least, most):
    """All four plain cars lock and no six do; the best mix locks six and eight (100 of 100)."""
    runs = [Flock(model, start=aligned(n, s), world="cars-circle", rng=s) for s in range(1, 7)]
    assert least <= sum(map(is_locked, runs)) <= most


def test_random_starts_mostly_fail_unless_cars_yield():
    """7 of 100 runs of plain cars end well, 94 of 100 of the best mix; here the first dozen."""
    seeds = range(1, 13)
    plain = sum(is_locked(Flock("squashing-cars", agents=4, rng=s)) for s in seeds)
    best = sum(is_locked(Flock("squashing-best", agents=4, rng=s)) for s in seeds)
    assert plain <= 4
    assert best >= 10


def test_a_rule_that_wishes_a_heading_turns_the_wheels_towards_it():
    flock = Flock("couzin-cars", rng=2, sigma=0.0, yields=False, **PROMPT)
    p = couzin.Zones(r_r=0.8, dr_o=2.0, dr_a=3.2)
    begin = {"position": flock.position.copy(), "heading": flock.heading.copy()}
    alone = Flock("couzin-cars", start=begin, world=OPEN, rng=1, sigma=0.0, yields=False, **PROMPT)
    alone.run(1)
    for row, (ux, uy) in enumerate(begin["heading"]):
        want = couzin.wanted(row, begin["position"], begin["heading"], p)
        x, y = (ux, uy) if want is None else want
        off = math.remainder(math.atan2(y, x) - math.atan2(uy, ux), 2.0 * math.pi)
        wheel = min(max(off, -0.25 * math.pi), 0.25 * math.pi)
        assert alone.signal("wheel sent 1")[row] == pytest.approx(wheel, abs=1e-9)


@pytest.mark.parametrize(
    "model", ["couzin-cars", pytest.param("hwvem-cars", marks=pytest.mark.exhaustive)]
)
def test_a_rule_of_headings_aligns_cars_that_turn_no_tighter_than_their_circle(model):
    flock = Flock(model, rng=2)
    turns = []
    for _ in range(400):
        heading = flock.heading.copy()
        flock.run(10)
        assert flock.speed.max() <= flock.parameters.v_max
        turns.append(np.arccos(np.clip((heading * flock.heading).sum(axis=1), -1.0, 1.0)))
    assert np.max(turns) <= 0.1 * flock.parameters.v_max / (0.5 * flock.parameters.circle) + 1e-9
    assert flock.observe("polarisation") > 0.8


def test_a_rule_with_a_parameter_of_the_cars_own_cannot_drive_them():
    class Wide(vicsek.VEM.parameters):
        width: float = vicsek.VEM.parameters.model_fields["r"]

    rule = replace(vicsek.VEM, name="wide", parameters=Wide)
    with pytest.raises(TypeError, match="rule wide and the car both have a parameter width"):
        driving(rule)


def test_cars_are_on_a_plane():
    with pytest.raises(InputError, match="dim = 3 is not allowed: couzin-cars is defined in 2-D"):
        Flock("couzin-cars", dim=3, rng=1)


@pytest.mark.exhaustive
def test_a_rule_that_wishes_a_heading_drives_cars_by_its_name(monkeypatch):
    monkeypatch.setattr(catalogue, "MODELS", dict(catalogue.MODELS))
    flock = Flock("hwvem-cars", rng=3)
    flock.advance(50)
    assert flock.model.name == "hwvem-cars"
    assert flock.world.name == "cars-torus"
    assert flock.speed.min() > 0.5
    again = Flock.from_spec(flock.spec)
    again.advance(50)
    np.testing.assert_array_equal(again.position, flock.position)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("boundary-points-cars", "boundary-points cannot drive cars: it wishes acceleration"),
        ("thesis-cars", "thesis cannot drive cars: it wishes velocity"),
        ("squashing-best-cars", "unknown model 'squashing-best-cars'"),
        ("vems-cars", "unknown model 'vems-cars'"),
    ],
)
def test_a_rule_that_cannot_drive_cars_is_refused(name, words):
    with pytest.raises(InputError, match=words):
        Flock(name)
