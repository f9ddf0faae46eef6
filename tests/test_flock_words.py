"""Editors and type checkers know the words of `Flock`: they are those that are declared."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest
from mypy import api

ROOT = Path(__file__).parents[1]
RIGHT = """
from flockscope import MODELS, Flock, Spec, World

flock = Flock("vem", agents=50, size=(10.0, 5.0), rng=1, eta=0.5, neighbours="nearest", k=7)
flock.set(eta=1)
flock.eta
world = World(size=(20.0, 10.0), edges=("open", "open"))
Flock(Spec("couzin", agents=30, dim=3, world=world, parameters={"r_r": 1.0}))
"""
WRONG = {
    'Flock("vem", agents="fifty")': 'has incompatible type "str"; expected "int | None"',
    'Flock("vem", 50)': 'has incompatible type "int"; expected "Never"',
    'Flock("vem", agent=50)': 'Unexpected keyword argument "agent"',
    'Flock("vem", dim=4)': 'expected "Literal[2, 3] | None"',
    'Flock("vem", neighbours="near")': "expected \"Literal['metric', 'nearest']\"",
    'Flock("vem").set(etta=1.0)': 'Unexpected keyword argument "etta"',
    'Spec("vem", seed="one")': 'expected "int | None"',
}


def test_the_words_are_those_that_are_declared():
    made = runpy.run_path(str(ROOT / "packing" / "flock_words.py"))
    assert made["text"]() == (ROOT / "agents" / "flock_words.py").read_text(), (
        "run: uv run python packing/flock_words.py"
    )


@pytest.mark.exhaustive
def test_a_type_checker_finds_what_is_wrong_and_nothing_else(tmp_path):
    lines = [*RIGHT.splitlines(), *WRONG]
    script = tmp_path / "script.py"
    script.write_text("\n".join(lines) + "\n")
    out, err, _ = api.run(["--config-file", str(ROOT / "pyproject.toml"), str(script)])
    assert not err
    found = {}
    for line in out.splitlines()[:-1]:
        place, _, said = line.partition(": error: ")
        found.setdefault(lines[int(place.split(":")[1]) - 1], said)
    assert set(found) == set(WRONG)
    for line, said in WRONG.items():
        assert said in found[line]
