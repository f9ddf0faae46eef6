"""`flockscope flight payload`: what a load costs, and what is refused."""

import csv
import json

import pytest
from cli.calling import call, refusal

from agents.flight.aircraft import Aircraft
from app.flight.load import Battery, load_aircraft


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Two loads at one speed, as JSON, and the folder."""
    out = tmp_path_factory.mktemp("payload")
    args = ("--loads", "100,0", "--speed", 4, "--battery", 10, "--efficiency", 0.5)
    result = call("flight", "payload", *args, "--json", "--quiet", "--out", out)
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout), out


def test_loads_are_flown_and_cost_power(made, trims):
    value, out = made
    none, some = value["rows"]
    assert (none["load"], some["load"]) == (0.0, 100.0)
    assert none["power"] == pytest.approx(trims[4.0].power, rel=1e-6)
    assert some["mass"] == pytest.approx(0.4)
    # Induced power goes with the square of the weight, all other power hardly changes.
    assert 1.0 < some["power"] / none["power"] < (0.4 / 0.3) ** 2
    assert value["without_flight"] == []
    assert {path.name for path in out.iterdir()} == {"payload.csv", "payload.png", "payload.svg"}


def test_endurance_is_energy_over_power_and_range_is_speed_times_that(made):
    for row in made[0]["rows"]:
        seconds = 10.0 * 3600.0 * 0.5 / row["power"]
        assert row["endurance"] == pytest.approx(seconds / 3600.0)
        assert row["range"] == pytest.approx(seconds * 4.0 / 1000.0)
    with (made[1] / "payload.csv").open() as file:
        kept = list(csv.DictReader(file))
    assert [float(row["endurance"]) for row in kept] == pytest.approx(
        [row["endurance"] for row in made[0]["rows"]]
    )
    assert Battery(5.0, 0.45).hours(2.25) == pytest.approx(1.0)


def test_a_load_that_no_flight_carries_at_a_speed_is_named(tmp_path):
    args = ("--loads", "0,1500", "--speed", 3.5, "--no-pictures", "--quiet", "--out", tmp_path)
    result = call("flight", "payload", *args)
    assert result.exit_code == 0, result.stderr
    assert "1500    no level flight was found" in result.stdout


def test_a_load_is_mass_and_nothing_else():
    bare = Aircraft()
    heavy = load_aircraft(bare, 0.2)
    assert heavy.mass == pytest.approx(0.5)
    assert heavy.model_dump(exclude={"mass"}) == bare.model_dump(exclude={"mass"})


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("--loads", "-1"), "--loads -1 g is outside [0, 4950] g"),
        (("--loads", "4800"), "--loads 4800 g is outside [0, 4700] g with mass = 0.3 kg"),
        (("--loads", "x"), "--loads 'x' is not a number"),
        (("--speed", 1), "--speed 1 m/s is outside [2, 15] m/s"),
        (("--battery", 0), "--battery 0 Wh is outside [0.01, 1000] Wh"),
        (("--efficiency", 2), "--efficiency 2 is outside [0.01, 1]"),
    ],
)
def test_what_cannot_be_is_one_line(args, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert said in refusal("flight", "payload", *args)
    assert not (tmp_path / "results").exists()
