"""What is installed from the wheel works beside a package `agents` and among a user's own files.

Builds, installs and compiles: `uv run pytest -m installed`; CI asks for it with what is exhaustive.
"""

from __future__ import annotations

import json
import re
import signal
import urllib.request
from pathlib import Path
from zipfile import ZipFile

import pytest
from cli.calling import call

from worlds.compilation import levels_here

pytestmark = pytest.mark.installed

RUN = ("run", "hwvem", "--agents", "30", "--ticks", "20", "--seed", "1", "--json", "--quiet")
OF_VEM = ("run", "vem", "--ticks", "20", "--seed", "1", "--json", "--quiet")


def test_a_wheel_holds_one_name(wheel):
    with ZipFile(wheel) as held:
        tops = {name.partition("/")[0] for name in held.namelist()}
        entry = next(name for name in held.namelist() if name.endswith("entry_points.txt"))
        assert "flockscope = flockscope.__main__:main" in held.read(entry).decode()
    [information] = tops - {"flockscope"}
    assert information.endswith(".dist-info")


def test_the_neighbours_name_stays_the_neighbours(installed, tmp_path):
    printed = installed.run(
        "python", "-c",
        "from importlib.util import find_spec as find; import agents, flockscope.rules; "
        "print(find('app'), find('worlds'), agents.Agent.__module__, agents.__file__)",
        cwd=tmp_path,
    )  # fmt: skip
    assert printed.startswith("None None agents.agent ")
    assert "flockscope" not in printed.rpartition("/agents/")[2]


def test_everything_is_listed(installed):
    listed = json.loads(installed.run("flockscope", "list", "--json"))
    assert listed == json.loads(call("list", "--json").stdout)


def test_it_runs_to_the_same_bits(installed):
    there = json.loads(installed.run("python", "-m", "flockscope", *RUN))
    here = json.loads(call(*RUN).stdout)
    assert there["observables"] == here["observables"]
    assert there["spec"]["parameters"] == here["spec"]["parameters"]


def test_a_rule_is_begun_from_another_and_runs(installed):
    installed.run("flockscope", "new", "rule", "my_own.py", "--from", "couzin")
    told = installed.run(
        *["flockscope", "run", "my_own.py", "--agents", "5", "--ticks", "1", "--interpret"]
    )
    assert told.startswith("Couzin's zones: 5 agents")


def test_a_paper_is_repeated(installed, tmp_path):
    table = installed.run(
        "flockscope", "paper", "liu2021-table1", "--runs", "2", "--no-pictures", "--out", tmp_path,
        "--models", "hwvem",  # which is compiled already
    )  # fmt: skip
    assert "hwvem" in table
    runs = installed.run("flockscope", "sweep", "export", tmp_path).splitlines()[1:]
    assert len(runs) == 6


def test_a_sweep_is_made_in_processes_of_its_own(installed, tmp_path):
    asked = ("vem", "--vary", "eta=0:6:2", "--set", "agents=20", "--runs", "2", "--ticks", "20")
    installed.run("flockscope", "sweep", "run", *asked, "--quiet", "--out", tmp_path / "out")
    runs = installed.run("flockscope", "sweep", "export", tmp_path / "out").splitlines()[1:]
    assert [run.split(",")[3] for run in runs] == ["ok"] * 4


def test_the_laboratory_serves_its_first_page(installed):
    process = installed.start("lab", "hwvem", "--agents", "20", "--port", "0", "--no-open")
    try:
        said = iter(process.stdout.readline, "")
        address = next(m[0] for line in said if (m := re.search(r"http://localhost:\d+", line)))
        with urllib.request.urlopen(address, timeout=60.0) as answer:
            page = answer.read()
        assert answer.status == 200
        assert b"<html" in page
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=120.0)


def test_a_part_of_the_tests_passes_there(installed, part_of_the_tests):
    installed.run("python", "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests",
                  cwd=part_of_the_tests)  # fmt: skip


@pytest.mark.skipif(not levels_here(), reason="kernels are made for x86-64-v3 and later")
def test_a_release_brings_kernels_and_compiles_nothing(released):
    """Nor does it write any: what is run is what the wheel brings."""
    listed = json.loads(released.run("flockscope", "list", "kernels", "--json"))
    compiled = {row["model"]: row["compiled"] for row in listed["models"]}
    assert compiled["vem"] == "wheel"
    assert set(compiled.values()) == {"wheel", None}
    there = json.loads(released.run("flockscope", *OF_VEM))
    assert not list(Path(released.environment["FLOCKSCOPE_CACHE"]).rglob("*.kernel"))
    assert there["observables"] == json.loads(call(*OF_VEM).stdout)["observables"]
