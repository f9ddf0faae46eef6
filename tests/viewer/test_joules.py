"""What formation saves in joules per metre."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from agents.flight.trim import trim
from app.viewer.measuring.flock_numbers import EnergySavings, trimmed
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.run.run_preset import at_home
from tests.viewer.stub_flock import StubFlock
from tests.viewer.waiting import until


def test_joules_are_those_of_the_aircraft_in_trim_and_come_later():
    joules = EnergySavings()
    assert joules.alone(3.52) is None
    alone = until(lambda: joules.alone(3.52), 120)
    assert alone == pytest.approx(trim(speed=3.5).energy_per_metre, rel=1e-6)


def test_what_is_saved_is_a_share_of_them():
    joules, readings = EnergySavings(), FlockReadings(StubFlock(at_home(agents=4)))
    joules.known[3.0] = 0.5
    assert joules.saved(readings) == "–"
    readings.flock.parameters = SimpleNamespace(v0=3.0)
    assert joules.saved(readings) == "–"
    readings.values["energy-saved"] = 20.0
    assert joules.saved(readings) == "0.100 of 0.50"


def test_where_the_aircraft_cannot_fly_nothing_is_told():
    joules = EnergySavings()
    assert trimmed(40.0) is None
    assert joules.alone(40.0) is None
    until(lambda: joules.alone(40.0) is None and 40.0 in joules.known)
