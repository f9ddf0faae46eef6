"""An agent that is where it cannot be: a run says so, and its exit code; so an experiment."""

import json

import numpy as np
import pytest
from experiments.small import small

from agents import Flock
from agents.state.agent_rows import StrayAgents
from app.studies.experiment_runner import run_experiment
from app.studies.runs.store_reader import StoreReader
from app.studies.sweeps.sweep_table import wide_table
from cli.calling import call, refusal
from worlds.obstacles import Box
from worlds.world import World

YARD = World(
    "yard", (10.0, 10.0), ("solid", "solid"), obstacles=(Box(low=(4.0, 4.0), high=(6.0, 6.0)),)
)


@pytest.fixture
def yard(tmp_path):
    """A world file."""
    path = tmp_path / "yard.toml"
    path.write_text(YARD.to_toml())
    return path


@pytest.fixture
def _slips(monkeypatch):
    """Makes the agent of row 3 be in the obstacle after each stretch of ticks."""

    advance = Flock.advance

    def slip(flock, *arguments, **more):
        advance(flock, *arguments, **more)
        flock.position[3:4] = (5.0, 5.5)

    monkeypatch.setattr(Flock, "advance", slip)


@pytest.mark.usefixtures("_slips")
def test_a_run_tells_who_where_and_when_and_exits_with_4(yard):
    made = call("run", "vem", "--agents", 9, "--world", yard, "--ticks", 1, "--seed", 1, "--json")
    assert made.exit_code == 4
    [line] = [line for line in made.stderr.splitlines() if "where it cannot be" in line]
    words = "where it cannot be: 0.5 inside what is solid at (5, 5.5), tick 1"
    number = Flock("vem", agents=9, world=YARD, rng=1).ids[3]
    assert line == f"flockscope: agent {number} {words}"
    assert json.loads(made.stdout)["astray"] == f"agent {number} {words}"


def test_a_run_without_one_exits_with_0(yard):
    made = call("run", "vem", "--agents", 9, "--world", yard, "--ticks", 5, "--seed", 1, "--json")
    assert made.exit_code == 0
    assert "astray" not in json.loads(made.stdout)


def test_agents_that_go_through_what_is_solid_by_their_paper_are_announced():
    args = ("run", "thesis", "--world", "thesis-blocks", "--agents", 3, "--ticks", 0, "--seed", 1)
    made = call(*args, "--json")
    assert made.exit_code == 0
    assert "thesis with contact = start: agents go through obstacles" in made.stderr
    assert json.loads(made.stdout)["passes_solids"] == "contact = start"
    held = call(*args, "--json", "--set", "contact=always")
    assert "go through" not in held.stderr


def test_a_state_with_an_agent_in_an_obstacle_is_refused(tmp_path):
    flock = Flock("vem", agents=5, world=YARD, rng=1)
    flock.position[2] = (5.0, 5.0)
    flock.save(tmp_path / "state.parquet")
    line = refusal("run", "--state", tmp_path / "state.parquet", "--ticks", 1)
    assert "position of row 2 is [5.0, 5.0]: that is inside the obstacle box of yard" in line


def test_the_row_of_an_experiment_tells_of_its_run(tmp_path, monkeypatch):
    found = StrayAgents(7, 6, 40, np.array([1.0, 2.0]), 0.25, 1)
    monkeypatch.setattr(Flock, "stray", lambda flock: found if flock.seed == 2 else None)
    done = run_experiment(
        small(tmp_path), tmp_path, runs=2, seed=1, workers=1, tell=None, at=lambda *_: None
    )
    columns = wide_table(StoreReader(tmp_path))
    rows = list(zip(columns["seed"], columns["astray"], strict=True))
    assert set(rows) == {(1, None), (2, str(found))}
    assert len(done.astray) == len(rows) / 2
    assert all("seed 2: agent 7 where it cannot be" in line for line in done.astray)
