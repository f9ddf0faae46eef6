"""`flockscope flight`: what it prints, writes and refuses."""

import csv
import json

import numpy as np
import pytest
from cli.calling import call, refusal

from app.flight.compared_flight import parse_pushes
from app.flight.flight_pictures import mean_beat


def rows(path):
    """A CSV file as dictionaries of numbers."""
    with path.open() as file:
        return [{key: float(v or "nan") for key, v in row.items()} for row in csv.DictReader(file)]


def test_trim_prints_json_and_writes_its_files(tmp_path, trims):
    result = call("flight", "trim", "--json", "--quiet", "--out", tmp_path)
    assert result.exit_code == 0, result.stderr
    assert result.stderr == ""
    made = json.loads(result.stdout)
    assert made["energy_per_metre"] == pytest.approx(trims[3.5].energy_per_metre, rel=1e-6)
    assert made["amplitude"] == pytest.approx(np.degrees(trims[3.5].amplitude), rel=1e-6)
    assert made["stable"] is True
    assert {path.name for path in tmp_path.iterdir()} == {"beat.csv", "beat.png", "beat.svg"}
    beat = rows(tmp_path / "beat.csv")
    assert np.mean([row["power_W"] for row in beat]) == pytest.approx(made["power"], rel=1e-6)
    assert np.mean([row["lift_N"] for row in beat]) == pytest.approx(2.943, abs=1e-6)


def test_trim_prints_for_people(tmp_path):
    args = ("--speed", 4, "--set", "suction=0.9", "--out", tmp_path, "--no-pictures")
    result = call("flight", "trim", *args)
    assert result.exit_code == 0, result.stderr
    for word in ("level flight at 4 m/s", "flap amplitude A", "tail angle", "J/m", "|mu|"):
        assert word in result.stdout
    assert {path.name for path in tmp_path.iterdir()} == {"beat.csv"}


def test_sweep_prints_and_draws_the_curve(tmp_path, trims):
    args = ("flight", "sweep", "--speeds", "4,3.5,3.5", "--out", tmp_path)
    result = call(*args)
    assert result.exit_code == 0, result.stderr
    assert "least: 0.520 J/m at 3.5 m/s" in result.stdout
    assert {path.name for path in tmp_path.iterdir()} == {"sweep.csv", "sweep.png", "sweep.svg"}
    kept = rows(tmp_path / "sweep.csv")
    assert [row["speed"] for row in kept] == [3.5, 4.0]
    for row in kept:
        assert row["power"] == pytest.approx(trims[row["speed"]].power, rel=1e-6)
        assert row["propulsive_efficiency"] < 1.0


def test_sweep_names_the_speeds_without_a_flight(tmp_path):
    args = ("--set", "mass=1.2", "--out", tmp_path, "--no-pictures", "--json", "--quiet",
            "--overwrite")  # fmt: skip
    result = call("flight", "sweep", "--speeds", "2,8", *args)
    assert result.exit_code == 0, result.stderr
    made = json.loads(result.stdout)
    assert made["without_flight"] == [2.0]
    assert [row["speed"] for row in made["rows"]] == [8.0]
    assert "no level flight was found at any speed of 2, 2.5 m/s" in refusal(
        "flight", "sweep", "--speeds", "2,2.5", *args
    )


def test_simulate_from_trim_stays_in_trim(tmp_path):
    args = ("flight", "simulate", "--seconds", 2, "--json", "--quiet", "--out", tmp_path)
    made = json.loads(call(*args).stdout)
    assert made["beats"] == 3
    assert made["mean_speed"] == pytest.approx(3.5, abs=1e-6)
    assert made["climbed"] == pytest.approx(0.0, abs=1e-6)
    assert made["mean_lift"] == pytest.approx(made["weight"], rel=1e-5)
    assert made["left_of_push"] == [None] * 4
    assert {path.name for path in tmp_path.iterdir()} == {
        "history.csv", "history.png", "history.svg", "beats.png", "beats.svg",
    }  # fmt: skip
    assert [row["beats"] for row in rows(tmp_path / "history.csv")][96] == pytest.approx(1.0)


def test_simulate_shows_a_push_die_out(tmp_path):
    args = ("--push", "u=0.2", "--push", "theta=3", "--no-pictures", "--out", tmp_path, "--quiet")
    result = call("flight", "simulate", "--speed", 4, "--seconds", 6, *args)
    assert result.exit_code == 0, result.stderr
    assert "is left after 9 beats" in result.stdout
    left = float(result.stdout.partition("of the push")[2].split()[0])
    assert 0.0 < left < 0.3
    speeds = [row["speed_m_per_s"] for row in rows(tmp_path / "history.csv")]
    assert abs(np.mean(speeds[-96:]) - 4.0) < 0.05 < np.ptp(speeds[:96])


def test_beats_are_averaged_by_phase(trims):
    beat = trims[3.5].beat
    twice = beat._replace(**{name: np.tile(getattr(beat, name), 2) for name in beat._fields})
    twice.lift[:512] += 1.0
    mean = mean_beat(twice, 512)
    assert mean.lift == pytest.approx(beat.lift + 0.5)
    assert mean.bands["lift"][1] - mean.bands["lift"][0] == pytest.approx(np.ones(512))
    assert mean.power == pytest.approx(beat.power)


def test_pushes_are_read_in_degrees():
    assert parse_pushes(["u=-1", "theta=18"]) == {0: -1.0, 3: pytest.approx(np.pi / 10)}


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("trim", "--speed", 1), "--speed 1 m/s is outside [2, 15] m/s"),
        (("trim", "--speed", "nan"), "--speed nan m/s is outside [2, 15] m/s"),
        (("trim", "--frequency", 7), "--frequency 7 Hz is outside [0.5, 6] Hz"),
        (("sweep", "--twist", 50), "--twist 50 deg is outside [0, 45] deg"),
        (("trim", "--set", "mas=1"), "unknown parameter 'mas': did you mean 'mass'?"),
        (("trim", "--set", "mass=9"), "mass = 9 kg is outside [0.05, 5] kg (--set)"),
        (("trim", "--set", "wing_mass=0.2"), "with mass = 0.3 kg (--set)"),
        (("trim", "--set", "mass"), "--set mass is not of the form NAME=VALUE"),
        (("trim", "--set", "mass=2", "--quiet"), "no level flight was found at 3.5 m/s"),
        (("sweep", "--speeds", "x"), "--speeds 'x' is not a number"),
        (("sweep", "--speeds", "3,20"), "--speeds 20 m/s is outside [2, 15] m/s"),
        (("simulate", "--seconds", 0), "--seconds 0 s is outside [0.1, 120] s"),
        (("simulate", "--push", "v=1"), "unknown push 'v'"),
        (("simulate", "--push", "u"), "--push u is not of the form NAME=VALUE"),
        (("simulate", "--push", "u=fast"), "--push u=fast: 'fast' is not a number"),
        (("simulate", "--push", "theta=90"), "--push theta = 90 deg is outside [-60, 60] deg"),
    ],
)
def test_what_cannot_be_done_is_told_in_one_line(args, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert said in refusal("flight", *args)
    assert not (tmp_path / "results").exists()


def test_a_folder_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    line = refusal("flight", "trim", "--speed", 4, "--quiet", "--out", tmp_path / "file" / "deep")
    assert "cannot be written" in line
