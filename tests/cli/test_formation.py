"""`flockscope formation`: numbers, files, pictures, refusals."""

import csv
import json

import pytest

from agents.flight.aircraft import Aircraft
from agents.flight.trim import trim
from app.studies.experiment_reader import read_experiment
from cli.calling import call, refusal

ENERGY = read_experiment("formation-echelon").settings.energy


def made(*args):
    result = call("formation", *args, "--json", "--quiet")
    assert result.exit_code == 0, result.stderr
    assert result.stderr == ""
    return json.loads(result.stdout)


def test_spacing_stands_beside_the_thesis(tmp_path):
    value = made("spacing", "--out", tmp_path)
    assert value["best"]["tip"] == pytest.approx(-0.137, abs=5e-4)
    assert value["best"]["saved"] == pytest.approx(0.692, abs=5e-4)
    assert value["thesis"]["tip"] == pytest.approx(-0.1073, abs=1e-4)
    assert {path.name for path in tmp_path.iterdir()} == {
        "spacing.csv",
        "spacing.png",
        "spacing.svg",
    }
    rows = list(csv.DictReader((tmp_path / "spacing.csv").open()))
    best = max(rows, key=lambda row: float(row["saved"]))
    assert float(best["tip_per_span"]) == pytest.approx(value["best"]["tip"], abs=1e-3)
    bare = max(rows, key=lambda row: float(row["saved_without_core"]))
    assert float(bare["tip_per_span"]) == pytest.approx(-0.1073, abs=1e-3)


def test_without_a_core_the_best_spacing_is_that_of_the_thesis(tmp_path):
    result = call("formation", "spacing", "--core", 0, "--out", tmp_path, "--no-pictures")
    best, thesis = result.stdout.splitlines()
    assert "-0.1073 b = -0.268 m" in best
    assert "-0.1073 b = -0.268 m" in thesis
    assert "spacing.csv" in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["spacing.csv"]


def test_a_v_saves_in_percent_and_joules_per_metre(tmp_path):
    value = made("vee", "--energy", 0.5, "--jitter", "0,0.1", "--draws", 100, "--out", tmp_path)
    exact, shaken = value["rows"]
    assert exact["power"] == pytest.approx(23.9, abs=0.1)
    assert exact["power_5"] == exact["power_95"] == exact["power"]
    assert shaken["power_5"] < shaken["power"] < shaken["power_95"] < exact["power"]
    for row in value["rows"]:
        assert row["energy"] == pytest.approx(row["power"] / 100 * 0.5)
        assert row["power"] == pytest.approx(0.35 * row["saved"])
    assert len(value["exact"]) == 8
    assert (tmp_path / "vee.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_the_same_seed_gives_the_same_draws(tmp_path):
    args = ("vee", "--energy", 1, "--jitter", 0.2, "--draws", 20, "--out", tmp_path)
    first, again, other = (
        made(*args, "--no-pictures", "--overwrite", "--seed", seed)["rows"] for seed in (3, 3, 4)
    )
    assert first == again
    assert first != other


def test_the_joules_are_those_of_the_aircraft_in_trim(tmp_path):
    value = made("vee", "--jitter", 0, "--speed", 4, "--out", tmp_path, "--no-pictures")
    assert 0.3 < value["energy_alone"] < 0.8


def test_the_map_holds_a_share_for_every_place(tmp_path):
    value = made("map", "--behind", 2, "--out", tmp_path)
    assert value["best"]["saved"] == pytest.approx(0.70, abs=0.01)
    rows = [
        [float(one) for one in row]
        for row in csv.reader((tmp_path / "map.csv").read_text().splitlines()[1:])
    ]
    behind, aside, _ = max(rows, key=lambda row: row[2])
    assert abs(aside) == pytest.approx(0.863, abs=0.02)
    assert behind > 0.5
    assert min(rows, key=lambda row: row[2])[1] == pytest.approx(0.0, abs=0.11)
    assert (tmp_path / "map.svg").stat().st_size > 1000


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("spacing", "--core", -1), "--core -1 is outside [0, 1]"),
        (("spacing", "--span", "nan"), "--span nan is outside"),
        (("vee", "--birds", 0), "--birds 0"),
        (("vee", "--jitter", "much"), "--jitter 'much' is not a number"),
        (("vee", "--jitter", "-0.1"), "--jitter -0.1 is outside"),
        (("vee", "--induced", 1.5), "--induced 1.5 is outside [0, 1]"),
        (("vee", "--draws", 0), "--draws 0"),
        (("vee", "--speed", 0.1), "speed"),
        (("map", "--behind", 99), "--behind 99 is outside"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(args, words, tmp_path):
    assert words in refusal("formation", *args, "--out", tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    line = refusal("formation", "spacing", "--out", tmp_path / "file", "--quiet")
    assert "cannot be written" in line


@pytest.mark.exhaustive
def test_the_experiment_measures_what_slots_buy(tmp_path):
    result = call(
        "paper", "formation-echelon", "--agents", 20, "--runs", 3, "--json", "--quiet",
        "--out", tmp_path,
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    rows = json.loads(result.stdout)["rows"]
    found = {(row["label"], row["measure"]): row for row in rows}
    assert found["echelons", "saved"]["mean"] > 60.0
    assert found["zones alone", "saved"]["mean"] < 0.0
    for label in ("echelons", "zones alone"):
        saved, power, joules = (found[label, one]["mean"] for one in ("saved", "power", "joules"))
        assert power == pytest.approx(0.35 * saved)
        assert joules == pytest.approx(1000.0 * power / 100.0 * ENERGY)
    assert (tmp_path / "formation-echelon.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_the_joules_of_the_experiment_are_those_of_the_aircraft_in_trim():
    assert trim(Aircraft(), 3.5).energy_per_metre == pytest.approx(ENERGY, abs=0.0005)
