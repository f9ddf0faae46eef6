"""Check policies: they fly a kind as they say, and whatever one does, the run goes on."""

from __future__ import annotations

import json
import re
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from agents import catalogue, policy_process
from agents.flock import Flock
from agents.kinds import Kind
from agents.motion.agent_view import AgentView, wishes_of_actions
from agents.policies import POLICIES, Policy
from agents.spec import Spec
from app.cli.main import app
from worlds.input_error import InputError

CLI = CliRunner()
TURN = """
import numpy as np
from flockscope import policy

@policy(k=3, timeout={timeout}{options})
def turn(seen):
    {body}
"""
LEFT = "return np.full((len(seen), 1), 0.25)"


@pytest.fixture(autouse=True)
def _no_policy_stays():
    """Whoever comes next knows no policy of these."""
    files = dict(catalogue.FILES)
    yield
    POLICIES.clear()
    catalogue.FILES.clear()
    catalogue.FILES.update(files)
    for process in policy_process.PROCESSES.values():
        process.end()
    policy_process.PROCESSES.clear()


def write(tmp_path: Path, body: str = LEFT, options: str = "", timeout: float = 60.0) -> str:
    """The file of a policy with this body, which a busy machine does not make late."""
    path = tmp_path / "turn.py"
    path.write_text(TURN.format(body=body, options=options, timeout=timeout), "utf-8")
    return str(path)


def flown(
    tmp_path: Path,
    body: str = LEFT,
    options: str = "",
    model: str = "vem",
    timeout: float = 60.0,
    agents: int = 2,
) -> Flock:
    """A flock with two agents that a policy flies, and the lines that it tells."""
    policy = catalogue.from_file(write(tmp_path, body, options, timeout))
    assert isinstance(policy, Policy)
    kinds = [Kind("robot", agents, policy=policy.name)]
    flock = Flock(Spec(model, agents=20, seed=2, kinds=kinds))
    if model == "vem":
        flock.set(eta=0.0)
    flock.tell = (lines := []).append
    flock.lines = lines
    return flock


def test_agents_do_what_their_policy_says(tmp_path):
    flock = flown(tmp_path)
    rows = flock.rows_of("robot")
    before = flock.heading[rows].copy()
    flock.run(3)
    turned = np.pi * 0.25 * 3
    cos, sin = np.cos(turned), np.sin(turned)
    expected = before @ np.array([[cos, sin], [-sin, cos]])
    assert np.allclose(flock.heading[rows], expected)
    assert not flock.faults
    assert not flock.lines


def test_a_policy_sees_what_a_player_of_the_environment_sees(tmp_path):
    """It turns by what it sees first: so its actions show it."""
    flock = flown(tmp_path, "return 0.5 * seen[:, 1]", agents=7)
    twin = Flock(flock.spec.but(kinds=[Kind("robot", 7, steered=True)]))
    for _ in range(5):
        rows = twin.rows_of("robot")
        seen = AgentView(twin, 3, 7).look(rows)
        twin.steer("robot", wishes_of_actions(twin, rows, 0.5 * seen[:, 1:2].astype(float), 1.0))
        twin.run(1)
    flock.run(5)
    assert np.array_equal(flock.position, twin.position)


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("1 / 0", "ZeroDivisionError: division by zero"),
        ("return seen", r"an array of the shape \(2, 26\), and \(2, 1\) is needed"),
        ("return 'left'", "'left' is no array of numbers"),
        ("return None", "an array of the shape"),
        ("return [[0.0], [float('nan')]]", r"\[nan\] for agent 22, and finite numbers are needed"),
        ("raise SystemExit(0)", "SystemExit: 0"),
        ("import os; os._exit(3)", "its process ended with code 3"),
        ("import time; time.sleep(1000)", r"no answer within 0\.2 s"),
        ("return sum(range(10**15))", r"no answer within 0\.2 s"),
    ],
)
def test_whatever_a_policy_does_the_run_goes_on(tmp_path, body, told):
    flock = flown(tmp_path, body, timeout=0.2 if "no answer" in told else 60.0)
    free = Flock(flock.spec.but(kinds=[Kind("robot", 2)]))
    flock.run(4)
    free.run(4)
    assert np.array_equal(flock.position, free.position)  # by their rule, as if never steered
    (line,) = flock.lines
    assert flock.faults == (line,)
    assert re.search(told, line)
    assert line.startswith("policy turn of kind robot at tick 0: ")
    assert line.endswith("; its agents follow their rule from now on")


def test_a_policy_may_end_the_run_instead(tmp_path):
    flock = flown(tmp_path, "1 / 0", ", ends=True")
    with pytest.raises(InputError, match=r"at tick 0: ZeroDivisionError.*the run ends, as it decl"):
        flock.run(4)
    assert flock.tick == 0


def test_numbers_beyond_the_space_are_cut_off_and_told_once(tmp_path):
    flock = flown(tmp_path, "return [[1.0], [7.0]]")
    flock.run(4)
    (line,) = flock.lines
    assert "[7.0] for agent 22; numbers beyond [-1, 1] are cut off" in line
    assert not flock.faults


def test_another_run_tries_a_policy_again(tmp_path):
    flock = flown(tmp_path, "1 / 0")
    flock.run(1)
    assert flock.faults
    flock.restart(3)
    assert not flock.faults
    flock.run(1)
    assert flock.faults


def test_a_file_that_is_edited_flies_from_the_next_tick_on(tmp_path):
    flock = flown(tmp_path, "1 / 0")
    flock.run(1)
    assert flock.faults
    catalogue.from_file(write(tmp_path))
    flock.run(1)
    assert not flock.faults


def test_a_copy_is_flown_too(tmp_path):
    flock = flown(tmp_path)
    flock.run(2)
    copy = deepcopy(flock)
    copy.run(3)
    flock.run(3)
    assert np.array_equal(copy.position, flock.position)


def test_a_policy_flies_in_space_and_where_a_rule_wishes_an_acceleration(tmp_path):
    space = flown(tmp_path, "return np.full((len(seen), 2), [0.0, 0.2])", model="couzin")
    rows = space.rows_of("robot")
    before = space.heading[rows, 2].copy()
    space.run(2)
    assert np.all(space.heading[rows, 2] != before)
    assert not space.faults
    plane = flown(tmp_path, "return np.zeros((len(seen), 2))", model="dorsogna")
    plane.run(2)
    assert not plane.faults


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (", scale=0.0", r"scale = 0\.0 is not allowed: a finite number > 0"),
        (", scale=float('nan')", "scale = nan is not allowed"),
        (", ends=1", "ends = 1 is not True or False"),
        (", name='a b'", "policy 'a b' is not allowed: a name of letters"),
    ],
)
def test_a_declaration_that_cannot_be_is_refused_with_its_file(tmp_path, options, told):
    with pytest.raises(InputError, match=rf"turn\.py, line 5: .*{told}"):
        catalogue.from_file(write(tmp_path, options=options))


def test_two_policies_in_a_file_are_refused(tmp_path):
    path = Path(write(tmp_path))
    text = path.read_text("utf-8")
    path.write_text(text + text.replace("def turn", "def other"), "utf-8")
    with pytest.raises(InputError, match=r"turn\.py has several policies, other, turn"):
        catalogue.from_file(str(path))


def test_a_kind_keeps_its_policy_in_a_spec():
    spec = Spec("vem", agents=5, seed=1, kinds=[Kind("robot", 2, policy="turn")])
    again = Spec.from_toml(Flock(spec).spec.to_toml())
    assert again.kinds[0].policy == "turn"
    assert again.kinds[0].steered
    with pytest.raises(InputError, match=r"kind a: policy '../b.py' is not allowed"):
        Kind("a", 1, policy="../b.py")
    with pytest.raises(InputError, match="unknown policy 'turn': give its file by --rule"):
        Flock(spec).run(1)


def test_the_command_line_flies_a_policy(tmp_path):
    path = write(tmp_path, "return [[float('inf')]] * 2")
    run = ["run", "vem", "--agents", "20", "--seed", "1", "--ticks", "5", "--quiet", "--json"]
    flies = ["--rule", path, "--kind", "robot=2,policy=turn"]
    done = CLI.invoke(app, [*run, *flies])
    assert done.exit_code == 0, done.output
    assert "policy turn of kind robot at tick 0: [inf] for agent 21" in done.stderr
    assert len(json.loads(done.stdout)["faults"]) == 1


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["--kind", "robot=2,steered=true"], "policy turn flies nobody: give a kind"),
        (["--kind", "robot=2,policy=trun"], "unknown policy 'trun': did you mean 'turn'?"),
    ],
)
def test_the_command_line_refuses_what_flies_nobody(tmp_path, more, told):
    done = CLI.invoke(app, ["run", "vem", "--rule", write(tmp_path), *more])
    assert done.exit_code == 2
    assert told in done.stderr


def test_the_policy_that_the_docs_learn_flies(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[1] / "docs")
    import learn_to_evade

    width = learn_to_evade.make_flocks(1).single_observation_space.shape[0]
    weights = np.linspace(-1.0, 1.0, width + 1)
    learn_to_evade.write_policy(weights, tmp_path / "evade.py")
    policy = catalogue.from_file(str(tmp_path / "evade.py"))
    seen = np.random.default_rng(1).uniform(-1, 1, (3, len(weights) - 1))
    expected = learn_to_evade.act(np.tile(weights.round(6), (3, 1)), seen)[:, 0]
    assert np.allclose(policy.act(seen), expected)
