"""The squashing rule and the car that turns on the spot: exact values, closed forms, an oracle."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import cars as oracle

from agents import Flock
from worlds.mission import mission
from worlds.world import World

OPEN = World(name="open", size=(10.0, 10.0), edges=("open", "open"))
CIRCLE = 2.0
"""Radius of the injected car's circle in the world `cars-circle`, m."""
EXACT = {"noise_xy": 0.0, "noise_yaw": 0.0}


def around(goal):
    """An open world with an injected car at rest there."""
    return replace(OPEN, mission=mission({"goal": {"route": [list(goal)]}}))


def scene(rng, n):
    """n places at least 0.3 m apart, and headings."""
    position = rng.permutation(36)[:n]
    position = 0.8 * np.column_stack([position // 6, position % 6]) + rng.uniform(0, 0.5, (n, 2))
    angle = rng.uniform(0.0, 2.0 * np.pi, n)
    return position, np.column_stack([np.cos(angle), np.sin(angle)])


@settings(max_examples=80, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 9),
    k=st.integers(0, 4),
    predators=st.integers(0, 3),
    derivative=st.sampled_from((0.0, 0.02)),
    c_align=st.sampled_from((0.0, 0.3)),
    injected=st.booleans(),
    varied=st.sampled_from(("", "integral", "shape", "own", "all")),
)
def test_ticks_are_the_papers(seed, n, k, predators, derivative, c_align, injected, varied):
    rng = np.random.default_rng(seed)
    position, heading = scene(rng, n)
    shape = {
        "beta": rng.uniform(0.5, 3.0),
        "C": rng.uniform(0.1, 1.3),
        "gamma": rng.uniform(0.05, 1.0),
        "c_goal": rng.uniform(0.0, 3.0),
        "beta_p": rng.uniform(0.1, 2.0),
        "C_p": rng.uniform(1.0, 2.0),
    }
    more = {**shape, "k": k, "predators": predators, "derivative": derivative, "c_align": c_align}
    goal = rng.uniform(0.0, 4.0, 2) if injected else None
    if varied in ("integral", "all"):
        more |= {"integral": rng.uniform(0.1, 5.0), "windup": rng.uniform(0.01, 0.1)}
    if varied in ("shape", "all"):
        more |= {"power": rng.uniform(0.3, 4.0), "soft": rng.uniform(0.0, 1.0)}
    if varied in ("own", "all"):
        more |= {"sensing": "own", "alpha_s": rng.uniform(60.0, 360.0), "r": rng.uniform(1.0, 5.0)}
    world = OPEN if goal is None else around(goal)
    start = {"position": position, "heading": heading}
    flock = Flock("squashing", start=start, world=world, rng=1, **EXACT, **more)
    p, last = oracle.Cars(**more), None
    sums = np.zeros((n, 2))
    for _ in range(3):
        flock.run(1)
        d = np.array([oracle.desired(i, position, heading, goal, p) for i in range(n)])
        wish = d if last is None else d + derivative * (d - last) / p.dt
        sums = np.array([oracle.cut(s + p.dt * one, p) for s, one in zip(sums, d, strict=True)])
        wish = wish + p.integral * sums
        last, position = d, position + p.dt * wish
        length = np.linalg.norm(wish, axis=1, keepdims=True)
        heading = np.where(length > 1e-12, wish / np.where(length > 0, length, 1.0), heading)
        np.testing.assert_allclose(flock.position, position, atol=1e-9)
        np.testing.assert_allclose(flock.heading, heading, atol=1e-7)
        np.testing.assert_allclose(flock.speed, length[:, 0], atol=1e-9)


@pytest.mark.parametrize(
    ("apart", "pull"),
    [
        (1e-9, -1.4),
        (0.7 * 0.214 / 0.3, 0.0),
        (0.214, 2.0 * (0.5 - 0.7)),
        (1e6, 0.6),
    ],
    ids=["touching", "at rest", "half", "far"],
)
def test_the_squashing_function_has_the_values_of_figure_2(apart, pull):
    start = {"position": [(0.0, 0.0)], "heading": [(1.0, 0.0)]}
    flock = Flock("squashing", start=start, world=around((apart, 0.0)), rng=1, **EXACT)
    flock.run(1)
    assert flock.position[0] == pytest.approx([0.01 * pull, 0.0], abs=1e-8)


@pytest.mark.parametrize(("power", "soft"), [(1.0, 0.0), (2.0, 0.0), (0.5, 0.0), (1.0, 0.4)])
def test_the_shape_leaves_the_zero_and_the_far_end_where_they_are(power, soft):
    def pull(apart):
        start = {"position": [(0.0, 0.0)], "heading": [(1.0, 0.0)]}
        more = {"power": power, "soft": soft, "r": 200.0}
        flock = Flock("squashing", start=start, world=around((apart, 0.0)), rng=1, **EXACT, **more)
        flock.run(1)
        return flock.position[0, 0] / flock.dt

    zero = 0.7 * 0.214 / 0.3
    assert pull(zero) == pytest.approx(0.0, abs=1e-9)
    assert pull(0.5 * zero) < 0.0 < pull(2.0 * zero)
    assert pull(1e8) == pytest.approx(0.6, abs=0.002)
    slope = (pull(2e-4) - pull(1e-4)) / 1e-4
    plain = 2.0 / 0.214
    if power == 1.0 and soft == 0.0:
        assert slope == pytest.approx(plain, rel=0.01)
        assert pull(1e-9) == pytest.approx(-1.4)
    elif power > 1.0:
        assert abs(slope) < 0.01 * plain, "flat"
        assert pull(1e-9) == pytest.approx(-1.4)
    elif power < 1.0:
        assert slope > 3.0 * plain, "steep"
    else:
        assert slope < 0.5 * plain
        assert -0.7 < pull(1e-9) < 0.0, "they repel less"


def test_a_share_next_to_nothing_is_still_a_number():
    flock = Flock("squashing", agents=6, rng=0, world=OPEN, C=3.4e-285, power=6.0)
    assert np.isfinite(flock.trace(50)).all()


def test_own_sensors_tell_what_is_in_view_with_their_errors():
    start = {"position": [(5.0, 5.0), (7.0, 5.0), (3.0, 5.2)], "heading": [(1.0, 0.0)] * 3}
    own = {"sensing": "own", "alpha_s": 180.0, "c_goal": 1.0, **EXACT}
    flock = Flock("squashing", start=start, world=around((5.5, 7.0)), rng=4, **own)
    near = flock.inspect(0)
    heard = dict(zip(near.neighbours.tolist(), near.weights.tolist(), strict=True))
    assert heard == {1: 1.0, 2: 0.0}, "the one behind is not seen"
    assert np.linalg.norm(near.forces["injected car"]) > 0.0
    flock.set(alpha_s=140.0)
    assert np.linalg.norm(flock.inspect(0).forces["injected car"]) == 0.0
    flock.set(alpha_s=360.0, noise_bearing=0.1)
    turns = []
    position, ahead = np.array(start["position"]), np.array(start["heading"])
    for _ in range(400):
        flock.position[:], flock.heading[:] = position, ahead
        flock.run(1)
        x, y = oracle.desired(0, position, ahead, np.array([5.5, 7.0]), oracle.Cars())
        turns.append(math.atan2(*flock.heading[0][::-1]) - math.atan2(y, x))
    assert np.std(turns) == pytest.approx(0.1, rel=0.15)
    assert abs(np.mean(turns)) < 0.02


def test_two_cars_settle_where_the_function_is_zero_and_beta_is_only_the_pace():
    for beta in (1.0, 2.0):
        start = {"position": [(4.0, 5.0), (5.5, 5.0)], "heading": [(1.0, 0.0)] * 2}
        flock = Flock("squashing", start=start, world=OPEN, rng=1, beta=beta, **EXACT)
        flock.run(4000)
        assert np.linalg.norm(flock.position[1] - flock.position[0]) == pytest.approx(0.4993333)


@pytest.mark.parametrize(("speed", "published"), [(0.3, 32.0), (0.5, 47.0), (0.8, 62.0)])
def test_a_car_that_turns_on_the_spot_lags_as_the_closed_form_says(speed, published):
    lag = oracle.zero_turn_behind_a_circle(CIRCLE, speed, oracle.Cars())
    assert math.degrees(lag) == pytest.approx(published, abs=1.0)
    flock = Flock("squashing", agents=1, rng=3, world=slowed(speed))
    flock.run(int(3.0 * 2.0 * np.pi * CIRCLE / speed / 0.01))
    assert phase_lag(flock)[0] == pytest.approx(math.degrees(lag), abs=0.3)


def slowed(speed):
    """The world `cars-circle` with its injected car at that speed (m/s)."""
    circle = Flock("squashing", agents=1, rng=1).world
    goal = circle.mission.goal.model_copy(update={"speed": speed})
    return replace(circle, mission=circle.mission.model_copy(update={"goal": goal}))


def phase_lag(flock):
    """How far each car is behind the injected one, seen from the circle's centre, deg (N,)."""
    gx, gy = flock.goal_at([flock.tick])[0]
    angle = np.arctan2(flock.position[:, 1], flock.position[:, 0])
    return np.degrees(np.arctan2(gy, gx) - angle) % 360.0


def test_the_error_of_the_tracking_is_told_and_has_the_asked_spread():
    flock = Flock("squashing", agents=40, rng=2, world="open", size=20.0, noise_xy=0.02)
    told = []
    for _ in range(50):
        flock.run(1)
        told.append([flock.signal("error_x"), flock.signal("error_y")])
    told = np.array(told)
    assert told.std() == pytest.approx(0.02, rel=0.05)
    assert abs(told.mean()) < 0.002
    assert abs((told[1:] * told[:-1]).mean()) < 0.05 * 0.02**2


def test_a_car_that_is_not_seen_counts_as_where_it_was_seen_last():
    start = {"position": [(5.0, 5.0), (6.0, 5.0)], "heading": [(1.0, 0.0)] * 2}
    flock = Flock("squashing", start=start, world=around((8.0, 5.0)), rng=5, dropout=0.7, **EXACT)
    held = 0
    before = flock.position[:, 0] + flock.signal("error_x")
    for _ in range(60):
        flock.run(1)
        seen = flock.position[:, 0] + flock.signal("error_x")
        late = np.abs(flock.signal("error_x")) > 1e-12
        np.testing.assert_allclose(seen[late], before[late], atol=2e-3)
        held += late.sum()
        before = seen
    assert 0.5 < held / 120 < 0.9


def test_looking_does_not_change_the_run():
    runs = []
    for looks in (False, True):
        flock = Flock("squashing", agents=5, rng=7, dropout=0.4, noise_xy=0.01, derivative=0.05)
        for _ in range(40):
            flock.run(1)
            if looks:
                flock.signals()
                flock.inspect(2)
        runs.append(flock.position.copy())
    np.testing.assert_array_equal(*runs)


def test_the_named_terms_add_up_to_the_wish():
    flock = Flock("squashing", agents=6, rng=4, predators=1, c_align=0.4, derivative=0.1, k=2)
    flock.run(20)
    for row in range(6):
        seen = flock.inspect(row)
        assert list(seen.forces) == list(flock.model.rule.forces)
        total = sum(seen.forces.values())
        flock.engine.open(flock.context, flock.tick)
        before = flock.position[row].copy()
        ahead = Flock.from_spec(flock.spec)
        ahead.run(flock.tick + 1)
        np.testing.assert_allclose(ahead.position[row], before + 0.01 * total, atol=1e-9)


def test_cars_hear_the_k_nearest_and_always_the_predators():
    start = {
        "position": [(9.0, 9.0), (1.0, 1.0), (2.0, 1.0), (4.0, 1.0), (7.0, 1.0)],
        "heading": [(1.0, 0.0)] * 5,
    }
    flock = Flock("squashing", start=start, world=OPEN, rng=1, k=2, predators=1)
    seen = flock.inspect(1)
    heard = dict(zip(seen.neighbours.tolist(), seen.weights.tolist(), strict=True))
    assert heard == {0: 1.0, 2: 1.0, 3: 1.0, 4: 0.0}
