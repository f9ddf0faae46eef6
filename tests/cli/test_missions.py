"""`flockscope run` and `list` for models that are at home among obstacles."""

import json
import math

import numpy as np
import pyarrow.parquet as pq
import pytest

from agents import Flock
from agents.catalogue import MODELS
from agents.spec import Spec
from cli.calling import call, refusal

YARD = """
edges = "solid"
size = [40.0, 25.0]

[mission.start]
low = [2.0, 2.0]
high = [9.0, 9.0]

[mission.path]
waypoints = [[20.0, 6.0], [35.0, 12.0]]
switch = 1.0

[mission.goal]
route = [[35.0, 20.0]]

[[obstacle]]
shape = "disc"
name = "pond"
centre = [14.0, 12.0]
radius = 3.0
"""


@pytest.fixture
def yard(tmp_path):
    path = tmp_path / "yard.toml"
    path.write_text(YARD)
    return path


def outcome(*args):
    result = call("run", *args, "--json", "--quiet")
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


def test_a_model_flies_at_home_with_its_own_number_of_agents():
    made = outcome("hwvem-nav", "--ticks", 600, "--seed", 1)
    spec = made["spec"]
    assert (spec["world"], spec["agents"], spec["informed"]) == ("liu2021-mission", 49, 1)
    flock = Flock("hwvem-nav", agents=49, rng=1)
    flock.run(600)
    measured = made["observables"]
    assert {name: flock.observe(name) for name in measured} == measured
    assert {"goal-distance", "following", "inside-obstacles"} <= set(measured)
    assert measured["inside-obstacles"] == 0
    assert (made["time"], made["time_unit"]) == (600, "ticks")


def test_boundary_points_brings_its_flock_to_the_goal_in_seconds():
    made = outcome("boundary-points", "--ticks", 15000, "--seed", 1)
    assert (made["spec"]["world"], made["spec"]["agents"]) == ("wu2023-multi", 30)
    assert made["observables"]["goal-distance"] < 0.01
    assert made["observables"]["inside-obstacles"] == 0
    assert "following" not in made["observables"]
    assert made["time"] == pytest.approx(300.0)
    assert made["time_unit"] == "s"
    shown = call("run", "boundary-points", "--ticks", 250, "--quiet").stdout
    assert "30 agents in wu2023-multi 90 x 90" in shown
    assert "tick 250 = 5 s" in shown
    assert "goal-distance" in shown


def test_what_a_flock_without_goal_or_leader_does_not_have_is_null():
    made = outcome("vem", "--ticks", 1, "--observe", "goal-distance,following,obstacle-distance")
    assert set(made["observables"].values()) == {None}


def test_a_world_file_is_taken_and_its_recording_holds_the_mission(yard, tmp_path):
    path = tmp_path / "run.parquet"
    made = outcome("hwvem-nav", "--world", yard, "--agents", 30, "--ticks", 200, "--seed", 2,
                   "--every", 50, "--record", path)  # fmt: skip
    assert made["spec"]["layout"]["obstacle"][0]["name"] == "pond"
    table = pq.read_table(path)
    assert {"x", "y", "ux", "uy", "speed", "informed", "leg", "layer", "heard"} <= set(
        table.column_names
    )
    tick, informed = table["tick"].to_numpy(), table["informed"].to_numpy(zero_copy_only=False)
    assert sorted(set(tick.tolist())) == [0, 50, 100, 150, 200]
    xy = np.column_stack([table["x"].to_numpy(), table["y"].to_numpy()])
    assert (np.hypot(*(xy - [14.0, 12.0]).T) > 3.0).all()
    end = xy[informed & (tick == 200)][0]
    assert math.dist(end, (20.0, 6.0)) < math.dist(xy[informed & (tick == 0)][0], (20.0, 6.0))
    yard.unlink()
    spec = Spec.from_toml(json.loads(table.schema.metadata[b"flockscope"])["spec"])
    assert Flock.from_spec(spec).world.mission.path.waypoints[1] == (35.0, 12.0)
    again = outcome("--state", path, "--ticks", 100)
    whole = Flock.from_spec(spec)
    whole.run(300)
    assert again["observables"]["polarisation"] == whole.observe("polarisation")


def test_a_saved_spec_carries_its_world(yard, tmp_path):
    spec = tmp_path / "run.toml"
    first = outcome("reynolds", "--world", yard, "--agents", 20, "--ticks", 100, "--seed", 3,
                    "--save-spec", spec)  # fmt: skip
    yard.unlink()
    again = outcome("--spec", spec, "--ticks", 100)
    assert again["spec"] == first["spec"]
    assert again["observables"] == first["observables"]
    elsewhere = outcome("--spec", spec, "--world", "obstacles", "--size", "60,40", "--ticks", 1)
    assert (elsewhere["spec"]["world"], elsewhere["spec"]["layout"]) == ("obstacles", None)


def test_a_flat_layout_in_a_spec_stands_up(tmp_path):
    spec = tmp_path / "run.toml"
    spec.write_text(f'model = "reynolds"\nagents = 9\nseed = 1\n[layout]\n{YARD}'.replace(
        "[mission", "[layout.mission").replace("[[obstacle", "[[layout.obstacle"))  # fmt: skip
    made = outcome("--spec", spec, "--dim", 3, "--ticks", 20)
    assert made["spec"]["size"] == [40.0, 25.0, 4.0]
    assert made["observables"]["inside-obstacles"] == 0


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["hwvem-nav", "--world", "obstacle"], ["'obstacle'", "did you mean 'obstacles'?"]),
        (["reynolds", "--size", "30"], ["size = 30.0", "obstacles has obstacles", "--size"]),
        (["reynolds", "--world", "rooms-3d", "--dim", "2"], ["dim = 2", "rooms-3d", "--dim"]),
        (["boundary-points", "--dim", "3"], ["dim = 3", "defined in 2-D", "--dim"]),
        (["boundary-points", "--world", "rooms-3d"], ["dim = 3", "defined in 2-D", "--world"]),
        (["olfati-saber", "--informed", "1"], ["informed = 1", "no information agents"]),
        (["boundary-points", "--agents", "3000"], ["agents = 3000", "do not fit", "--agents"]),
    ],
)
def test_a_mission_is_refused_in_one_line(args, words):
    line = refusal("run", *args, "--quiet")
    for word in words:
        assert word in line


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (YARD.replace("[14.0, 12.0]", "[3.0, 12.0, 1.0]"), ["obstacle", "pond", "centre"]),
        (YARD.replace("radius = 3.0", "radius = -3.0"), ["pond", "radius", "-3.0"]),
        (YARD.replace("[35.0, 20.0]", "[14.0, 12.0]"), ["goal", "(14, 12)", "inside"]),
        (YARD.replace('edges = "solid"', 'edges = "soild"'), ["'soild'", "'solid'"]),
    ],
)
def test_a_world_that_is_not_sound_is_refused_in_one_line(yard, tmp_path, text, words):
    yard.write_text(text)
    spec = tmp_path / "run.toml"
    spec.write_text(f'model = "reynolds"\n[layout]\n{text}'.replace(
        "[mission", "[layout.mission").replace("[[obstacle", "[[layout.obstacle"))  # fmt: skip
    for line in (refusal("run", "reynolds", "--world", yard), refusal("run", "--spec", spec)):
        for word in words:
            assert word in line
    assert f"layout in {spec}" in refusal("run", "--spec", spec)
    spec.write_text('model = "reynolds"\nlayout = 3\n')
    assert "layout = 3 is not a table" in refusal("run", "--spec", spec)


def test_the_list_of_models_says_where_they_are_at_home():
    rows = {row["name"]: row for row in json.loads(call("list", "models", "--json").stdout)}
    row = rows["boundary-points"]
    assert (row["world"], row["agents"], row["wish"]) == ("wu2023-multi", 30, "acceleration")
    assert (row["body"], row["time_unit"]) == ("double-integrator", "s")
    assert (rows["vem"]["world"], rows["vem"]["agents"]) == ("wrap", 100)
    assert {name: len(one["forces"]) for name, one in rows.items()} == {
        name: len(model.rule.forces) + len(model.body.forces) for name, model in MODELS.items()
    }
    shown = " ".join(call("list", "models").stdout.split())
    assert "30 agents in wu2023-multi; wishes an acceleration" in shown
