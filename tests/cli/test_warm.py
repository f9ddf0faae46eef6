"""`flockscope warm`: what it has compiled is at hand in another process, and it says so."""

from __future__ import annotations

import json
import os
import re

import pytest

from agents.catalogue import MODELS
from cli.calling import call, refusal, start


@pytest.mark.exhaustive
def test_what_is_compiled_once_is_at_hand_in_any_process(tmp_path):
    here = os.environ | {"FLOCKSCOPE_CACHE": str(tmp_path)}
    made = [
        json.loads(start("warm", "vem", "--json", env=here).communicate()[0])[0] for _ in range(2)
    ]
    assert [one["before"] for one in made] == [False, True]
    assert made[1]["seconds"] < made[0]["seconds"]
    listed = json.loads(start("list", "kernels", "--json", env=here).communicate()[0])
    compiled = {row["model"]: row["compiled"] for row in listed["models"]}
    assert compiled["vem"] == "here"
    assert compiled["couzin"] is None
    [(target, kept)] = listed["places"][str(tmp_path / "kernels")].items()
    assert target == listed["target"]
    assert kept["kernels"] >= 1


def test_the_list_of_kernels_names_every_model_and_the_cpu():
    lines = call("list", "kernels").stdout.splitlines()
    assert re.fullmatch(r"compiled for \S+ on this machine", lines[0])
    names = [
        name for line in lines if line.startswith("compiled ") for name in MODELS if name in line
    ]
    assert set(names) == set(MODELS)


def test_models_are_compiled_one_by_one():
    made = call("warm", "vem", "wvem").stdout.splitlines()
    assert [line.split()[0] for line in made] == ["vem", "wvem"]
    assert "'vemm'" in refusal("warm", "vem", "vemm")
