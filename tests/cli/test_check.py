"""`flockscope check`: a line per fact, JSON, exit code 2 where one does not hold; files too."""

from __future__ import annotations

import json

import pytest

from agents.conformance import CHECKS
from cli.calling import call, refusal

EAST = """
import dataclasses
from agents.engine.block import Decision
from agents.rules.vicsek import VEM
from worlds.compilation import compiled

@compiled
def decide(me, near, surroundings, p):
    return Decision(1.0, 0.0, 0.0)

RULE = dataclasses.replace(VEM, name="eastwards", decide=decide, dimensions=(2,), tries=())
"""


def test_a_model_is_checked_fact_by_fact():
    made = call("check", "vem", "--json")
    assert made.exit_code == 0
    found = json.loads(made.stdout)
    assert [one["check"] for one in found["checks"]] == list(CHECKS)
    assert {one["result"] for one in found["checks"]} == {"holds"}


@pytest.mark.exhaustive
def test_a_file_is_checked_too_and_what_fails_is_said(tmp_path):
    (tmp_path / "east.py").write_text(EAST)
    made = call("check", tmp_path / "east.py", "--quiet")
    assert made.exit_code == 2
    (line,) = made.stdout.splitlines()
    assert line.startswith("fails           rotation")
    assert "positions" in line


def test_a_model_is_needed():
    assert "which MODEL?" in refusal("check")
    assert "did you mean 'vem'" in refusal("check", "vemm")
