"""Check many flocks in one call: each is, to the bit, the flock that it would be alone."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from agents.flock import Flock
from agents.kinds import Kind, chase
from agents.mesa_interface import Member
from flockscope import env, gym_env, vector_env
from flockscope._learning import spec_of
from tests.oracles.lone_player import LonePlayer
from worlds.input_error import InputError

ROBOT = Kind("robot", 1, steered=True)


def hunted(caught):
    """Sharks that catch the robot and ordinary agents."""
    relation = chase(3.0, 4.0, catch=0.3, caught=caught)
    return [ROBOT, Kind("shark", 2, v0=0.2, to={"robot": relation, "flock": relation})]


HUNTER = Kind("robot", 1, steered=True, v0=0.2, to={"flock": chase(1.0, 4.0, catch=0.4)})
FEW = {"size": 3.0, "eta": 0.2}
CASES = [
    ("vem", "align", {"size": 4.0}),
    ("vem", "evade", {"kinds": hunted("taken"), **FEW}),
    ("vem", "hunt", {"kinds": [HUNTER], **FEW}),
    ("couzin", "align", {"dim": 2}),
    ("vem", "align", {"dim": 3, "size": 4.0}),
    ("hwvem", "align", {"size": 4.0}),
    ("dorsogna", "align", {}),
    ("vem", "evade", {"kinds": hunted("frozen"), **FEW}),
    ("vem", "evade", {"kinds": hunted("moved"), **FEW}),
    ("vem", "align", {"world": "obstacles"}),
    ("vem", "align", {"eta": "normal(0.5, 0.1)", "size": 4.0}),
    ("vem", "align", {"wind": 0.05, "gusts": 0.02, "size": 4.0}),
    ("vem", "align", {"activation": "random", "size": 4.0}),
    ("vem", "align", {"delay": 2.0, "size": 4.0}),
    ("guarded", "evade", {"spacing": 0.0}),
]
QUICK = 4
"""The cases that run with every test; the others compile another loop each."""


def case_params():
    """All cases, those behind the first few marked."""
    for number, (model, reward, words) in enumerate(CASES):
        marks = () if number < QUICK else (pytest.mark.exhaustive,)
        yield pytest.param(model, reward, words, marks=marks, id=f"{number}-{model}")


def demand_same_flocks(flocks, alone):
    """Assert that the arrays of all flocks are those of lone ones, and their catches."""
    for one, flock in zip(alone, flocks.flocks, strict=True):
        assert (flock.tick, flock.seed) == (one.flock.tick, one.flock.seed)
        assert flock.spec == one.flock.spec
        for name in ("ids", "position", "heading", "speed", "kind", "own", "leg", "informed"):
            array = getattr(flock.arrays, name)
            assert array.tobytes() == getattr(one.flock.arrays, name).tobytes(), name
        assert np.array_equal(flock.catches.tick, one.flock.catches.tick)


def draw_actions(space, rng):
    """Actions for all flocks, often straight on."""
    return rng.uniform(-0.3, 0.3, space.shape)


@pytest.mark.parametrize("looked_at", [0, 69])
@pytest.mark.parametrize(("model", "reward", "words"), [*case_params()])
def test_each_flock_is_to_the_bit_what_it_would_be_alone(model, reward, words, looked_at):
    words = {"agents": 8, "kinds": [ROBOT], **words}
    number, ticks, k = 5, 25, 3
    flocks = vector_env(model, "robot", number, reward=reward, ticks=ticks, k=k, **words)
    seen, _ = flocks.reset(seed=7)
    alone = [
        LonePlayer(spec_of(model, {**words, "seed": 1 + e}), reward, ticks, k, 7 + e)
        for e in range(number)
    ]
    assert np.array_equal(seen, [one.see() for one in alone])
    rng, ended, ends = np.random.default_rng(0), np.zeros(number, bool), 0
    for tick in range(70):
        actions = draw_actions(flocks.action_space, rng)
        seen, gained, is_over, has_ended, _ = flocks.step(actions)
        for e, one in enumerate(alone):
            expected = (one.restart(), 0.0, False, False) if ended[e] else one.step(actions[e])
            assert np.array_equal(seen[e], expected[0])
            assert gained[e] == pytest.approx(expected[1], abs=1e-12)
            assert (is_over[e], has_ended[e]) == expected[2:]
        ended = is_over | has_ended
        ends += int(ended.sum())
        if tick == looked_at:
            demand_same_flocks(flocks, alone)
    demand_same_flocks(flocks, alone)
    assert ends >= number


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_gymnasiums_own_vector_of_single_environments_gives_the_same(mode):
    words = {"agents": 8, "kinds": hunted("taken"), "reward": "evade", "ticks": 12, **FEW}
    flocks = vector_env("vem", "robot", 3, seed=1, autoreset=mode, **words)
    singles = SyncVectorEnv(
        [lambda e=e: gym_env("vem", "robot", seed=1 + e, **words) for e in range(3)],
        autoreset_mode=mode,
    )
    assert flocks.observation_space == singles.observation_space
    assert flocks.action_space == singles.action_space
    for seed in (None, 3, [5, None, 9]):
        ours, theirs = flocks.reset(seed=seed), singles.reset(seed=seed)
        assert np.array_equal(ours[0], theirs[0])
        flocks.action_space.seed(1)
        for _ in range(40):
            actions = flocks.action_space.sample()
            ours, theirs = flocks.step(actions), singles.step(actions)
            for one, other in zip(ours[:4], theirs[:4], strict=True):
                assert np.array_equal(one, other)
            assert ours[4].keys() == theirs[4].keys()
            for e in np.flatnonzero(ours[4].get("_final_obs", [])):
                assert np.array_equal(ours[4]["final_obs"][e], theirs[4]["final_obs"][e])


@pytest.mark.parametrize("kinds", [[ROBOT], hunted("taken")], ids=["alone", "hunted"])
def test_flocks_that_nobody_asks_for_begin_anew_in_their_arrays(kinds, monkeypatch):
    """It takes a third of the time of `restart`, which is called once for each of them."""
    words = {"agents": 8, "kinds": kinds, "reward": "evade", "ticks": 5, **FEW}
    flocks, shown = vector_env("vem", "robot", 3, **words), vector_env("vem", "robot", 3, **words)
    restart, restarted = Flock.restart, []
    monkeypatch.setattr(Flock, "restart", lambda flock, s: restarted.append(restart(flock, s)))
    assert np.array_equal(flocks.reset(seed=1)[0], shown.reset(seed=1)[0])
    assert len(restarted) == 6
    assert np.array_equal(flocks.reset()[0], shown.reset()[0])
    assert len(restarted) == 6
    assert [flock.tick for flock in shown.flocks] == [0, 0, 0]
    assert len(restarted) == 9
    for _ in range(14):
        ours, theirs = flocks.step(np.zeros((3, 1))), shown.step(np.zeros((3, 1)))
        for one, other in zip(ours[:4], theirs[:4], strict=True):
            assert np.array_equal(one, other)
    if len(kinds) == 1:  # each has begun anew twice
        assert len(restarted) == 9 + 6
    for one, other in zip(flocks.flocks, shown.flocks, strict=True):
        assert (one.tick, one.seed) == (other.tick, other.seed)
        assert one.position.tobytes() == other.position.tobytes()


def test_a_flock_that_is_not_begun_anew_by_itself_waits_for_it():
    flocks = vector_env(
        "vem", "robot", 3, agents=5, kinds=[ROBOT], ticks=2, autoreset="Disabled", size=4.0
    )
    flocks.reset(seed=1)
    actions = np.zeros((3, 1))
    flocks.step(actions)
    assert flocks.step(actions)[3].all()
    with pytest.raises(InputError, match="flock 0 has ended"):
        flocks.step(actions)
    flocks.reset(options={"reset_mask": np.array([True, False, True])})
    with pytest.raises(InputError, match="flock 1 has ended"):
        flocks.step(actions)
    flocks.reset(options={"reset_mask": np.array([False, True, False])})
    assert not flocks.step(actions)[3].any()


def test_whoever_asks_for_a_flock_whose_player_was_caught_finds_the_catch():
    words = {"agents": 8, "kinds": hunted("taken"), "reward": "evade", "ticks": 200, **FEW}
    flocks = vector_env("vem", "robot", 4, **words)
    flocks.reset(seed=3)
    is_over = np.zeros(4, bool)
    while not is_over.any():
        is_over = flocks.step(np.zeros((4, 1)))[2]
    for flock, over in zip(flocks.flocks, is_over.tolist(), strict=True):
        assert bool(len(flock.rows_of("robot"))) != over
        assert (flock.tick in flock.catches.tick) or not over


def test_several_players_of_a_flock_are_a_team():
    team = Kind("robot", 3, steered=True)
    words = {"agents": 8, "ticks": 10, "size": 4.0, "kinds": [team]}
    flocks, players = vector_env("vem", "robot", 2, **words), env("vem", "robot", **words)
    seen, _ = flocks.reset(seed=4)
    one, _ = players.reset(seed=5)
    assert seen.shape == flocks.observation_space.shape
    assert np.array_equal(seen[1], list(one.values()))
    actions = draw_actions(flocks.action_space, np.random.default_rng(1))
    seen, gained, _, _, infos = flocks.step(actions)
    one, alone, *_ = players.step(dict(zip(players.agents, actions[1], strict=True)))
    assert np.array_equal(seen[1], list(one.values()))
    assert infos["gained"][1].tolist() == list(alone.values())
    assert gained[1] == infos["gained"][1].sum()


def test_a_reward_of_ones_own_is_asked_of_each_flock():
    flocks = vector_env(
        "vem", "robot", 3, agents=5, kinds=[ROBOT], size=4.0,
        reward=lambda result: np.full(len(result.ids), float(result.flock.tick)),
    )  # fmt: skip
    flocks.reset(seed=1)
    assert flocks.step(np.zeros((3, 1)))[1].tolist() == [1.0, 1.0, 1.0]
    assert flocks.step(np.zeros((3, 1)))[1].tolist() == [2.0, 2.0, 2.0]


def test_what_is_changed_in_a_flock_counts_from_the_next_tick_on():
    flocks = vector_env("vem", "robot", 2, agents=5, kinds=[ROBOT], size=4.0, eta=0.0)
    flocks.reset(seed=1)
    flocks.step(np.zeros((2, 1)))
    other = flocks.flocks[1]
    other.set(v0=0.0)
    before = other.position.copy()
    flocks.step(np.zeros((2, 1)))
    assert np.array_equal(other.position, before)
    assert other.tick == 2
    other.run(3)
    flocks.step(np.zeros((2, 1)))
    assert [flock.tick for flock in flocks.flocks] == [3, 6]


def test_agents_that_somebody_makes_are_there_from_the_next_tick_on():
    words = {"agents": 8, "kinds": hunted("taken"), "reward": "evade", "ticks": 50, **FEW}
    flocks = vector_env("vem", "robot", 2, **words)
    flocks.reset(seed=3)
    flock = flocks.flocks[1]
    for _ in range(30):
        Member(flock)
    flocks.step(np.zeros((2, 1)))
    assert len(flock.ids) + len(flock.catches.tick) == 41
    assert flock.tick == 1


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"number": 0}, "number = 0"),
        ({"number": 2.5}, "number = 2.5"),
        ({"autoreset": "Never"}, "unknown autoreset 'Never'"),
        ({"reward": "reach-goal"}, "reward reach-goal needs a goal"),
        ({"kinds": [Kind("robot", 1)]}, "kind robot is not steered"),
    ],
)
def test_what_is_wrong_is_refused_in_one_line(words, message):
    words = {"run": "vem", "kind": "robot", "number": 2, "kinds": [ROBOT], "agents": 5} | words
    with pytest.raises(InputError, match=message):
        vector_env(**words)


def test_actions_and_seeds_that_are_none_are_refused():
    flocks = vector_env("vem", "robot", 3, kinds=[ROBOT], agents=5)
    with pytest.raises(InputError, match="no flock has begun"):
        flocks.step(np.zeros((3, 1)))
    for seed, message in (
        ([1, 2], "2 seeds are not allowed: 3 are needed"),
        ([1, -2, 3], "seed of flock 1 = -2"),
        (-1, "seed = -1"),
        ("one", "seed = 'one'"),
    ):
        with pytest.raises(InputError, match=message):
            flocks.reset(seed=seed)
    flocks.reset(seed=1)
    for actions, message in (
        (np.zeros(3), r"actions have the shape \(3,\): numbers of the shape \(3, 1\)"),
        (np.zeros((2, 1)), r"actions have the shape \(2, 1\)"),
        ("left", r"actions have the shape \(0,\)"),
        ([[0.0], [np.nan], [0.0]], r"actions of flock 1 are \[nan\]: finite numbers"),
    ):
        with pytest.raises(InputError, match=message):
            flocks.step(actions)
    assert [flock.tick for flock in flocks.flocks] == [0, 0, 0]
    with pytest.raises(InputError, match="reset_mask"):
        flocks.reset(options={"reset_mask": [True]})


def test_the_benchmark_measures_a_step(monkeypatch, capsys):
    path = Path(__file__).parents[1] / "benchmarks" / "learning.py"
    spec = importlib.util.spec_from_file_location("learning_benchmark", path)
    benchmark = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(benchmark)
    for name, value in {"ROUNDS": 1, "STEPS": 20, "NUMBERS": (2,)}.items():
        monkeypatch.setattr(benchmark, name, value)
    monkeypatch.setattr(benchmark, "CASES", {"evade": benchmark.CASES["evade"]})
    monkeypatch.setattr("sys.argv", ["learning.py", "--json"])
    benchmark.main()
    (cost,) = json.loads(capsys.readouterr().out)
    assert min(cost["flocks"], cost["single"], cost["vector"]) > 0.0
    assert cost["ratio"] == pytest.approx(cost["single"] / cost["vector"])
    assert cost["reset_ratio"] == pytest.approx(cost["restart"] / cost["in_place"])
    assert cost["in_place"] > 0.0
