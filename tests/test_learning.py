"""Check a flock as an environment: the libraries' own tests, what is seen and what is gained."""

from __future__ import annotations

import importlib.util
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.kinds import Kind, chase
from app.learning.rewards import rewards
from flockscope import env, gym_env
from worlds.input_error import InputError

ROBOTS = Kind("robot", 3, steered=True)


def still(env, names):
    """Actions that wish to go straight on."""
    return {name: np.zeros(env.action_space(name).shape, np.float32) for name in names}


@pytest.mark.parametrize("model", ["vem", "couzin", "dorsogna"])
def test_pettingzoos_own_tests_pass(model):
    from pettingzoo.test import parallel_api_test, parallel_seed_test

    def build():
        return env(model, "robot", agents=12, kinds=[ROBOTS], ticks=20)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        parallel_api_test(build(), num_cycles=60)
        parallel_seed_test(build, num_cycles=20)


def test_gymnasiums_own_check_passes():
    from gymnasium.utils.env_checker import check_env

    single = gym_env("vem", "robot", agents=12, kinds=[Kind("robot", 1, steered=True)], ticks=20)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*render.*")
        check_env(single)


def naive_view(flock, row, k, reach):
    """What the agent of a row sees of the k nearest in the plane, one agent after the other."""
    size = np.array(flock.world.size)
    away = flock.position - flock.position[row]
    away -= size * np.floor(away / size + 0.5)
    distance = np.linalg.norm(away, axis=1)
    distance[row] = np.inf
    ahead = flock.heading[row]
    left = np.array([-ahead[1], ahead[0]])
    numbers = []
    for j in np.argsort(distance, kind="stable")[:k]:
        if distance[j] > reach:
            numbers += [0.0] * 6
            continue
        numbers += [away[j] @ ahead / reach, away[j] @ left / reach]
        numbers += [flock.heading[j] @ ahead, flock.heading[j] @ left]
        numbers += [flock.arrays.kind[j] / 9.0, 1.0]
    return np.array(numbers)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 8))
def test_players_see_the_nearest_in_their_own_frame(seed, k):
    players = env("vem", "robot", agents=15, kinds=[ROBOTS], k=k, size=4.0)
    seen, _ = players.reset(seed)
    flock = players.flock
    for name, identity in players.ids.items():
        row = int(np.flatnonzero(flock.ids == identity)[0])
        expected = naive_view(flock, row, k, flock.reach)
        assert np.allclose(seen[name][: 6 * k], expected, atol=1e-6)


def test_a_player_turns_as_it_acts():
    players = env("vem", "robot", agents=15, kinds=[ROBOTS], eta=0.0)
    players.reset(1)
    rows = players.flock.rows_of("robot")
    before = players.flock.heading[rows].copy()
    players.step({name: [0.5] for name in players.agents})
    left = np.column_stack([-before[:, 1], before[:, 0]])
    assert np.allclose(players.flock.heading[rows], left)


def test_who_is_caught_is_done_and_the_others_play_on():
    sharks = Kind("shark", 4, v0=0.09, to={"robot": chase(3.0, 3.0, catch=0.1)})
    players = env(
        "vem", "robot", agents=5, kinds=[ROBOTS, sharks], size=3.0, reward="evade", ticks=400
    )
    players.reset(3)
    done = {}
    while players.agents:
        names = list(players.agents)
        _, gained, over, ended, _ = players.step(still(players, names))
        for name in names:
            if over[name]:
                done[name] = gained[name]
                assert name not in players.agents
    assert done
    assert set(done.values()) == {-10.0}
    assert players.flock.tick <= 400
    assert any(ended.values()) or len(done) == 3


@pytest.mark.parametrize("reward", sorted(rewards()))
def test_every_reward_is_a_finite_number_for_each_player(reward):
    model = "boundary-points" if reward == "reach-goal" else "vem"
    players = env(model, "robot", agents=10, kinds=[ROBOTS], reward=reward)
    players.reset(1)
    for _ in range(5):
        _, gained, _, _, _ = players.step(still(players, players.agents))
        assert all(np.isfinite(value) for value in gained.values())


def test_a_reward_of_ones_own():
    players = env(
        "vem", "robot", agents=10, kinds=[ROBOTS], reward=lambda result: result.rows * 0.0
    )
    players.reset(1)
    assert set(players.step(still(players, players.agents))[1].values()) == {0.0}
    wrong = env("vem", "robot", agents=10, kinds=[ROBOTS], reward=lambda _: [np.nan])
    wrong.reset(1)
    with pytest.raises(InputError, match="3 finite numbers are needed"):
        wrong.step(still(wrong, wrong.agents))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"kind": "robott"}, "unknown kind 'robott'"),
        ({"kinds": [Kind("robot", 2)]}, "kind robot is not steered"),
        ({"k": 0}, "k = 0"),
        ({"reward": "win"}, "unknown reward 'win'"),
        ({"scale": 0.0}, "scale = 0.0 is not allowed"),
        ({"ticks": 0}, "ticks = 0"),
    ],
)
def test_what_is_wrong_is_refused_in_one_line(words, message):
    words = {"run": "vem", "kind": "robot", "kinds": [ROBOTS], "agents": 5} | words
    with pytest.raises(InputError, match=message):
        env(**words)


@pytest.mark.parametrize("action", [[np.nan], [1.0, 2.0], "left"])
def test_an_action_that_is_none_is_refused(action):
    players = env("vem", "robot", agents=5, kinds=[ROBOTS])
    players.reset(1)
    actions = still(players, players.agents)
    with pytest.raises(InputError, match=r"action of robot_1 is .* finite numbers"):
        players.step(actions | {"robot_1": action})
    with pytest.raises(InputError, match="actions have none of robot_0"):
        players.step({})


def test_the_example_of_the_docs_learns(monkeypatch, capsys, tmp_path):
    path = Path(__file__).parent.parent / "docs" / "learn_to_evade.py"
    spec = importlib.util.spec_from_file_location("learn_to_evade", path)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    few = {"TICKS": 20, "GENERATIONS": 2, "POLICIES": 5, "SEEDS": (0, 1), "UNSEEN": (1000,)}
    for name, value in few.items():
        monkeypatch.setattr(example, name, value)
    monkeypatch.setattr("sys.argv", ["learn_to_evade.py", "--out", str(tmp_path / "curve.png")])
    example.main()
    assert "generation  2: best" in capsys.readouterr().out
    assert (tmp_path / "curve.png").stat().st_size > 1000


def test_several_agents_are_none_for_gymnasium():
    with pytest.raises(InputError, match="kind robot has 3 agents"):
        gym_env("vem", "robot", agents=5, kinds=[ROBOTS])
