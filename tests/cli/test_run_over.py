"""`flockscope run --over`: what is observed over the last ticks; and the list of crashes."""

import json
import math

import numpy as np
import pytest

from agents import Flock
from agents.run_records import follow
from cli.calling import call, refusal

RUN = ("run", "vem", "--agents", 40, "--seed", 5, "--set", "eta=2", "--quiet")


def outcome(*args):
    result = call(*args, "--json")
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


def test_it_is_the_series_of_a_script():
    made = outcome(*RUN, "--ticks", 60, "--over", 50, "--observe", "groups,susceptibility,binder")
    flock = Flock("vem", agents=40, rng=5, eta=2.0)
    flock.run(10)
    series = follow(flock, 50, ["groups", "binder"])
    phi = series.values["polarisation"]
    assert made["observables"] == {
        "groups": flock.observe("groups"),
        "susceptibility": series.over("susceptibility"),
        "binder": series.over("binder"),
    }
    assert made["over"]["ticks"] == 50
    assert made["over"]["mean"]["polarisation"] == pytest.approx(phi.mean())
    assert made["over"]["deviation"]["polarisation"] == pytest.approx(phi.std())
    assert made["over"]["mean"]["groups"] == series.values["groups"].mean()


def test_looking_and_recording_change_nothing(tmp_path):
    plain = outcome(*RUN, "--ticks", 30)
    path = tmp_path / "run.parquet"
    seen = outcome(*RUN, "--ticks", 30, "--over", 7, "--record", path, "--every", 4)
    assert seen["over"]["ticks"] == 7
    assert "over" not in plain
    for name, value in plain["observables"].items():
        assert seen["observables"][name] == value
    from pyarrow import parquet

    ticks = np.unique(parquet.read_table(path, columns=["tick"])["tick"])
    assert ticks.tolist() == [0, 4, 8, 12, 16, 20, 24, 28, 30]


def test_all_has_what_is_measured_over_a_run_only_with_over():
    one, over = (outcome(*RUN, "--ticks", 5, "--observe", "all", *more)["observables"]
                 for more in ((), ("--over", 5)))  # fmt: skip
    assert set(over) - set(one) == {"susceptibility", "binder"}
    assert over["group-table"]["0"]["agents"] == over["largest-group"]


def test_the_table_for_people_has_means():
    result = call(*RUN, "--ticks", 20, "--over", 10)
    assert result.exit_code == 0
    assert "susceptibility" in result.stdout
    assert "over the last 10 ticks" in result.stdout


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["--observe", "binder"], ["--observe binder", "over a run", "--over TICKS"]),
        (["--over", "0"], ["--over 0", ">= 1"]),
        (["--over", "11", "--ticks", "10"], ["--over 11", "--ticks 10"]),
    ],
)
def test_what_has_no_series_is_refused(args, words):
    line = refusal("run", "vem", *args)
    for word in words:
        assert word in line


def test_crashes_are_listed_with_tick_place_and_cause():
    made = outcome("run", "thesis", "--ticks", 2, "--seed", 1, "--quiet")
    flock = Flock("thesis", rng=1)
    flock.run(2)
    assert made["observables"]["crashes"] == len(flock.crashes) > 0
    listed = made["crashes"]
    assert [one["id"] for one in listed] == flock.crashes.id.tolist()
    assert [one["tick"] for one in listed] == flock.crashes.tick.tolist()
    assert [one["place"] for one in listed] == flock.crashes.place.tolist()
    assert {one["against"] for one in listed} == {"another agent"}


def test_people_see_the_first_crashes_and_how_many_more():
    result = call("run", "thesis", "--agents", 200, "--ticks", 1, "--seed", 1, "--quiet")
    lines = [line for line in result.stdout.splitlines() if "crashed against" in line]
    assert len(lines) == 10
    assert lines[0].startswith("  tick 0: agent ")
    flock = Flock("thesis", agents=200, rng=1)
    flock.run(1)
    assert f"and {len(flock.crashes) - 10} more; --json has all of them" in result.stdout


def test_a_flock_that_cannot_crash_has_no_list():
    made = outcome(*RUN, "--ticks", 1, "--observe", "all")
    assert "crashes" not in made
    assert made["observables"]["crashes"] is None
    assert not math.isnan(made["observables"]["polarisation"])
