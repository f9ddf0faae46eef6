"""The benchmarks run, and their C++ is the model that it is compared with."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from oracles import vicsek_family as family

ROOT = Path(__file__).parents[1]
sys.path += [str(ROOT / "benchmarks" / folder) for folder in ("engine", "pages", "studies")]
from batch_run import run_as_sweep, run_with_mesa  # noqa: E402
from reference import COMPILER, reference  # noqa: E402
from web import line, verdicts  # noqa: E402

compiler = pytest.mark.skipif(shutil.which(COMPILER) is None, reason=f"no {COMPILER}")
CHROMIUM = os.environ.get("FLOCKSCOPE_CHROMIUM") or shutil.which("chromium")
browser = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium")


def printed(name, *arguments):
    """What a benchmark prints."""
    (path,) = (ROOT / "benchmarks").glob(f"*/{name}")
    command = [sys.executable, str(path), *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT).stdout


def columns(position, heading):
    """The four columns that the C++ takes."""
    return [one.copy() for one in (*position.T, *heading.T)]


@pytest.fixture(scope="module")
def by_hand():
    """The C++, compiled once."""
    return reference()


@compiler
@pytest.mark.parametrize("side", [3.0, 5.5, 9.2])
def test_the_cpp_steps_as_the_oracle_does(by_hand, side):
    rng = np.random.default_rng(3)
    n, ticks = 120, 6
    angle = rng.uniform(-math.pi, math.pi, n)
    heading = np.column_stack([np.cos(angle), np.sin(angle)])
    p = family.Parameters(v0=0.2)
    nobody = np.zeros(n, bool)
    state = family.begin(rng.uniform(0.0, side, (n, 2)), heading, nobody, p, (side, side), "wrap")
    flown = columns(state.position, state.heading)
    by_hand(n, side, p.r, p.v0, 0.0, 1, ticks, *flown)
    for _ in range(ticks):
        state = family.step("vem", state, p, (side, side), "wrap")
    apart = np.column_stack(flown[:2]) - state.position
    assert np.abs(apart - side * np.round(apart / side)).max() < 1e-12
    assert np.abs(np.column_stack(flown[2:]) - state.heading).max() < 1e-12
    assert all(((one >= 0.0) & (one < side)).all() for one in flown[:2])


@compiler
def test_the_noise_of_the_cpp_is_uniform_and_new_each_tick(by_hand):
    n, eta = 10_000, 0.5
    row = 2.0 * np.arange(100) + 1.0
    position = np.array([(x, y) for x in row for y in row])  # nobody has a neighbour
    turns = []
    for ticks in (1, 2):
        flown = columns(position, np.tile([1.0, 0.0], (n, 1)))
        by_hand(n, 200.0, 1.0, 0.0, eta, 7, ticks, *flown)
        turns.append(np.arctan2(flown[3], flown[2]))
    first, second = turns[0], turns[1] - turns[0]
    for turn in (first, second):
        assert np.abs(turn).max() <= eta / 2
        share = np.sort(turn) / eta + 0.5  # Kolmogorov and Smirnov: beyond 1.95 once in a thousand
        assert np.abs(share - (np.arange(n) + 0.5) / n).max() < 1.95 / math.sqrt(n)
    assert abs(np.corrcoef(first, second)[0, 1]) < 4.0 / math.sqrt(n)


def test_speed_prints_its_contestants_and_ratios():
    said = printed("speed.py", "--agents", "400", "--rounds", "1", "--steps", "2000")
    assert said.count("flockscope  ") == 7
    assert "two threads over one, 40 agents" in said
    assert ("400 agents, over C++ by hand at 400" in said) == (shutil.which(COMPILER) is not None)


def test_a_tree_is_compared_with_another():
    few = ("--agents", "50", "--ticks", "3", "--rounds", "2", "--json")
    (row,) = json.loads(printed("against.py", str(ROOT), "--cases", "vem", *few))
    assert (row["case"], row["agents"], row["same_start"]) == ("vem", 50, True)
    assert row["ratio_cpu"] == pytest.approx(row["then_cpu"] / row["now_cpu"])


def test_a_commit_is_checked_out_and_removed():
    from against import check_out

    with check_out("HEAD") as tree:
        assert (tree.path / "agents" / "flock.py").is_file()
    assert not tree.path.exists()


def test_scaling_prints_and_draws_all_sweeps(tmp_path):
    few = ("--largest", "100", "--rounds", "1", "--turn", "0")
    drawn = tmp_path / "scaling.svg"
    said = json.loads(printed("scaling.py", *few, "--json", "--picture", str(drawn)))
    rules = {"vem", "couzin", "hwvem", "boundary-points", "reynolds", "guarded"}
    names = {sweep: {one["name"] for one in points} for sweep, points in said["sweeps"].items()}
    assert rules <= names["agents"]
    assert rules <= names["density"]
    assert names["obstacles"] == rules - {"vem", "hwvem"} | {"hwvem-nav"}
    assert names["gathering"] == {"couzin"}
    assert all(one["least"] > 0 for points in said["sweeps"].values() for one in points)
    assert [one["pairs"] for one in said["pairs"]] == [100 * 99] * 4
    arrays, members = said["bytes_per_agent"].values()
    assert 0 < arrays < members
    assert "Over neighbours" in drawn.read_text()


def test_scaling_prints_one_part_and_says_where_a_knee_is():
    from scaling import knees
    from sweeps import Point

    lines = printed("scaling.py", "--only", "gathering", "--quick", "--turn", "0").splitlines()
    assert lines[0] == "ns per agent-step over ticks in which 1,000 agents gather"
    near = [float(number) for number in lines[3].split()[2:]]
    assert near == sorted(near)
    assert near[-1] > 5 * near[0]
    points = [
        Point("vem", n, n, cost, cost, None) for n, cost in ((100, 99), (1000, 10), (10000, 12))
    ]
    assert knees(points) == ["vem: no knee, at most 1.20 times the least, at 10,000"]
    points.append(Point("vem", 100_000, 100_000, 14.0, 14.0, None))
    assert knees(points) == ["vem: a knee, at most 1.40 times the least, at 100,000"]


def test_ranks_are_measured_and_needs_are_those_of_the_engine():
    pytest.importorskip("distributed", reason="the extra cluster is not installed")
    from ranks import HELD, MESSAGE, Needs, flock

    from agents.strips.strip_engine import StripEngine, longest_stride

    lines = printed("ranks.py", "--quick").splitlines()
    assert lines[3] == "the same bits: yes"
    assert lines[-2:] == [Needs(10**8, 16).line(), Needs(10**9, 100).line()]
    page = (ROOT / "docs" / "scale.md").read_text(encoding="utf-8")
    for needs in (Needs(10**8, 16), Needs(10**9, 100)):
        _, ranks, ticks, ghosts, sent, _, rank, _, first, _ = needs.line().split()
        numbers = f"{ranks} | {ticks} | {ghosts[:-1]} % | {sent} MB | {rank} GB | {first} GB"
        assert f"| {numbers} |" in page, "docs/scale.md has other needs"
    few = flock(4_000, 1)
    rows = sum(column.itemsize * column.size for column in few.arrays) / 4_000 + 8
    assert rows == MESSAGE
    slots = sum(column.itemsize * column.size for column in few.engine.slots) / 4_000
    assert rows + slots == pytest.approx(HELD, rel=1e-2)
    stride = longest_stride(few.model, few.parameters, few.world, few.options)
    engine = StripEngine(few.engine, None, None, stride)
    engine.ranks = [None] * 5
    assert engine.ticks_together(few.context) == Needs(4_000, 5).together


def test_a_tick_that_would_last_too_long_is_left_out_with_a_word():
    from sweeps import Made, Sweep, run
    from turns import Taken

    slow = {"slow": lambda agents: Made(int(agents), lambda ticks: Taken(agents * ticks, 0.0))}
    sweep = Sweep("agents", "agents", (1, 2, 3, 4), slow, lambda agents: agents)
    points, left_out = run(sweep, 1, 0.0, 2.5, "agents")
    assert [(one.value, one.least) for one in points] == [(1, 1e9), (2, 1e9)]
    assert left_out == ["slow from 3 on: a tick would last 3.0 s"]


def test_mesa_and_a_sweep_find_the_same():
    found = run_as_sweep(20, 10, range(1, 4), 1)
    assert len(found) == 12
    assert found == run_with_mesa(20, 10, range(1, 4), 1)


def test_the_rate_of_sweeps_is_printed_for_each_kind_of_run():
    lines = printed("sweep_rate.py", "--runs", "40").splitlines()
    kinds = [line.split()[:4] for line in lines[1:]]
    assert [one[:3] for one in kinds] == [
        ["50", "x", "100"],
        ["300", "x", "100"],
        ["1000", "x", "1000"],
    ]
    assert [int(one[3]) for one in kinds] == [40, 20, 8]


def test_the_ways_to_make_short_runs_take_turns():
    calls, ways, process = printed("short_runs.py", "--runs", "8", "--rounds", "1").split("\n\n")
    assert len(calls.splitlines()) == 6
    head, bare, *others = ways.splitlines()
    assert head.split()[:2] == ["8", "runs,"]
    assert bare.split()[:2] == ["bare", "ticks"]
    assert bare.split()[3] == "1.00"
    names = [line[:34].strip() for line in others]
    assert {"a sweep", "a paper", "flockscope.batch_run"} <= set(names)
    assert all(float(line.split()[-2]) > 0.0 for line in others)
    assert process.startswith("a process for runs begins within ")


def test_the_store_of_sweeps_gives_back_what_it_took():
    lines = printed("sweep_store.py", "--rows", "2000").splitlines()
    assert lines[0].startswith("2000 runs written in ")
    assert lines[1].startswith("2000 of them counted")


@browser
def test_a_flock_as_a_web_page_is_measured():
    said = json.loads(printed("web.py", "vem", "--quick", "--json"))
    (row,) = said["rows"]
    assert (row["model"], row["agents"], row["faults"]) == ("vem", 100, [])
    assert row["difference_20"] < 1e-9
    assert row["page_gzipped_bytes"] < row["page_bytes"]
    assert 0 < row["module_bytes"] < row["page_bytes"]
    assert row["ratio"] == pytest.approx(row["chromium_ms"] / row["native_ms"])
    assert min(row["made_s"], row["first_tick_s"]) > 0
    assert row["imports"] == ["sched_yield"]
    others = ("node", "firefox-esr")
    assert len(row["sha256"]) >= 1 + sum(shutil.which(name) is not None for name in others)
    assert len(set(row["sha256"].values())) == 1, "every browser gives the same bits"
    assert said["verdicts"][0] == "pages: 1 of 1 models; refused: none"


def test_verdicts_of_web_pages_follow_from_the_rows():
    numbers = {"agents": 9, "made_s": 1.0, "page_gzipped_bytes": 1, "module_bytes": 1}
    numbers |= {"first_tick_s": 0.1, "native_ms": 1.0, "chromium_ms": 2.0, "imports": ["pow"]}
    rows = [
        numbers
        | {"model": "small", "page_bytes": 9_000, "ratio": 2.0, "difference_20": 1e-12}
        | {"difference_100": math.nan, "sha256": {"Chromium": "aa", "node": "aa"}, "faults": []},
        numbers
        | {"model": "large", "page_bytes": 400_000, "ratio": 3.0, "difference_20": 1e-3}
        | {"difference_100": 1.0, "sha256": {"Chromium": "aa", "node": "ab"}, "faults": ["slow"]},
        {"model": "windy", "refused": "it is windy"},
    ]
    assert line(rows[2]).split() == ["windy", "refused:", "it", "is", "windy"]
    assert " aa aa " in line(rows[0])
    assert " aa ab " in line(rows[1])
    assert verdicts(rows) == [
        "pages: 2 of 3 models; refused: windy",
        "the same bits, from another start too, in Chromium, node: 1 of 2; not: large",
        "further than 1e-09 from native after 20 ticks: large",
        "further than 1e-09 from native after 100 ticks: small, large",
        "largest page: large, 400.0 kB, 0.0 kB by gzip",
        "larger than 300 kB: large",
        "Chromium over native, ms per tick: median 2.50, largest 3.00 (large)",
        "runtimes that did not run a flock: 1",
    ]
