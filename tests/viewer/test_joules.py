"""What formation saves in joules per metre."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from agents.flight.trim import trim
from app.viewer.measuring.flock_numbers import EnergySavings, energy_in_trim
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.run.run_preset import preset_spec
from tests.viewer.stub_flock import StubFlock
from tests.viewer.waiting import until


def test_joules_are_those_of_the_aircraft_in_trim_and_come_later():
    joules = EnergySavings()
    assert joules.energy_alone(3.52) is None
    alone = until(lambda: joules.energy_alone(3.52), 120)
    assert alone == pytest.approx(trim(speed=3.5).energy_per_metre, rel=1e-6)


def test_what_is_saved_is_a_share_of_them():
    joules, readings = EnergySavings(), FlockReadings(StubFlock(preset_spec(agents=4)))
    joules.known[3.0] = 0.5
    assert joules.describe(readings) == "–"
    readings.flock.parameters = SimpleNamespace(v0=3.0)
    assert joules.describe(readings) == "–"
    readings.values["energy-saved"] = 20.0
    assert joules.describe(readings) == "0.100 of 0.50"


def test_where_the_aircraft_cannot_fly_nothing_is_told():
    joules = EnergySavings()
    assert energy_in_trim(40.0) is None
    assert joules.energy_alone(40.0) is None
    until(lambda: joules.energy_alone(40.0) is None and 40.0 in joules.known)
