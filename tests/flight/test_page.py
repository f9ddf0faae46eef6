"""The page on flight says what is declared and what the code computes."""

import re
from pathlib import Path

import pytest
from cli.calling import call

from agents.flight.aircraft import Aircraft
from agents.models.declare import declared

PAGE = (Path(__file__).parents[2] / "docs" / "flight.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("one", declared(Aircraft), ids=lambda one: one.name)
def test_every_value_of_the_aircraft_is_on_the_page_and_in_the_list(one):
    unit = "" if one.unit == "1" else f" {one.unit}"
    row = f"| `{one.name}` | {one.default:.4g}{unit} | {one.description} ({one.source}) |"
    assert row in PAGE
    (line,) = [
        line for line in call("flight", "aircraft").stdout.splitlines()
        if line.startswith(f"{one.name} ")
    ]  # fmt: skip
    assert one.allowed in line
    assert line.endswith(f"{one.description} ({one.source})")


@pytest.mark.exhaustive
def test_the_energies_of_the_page_are_those_of_the_code(trims):
    for speed in (3.0, 3.5, 4.0, 5.0, 6.0):
        made = trims[speed]
        (row,) = re.findall(rf"^\| {speed:g} m/s .*$", PAGE, re.MULTILINE)
        assert f"| {made.energy_per_metre:.3f} J/m |" in row
        assert f"| {made.power:.2f} W |" in row
        assert row.endswith(f" {abs(made.multipliers[0]):.2f} |")
