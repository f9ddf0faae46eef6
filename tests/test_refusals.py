"""What cannot be used is refused in one line: the thing, its value, what is allowed."""

from __future__ import annotations

import numpy as np
import pytest

from agents import Flock
from worlds.input_error import InputError
from worlds.layout import world


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"model": "hwven"}, "unknown model 'hwven': did you mean 'hwvem'?"),
        ({"model": "vem", "p1": 0.1}, "unknown parameter 'p1'"),
        ({"p3": 0.1}, "unknown parameter 'p3': did you mean 'p"),
        ({"eta": 9}, r"eta = 9 rad is outside [0, 6.2832] rad"),
        ({"eta": float("nan")}, "eta = nan"),
        ({"eta": "much"}, "eta = 'much' is not allowed"),
        ({"p2": 0.5}, "p2 = 0.5 is outside [1, 100]"),
        (
            {"layers": "later"},
            "layers = 'later' is not allowed: it must be one of delayed, instant",
        ),
        ({"agents": 0}, "agents = 0 is not allowed: a whole number >= 1"),
        ({"agents": 2.5}, "agents = 2.5"),
        ({"agents": True}, "agents = True"),
        ({"informed": -1}, "informed = -1"),
        ({"rng": -3}, "seed = -3"),
        ({"seed": 2}, "rng = 1 and seed = 2: both are the seed, give one"),
        ({"threads": 0}, "threads = 0"),
        ({"dim": 4}, "dim = 4"),
        ({"model": "ivem", "dim": 3}, "ivem is defined in 2-D"),
        ({"world": "warp"}, "unknown world 'warp': did you mean 'wrap'?"),
        ({"world": "missing.toml"}, "'missing.toml' cannot be read"),
        ({"size": 0.0}, "size = 0.0"),
        ({"size": (1.0, float("inf"))}, "size = inf"),
        ({"size": (1.0, 2.0, 3.0), "dim": 2}, "has 3 sides, a 2-D world has 2"),
        ({"activation": "all"}, "unknown activation 'all'"),
        ({"noise": "angulr"}, "did you mean 'angular'"),
        ({"collect": ("polarization",)}, "did you mean 'polarisation'"),
    ],
)
def test_settings(settings, says):
    with pytest.raises(InputError) as refused:
        Flock(**{"rng": 1, **settings})
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)


GOOD = {"position": [[0.5, 0.5], [1.0, 1.0]], "heading": [[1.0, 0.0], [0.0, 1.0]]}


@pytest.mark.parametrize(
    ("arrays", "says"),
    [
        ({"position": [[0.5, np.nan], [1.0, 1.0]]}, "position of row 0 is [0.5, nan]"),
        ({"heading": [[1.0, 0.0], [0.0, 0.0]]}, "heading of row 1 is a zero vector"),
        ({"heading": [[1.0, 0.0]]}, "2 positions but 1 headings"),
        ({"position": [[1.0, 2.0, 3.0]] * 2}, "shape (2, 3), not (N, 2)"),
        ({"position": "here"}, "not an array of numbers"),
        ({"informed": [True]}, "'informed' has shape (1,)"),
        ({"velocity": [[1.0, 0.0]] * 2}, "unknown start array 'velocity'"),
        ({"position": np.empty((0, 2)), "heading": np.empty((0, 2))}, "0 agents"),
    ],
)
def test_start_arrays(arrays, says):
    with pytest.raises(InputError) as refused:
        Flock("vem", start={**GOOD, **arrays}, size=3.0, rng=1)
    assert says in str(refused.value)


def test_a_start_without_headings():
    with pytest.raises(InputError, match="no 'heading'"):
        Flock("vem", start={"position": [[1.0, 1.0]]}, size=3.0, rng=1)


def test_a_refused_change_changes_nothing():
    flock = Flock("hwvem", rng=1, p1=0.3)
    with pytest.raises(InputError):
        flock.set(p1=0.5, p2=1e9)
    assert flock.parameters.p1 == 0.3


def test_a_rule_that_gives_no_number_is_named():
    flock = Flock("vem", agents=20, rng=1)
    flock.heading[7] = np.nan
    with pytest.raises(ArithmeticError, match="must be a finite number"):
        flock.run(5)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("edges = 'wrap", "is not TOML"),
        ("edges = 'wrapp'", "unknown edge 'wrapp': did you mean 'wrap'?"),
        ("edges = ['wrap']", "edges = ['wrap'] names 1 axis, the world has 2"),
        ("distance = 'far'", "unknown distance 'far'"),
        ("walls = 3", "unknown key 'walls'"),
    ],
)
def test_world_files(tmp_path, text, says):
    path = tmp_path / "world.toml"
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        world(str(path), 2, 1.0)
    assert says in str(refused.value)
    assert "world.toml" in str(refused.value)


def test_a_world_file_with_an_edge_for_each_axis(tmp_path):
    path = tmp_path / "channel.toml"
    path.write_text("title = 'Channel'\nedges = ['wrap', 'open']\n")
    flock = Flock("vem", agents=30, size=(4.0, 2.0), world=str(path), rng=1, v0=0.2)
    flock.run(100)
    assert (flock.position[:, 0] >= 0).all()
    assert (flock.position[:, 0] < 4).all()
    assert (flock.position[:, 1] > 2).any() or (flock.position[:, 1] < 0).any()
