"""Observables of a flock with an agent that is nowhere, and of a flock of none, one or two."""

import math

import numpy as np
import pytest

from agents import Flock
from agents.catalogue import MODELS
from agents.observables.catalogue import OBSERVABLES
from agents.run_records import follow
from tests.left_out import quietly
from worlds.world import World

AT_ONE_TICK = [one.name for one in OBSERVABLES.values() if one.over is None]
ROOM = World(name="room", size=(12.0, 12.0), edges=("solid", "wrap"))


@pytest.mark.parametrize("array", ["position", "heading", "speed"])
@pytest.mark.parametrize("name", AT_ONE_TICK)
def test_an_agent_of_a_flock_that_is_nowhere_is_left_out(name, array):
    def flock(rows):
        rng = np.random.default_rng(8)
        angle = rng.uniform(0.0, math.tau, 30)
        start = {
            "position": rng.uniform(0.5, 11.5, (30, 2)),
            "heading": np.c_[np.cos(angle), np.sin(angle)],
            "speed": rng.uniform(0.5, 1.0, 30),
        }
        return Flock(
            "vem", start={key: value[rows] for key, value in start.items()}, world=ROOM, rng=1
        )

    made, fine = flock(np.arange(30)), flock(np.setdiff1d(np.arange(30), [0, 17]))
    getattr(made, array)[[0, 17]] = math.nan
    found, said = quietly(made.observe, name)
    np.testing.assert_equal(found, fine.observe(name))
    assert [(one.rows, one.of, one.what) for one in said] == [(2, 30, "agents")]


NONE = {
    "polarisation": 0.0, "lane-order": 0.0, "consistency": 1.0, "angular-momentum": 0.0,
    "groups": 0,
    "largest-group": 0, "mean-neighbours": 0.0, "nearest-neighbour": math.inf, "connectivity": 0.0,
    "obstacle-distance": math.inf, "inside-obstacles": 0, "group-polarisation": math.nan,
    "group-angular-momentum": math.nan, "correlation-length": math.nan, "goal-distance": math.nan,
    "following": math.nan, "drag-saved": math.nan, "energy-saved": math.nan, "group-sizes": {},
    "group-table": {}, "layers": {}, "velocity-spread": 0.0, "gyration-radius": 0.0,
    "entered": math.nan, "waiting-to-enter": math.nan, "direction": math.nan,
    "fast-in-front": math.nan,
}  # fmt: skip
"""What a flock of nobody has, but for `crashes`, which goes on telling of those that were, and for
what is told of exits."""
ONE = {
    "polarisation": 1.0, "lane-order": 1.0, "consistency": 1.0, "angular-momentum": 0.0,
    "groups": 1,
    "largest-group": 1, "group-polarisation": 1.0, "group-angular-momentum": 0.0,
    "mean-neighbours": 0.0, "nearest-neighbour": math.inf, "connectivity": 0.0,
    "correlation-length": math.nan, "group-sizes": {1: 1}, "velocity-spread": 0.0,
    "gyration-radius": 0.0,
    "group-table": {"agents": 1, "polarisation": 1.0, "angular-momentum": 0.0},
}  # fmt: skip
"""What a lone agent has, whatever it is and wherever; the rest depends on its world."""
MAY_BE_NAN = {
    "correlation-length", "crashes", "goal-distance", "following", "drag-saved", "energy-saved",
    "divergence", "direction", "fast-in-front",
    "entered", "waiting-to-enter", "exited", "flow", "catches", "kind-distance", "kind-mixing",
}  # fmt: skip
"""What a flock of two may lack."""


def of(name, n, **more):
    """A flock of n ordinary agents and its information agents; of none, all were taken out."""
    flock = Flock(name, agents=max(1, n), rng=1, **more)
    for member in list(flock.members) if n == 0 else []:
        member.remove()
    return flock


@pytest.fixture(scope="module")
def few():
    """Flocks of none, one and two: of every model where it is at home, and in other worlds."""
    elsewhere = [
        ("vem", {"dim": 3}),
        ("vem", {"world": ROOM}),
        ("vem", {"world": "open"}),
        ("vem", {"world": "wrap-plain"}),
        ("couzin", {"world": "rooms-3d"}),
        ("hwvem-nav", {"world": "obstacles"}),
        ("vem", {"informed": 0}),
    ]
    made = {n: [of(name, n) for name in MODELS] for n in (0, 1, 2)}
    for n, flocks in made.items():
        flocks += [of(name, n, **more) for name, more in elsewhere]
        ran = of("vem", n, eta=1.0)
        ran.run(3)
        flocks.append(ran)
    return made


@pytest.mark.parametrize("n", [0, 1, 2])
@pytest.mark.parametrize("name", AT_ONE_TICK)
def test_every_observable_is_defined_of_a_flock_of_none_of_one_and_of_two(name, n, few):
    """Never an exception, never a warning, and nan only where docs/observables.md says so."""
    for flock in few[n]:
        who = flock.model.name, flock.world.name
        value, said = quietly(flock.observe, name)
        assert said == [], who
        agents = len(flock.ids)
        assert agents == (n + flock.spec.informed if n else 0)
        expected = NONE if agents == 0 else ONE if agents == 1 else {}
        if name in expected:
            value = value[0] if name == "group-table" and agents == 1 else value
            assert value == pytest.approx(expected[name], abs=1e-15, nan_ok=True), who
        elif name not in MAY_BE_NAN and not isinstance(value, dict):
            assert not math.isnan(value), who


@pytest.mark.parametrize("name", ["susceptibility", "binder"])
def test_a_run_of_few_has_fluctuations_or_none(name, few):
    for n, expected in (
        (0, {"susceptibility": 0.0, "binder": math.nan}),
        (1, {"susceptibility": 0.0, "binder": 2.0 / 3.0}),
    ):
        series, said = quietly(follow, few[n][-1], 4, [name])
        assert said == []
        assert series.over(name) == pytest.approx(expected[name], abs=1e-12, nan_ok=True)
