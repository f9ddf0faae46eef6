"""`flockscope live check RECORDING`, and tables whose quaternions are written w first."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from live.driven_tables import leaping, straight, swapped, table
from live.recordings import write_trial
from live.test_live_record import record

from app.live.sources.source_catalogue import open_source
from cli.calling import call, refusal
from worlds.input_error import InputError


def values(*arguments):
    """What a check says as JSON, whatever its exit code."""
    return json.loads(call("live", "check", *arguments, "--json").stdout)


def test_a_sound_recording_passes_and_says_by_how_much(tmp_path):
    made = call("live", "check", table(tmp_path))
    assert made.exit_code == 0
    assert "'red': tracked in 400 frames" in made.stdout
    assert "vertical axis: z, 0.0 degrees from up; upright in 100 %" in made.stdout
    assert "yaw: 0.0 degrees from the direction of motion in the mean; agrees in 100 %" in (
        made.stdout
    )
    assert made.stdout.splitlines()[-1] == "  nothing speaks against driving by this tracking"


def test_quaternions_written_w_first_are_refused_with_their_cure(tmp_path):
    path = table(tmp_path, w_first=True)
    line = refusal("live", "check", path, "--quiet")
    assert "no other axis stays vertical" in line
    assert line.endswith("the poses make sense with ?quaternion=wxyz")
    with pytest.raises(InputError, match=r"sound if w comes first: add \?quaternion=wxyz"):
        open_source(f"recorded:{path}")
    found = values(f"{path}?quaternion=wxyz")
    assert found["amiss"] == []
    assert found["bodies"]["red"]["yaw"]["difference"] == pytest.approx(0.0, abs=1e-6)
    cured = open_source(f"recorded:{path}?quaternion=wxyz").recording()
    sound = open_source(f"recorded:{table(tmp_path)}").recording()
    for ours, theirs in zip(cured, sound, strict=True):
        for one, other in zip(ours.sightings, theirs.sightings, strict=True):
            assert (one.pose.x, one.pose.y) == (other.pose.x, other.pose.y)
            assert math.remainder(one.pose.yaw - other.pose.yaw, math.tau) == pytest.approx(
                0.0, abs=1e-9
            )


def test_cars_that_stand_at_yaw_0_w_first_lie_on_their_roofs(tmp_path):
    path = table(tmp_path, w_first=True, where=lambda _, phase: (0.0, phase, 0.0))
    assert "its axis -z points up, not z" in refusal("live", "check", path, "--quiet")
    with pytest.raises(InputError, match=r"\?quaternion=wxyz"):
        open_source(f"recorded:{path}")


def test_cars_that_drive_along_minus_x_w_first_stand_upright_and_are_found_by_their_way(tmp_path):
    """Their quaternion (w, x, y, z) is (0, 0, 0, 1): read w last that is yaw 0, for ever."""
    path = table(tmp_path, w_first=True, where=straight)
    line = refusal("live", "check", path, "--quiet")
    assert "red: it drives backwards in 100 % of its way" in line
    assert line.endswith("the poses make sense with ?quaternion=wxyz")
    with pytest.raises(InputError, match=r"\?quaternion=wxyz"):
        open_source(f"recorded:{path}")
    declared = open_source(f"recorded:{path}?quaternion=xyzw")  # a car that really backs
    assert declared.recording()[0].sightings[0].pose.yaw == 0.0


def test_a_yaw_that_never_turns_is_found(tmp_path):
    path = table(
        tmp_path,
        frames=1200,
        change=lambda _, rows: {name: [*row[:3], 0.0, 0.0, 0.0, 1.0] for name, row in rows.items()},
    )
    line = refusal("live", "check", path, "--quiet")
    assert "red: its yaw stays 0 degrees while it moves in many directions" in line


@pytest.mark.parametrize(("nose", "off"), [("y", -90.0), ("-y", 90.0)])
def test_a_wrong_nose_is_found_and_the_right_one_named(tmp_path, nose, off):
    found = values(f"{table(tmp_path)}?nose={nose}")
    assert found["bodies"]["red"]["yaw"]["difference"] == pytest.approx(off, abs=1e-6)
    assert found["cure"] == "nose=x"


def test_names_that_are_swapped_are_counted(tmp_path):
    found = values(table(tmp_path, change=swapped(200, 300)))
    assert [(one["number"], one["one"], one["other"]) for one in found["swaps"]] == [
        (200, "blue", "red"),
        (300, "blue", "red"),
    ]
    assert found["amiss"] == ["bodies change places 2 times, first 'blue' and 'red' in frame 200"]


def test_jumps_that_no_car_can_make_are_counted(tmp_path):
    found = values(table(tmp_path, change=leaping(50)))
    assert found["bodies"]["red"]["jumps"] == 2
    assert found["bodies"]["red"]["worst_jump"]["number"] in (50, 51)
    assert found["bodies"]["blue"]["jumps"] == 0
    line = refusal("live", "check", table(tmp_path, change=leaping(50)), "--quiet")
    assert line.startswith("flockscope: red: it jumps 2 times as no car can, the furthest ")
    assert values(table(tmp_path, change=leaping(50, 2.2)), "--speed", 10)["amiss"] == []


def test_a_live_run_is_checked_by_its_own_cars(tmp_path):
    record(tmp_path / "run", 100, seed=2)
    found = values(tmp_path / "run")
    assert found["bodies"]["red"]["vertical"] is None
    assert found["bodies"]["red"]["worst_jump"]["distance"] > 9.0
    assert any("as no car can" in fault for fault in found["amiss"])


def test_what_is_no_recording_is_refused(tmp_path):
    path = table(tmp_path, frames=2)
    assert "cannot be read" in refusal("live", "check", tmp_path / "none.csv")
    assert "no ticks.parquet" in refusal("live", "check", tmp_path)
    assert "--speed 0 m/s is outside (0, 10]" in refusal("live", "check", path, "--speed", 0)
    assert "are for a laboratory's file" in refusal("live", "check", path, "--file-only")
    assert "unknown order of quaternions 'zyxw'" in refusal(
        "live", "check", f"{path}?quaternion=zyxw"
    )
    assert "unknown option 'speed'" in refusal("live", "check", f"{path}?speed=1")


def test_a_trial_without_a_unit_names_the_option_and_takes_it(tmp_path):
    path = tmp_path / "trial.c3d"
    points = np.zeros((3, 2, 100))
    points[0, 0] = 10.0 * np.arange(100)
    points[0, 1] = points[0, 0] + 200.0
    body = "body=red,rear,front"
    for units, says in (("", "has no unit"), ("inch", "has the unknown unit of length 'inch'")):
        write_trial(path, ("rear", "front"), points, units=units)
        line = refusal("live", "check", f"{path}?{body}")
        assert line == (
            f"flockscope: {path} {says} (POINT:UNITS): declare that of its numbers, ?unit=m, cm, "
            "mm, in, ft"
        )
        for unit, metres in (("mm", 0.99), ("cm", 9.9)):
            frames = open_source(f"recorded:{path}?{body}&unit={unit}").recording()
            assert frames[-1].sightings[0].pose.x == pytest.approx(metres)
    assert values(f"{path}?{body}&unit=mm")["amiss"] == []
    assert "unknown unit 'inch'" in refusal("live", "check", f"{path}?{body}&unit=inch")
    write_trial(path, ("rear", "front"), points, units="mm")
    assert "unit = cm is declared, but" in refusal("live", "check", f"{path}?{body}&unit=cm")
    assert values(f"{path}?{body}&unit=mm")["amiss"] == []


def test_a_trial_of_rotations_is_judged_by_its_axes(tmp_path):
    path = tmp_path / "trial.c3d"
    matrices = np.zeros((4, 4, 1, 20))
    matrices[:] = np.diag([1.0, -1.0, -1.0, 1.0])[:, :, None, None]  # on its roof
    write_trial(path, ("m",), np.ones((3, 1, 20)), matrices, ("red",))
    found = values(path)
    assert found["bodies"]["red"]["vertical"] == {"axis": "-z", "tilt": 0.0, "upright": 1.0}
    assert found["cure"] == "top=-z"
    assert values(f"{path}?top=-z")["amiss"] == []
