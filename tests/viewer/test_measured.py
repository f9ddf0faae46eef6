"""What the laboratory measures beside what it always does, and how it tells it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.observables.catalogue import OBSERVABLES
from agents.observables.observable import Range
from app.viewer.lab.panels.flock_monitors import size_bars
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.observable_format import (
    cards,
    format_observable,
    offered_observables,
    scale,
    unit,
)
from app.viewer.run.run_preset import preset_spec
from tests.viewer.stub_flock import StubFlock
from tests.viewer.waiting import until
from worlds.world import World


def test_a_flock_is_offered_what_says_something_about_it():
    plain, solid, led = (
        offered_observables(Flock(name, agents=5, rng=1)) for name in ("vem", "safe", "hwvem-nav")
    )
    assert {"polarisation", "correlation-length", "groups"} <= set(plain)
    assert not {"goal-distance", "following", "crashes", "drag-saved", "group-table"} & set(plain)
    assert not {"susceptibility", "binder", "layers"} & set(plain)
    assert {"crashes", "drag-saved", "energy-saved"} <= set(solid)
    assert {"goal-distance", "following", "inside-obstacles"} <= set(led)


def test_every_observable_on_offer_can_be_measured_of_a_snapshot():
    for name, ticks in (("hwvem-nav", 0), ("safe", 3)):
        flock = Flock(name, agents=20, rng=2)
        flock.advance(ticks)
        readings = FlockReadings(flock, watched=frozenset(offered_observables(flock)))
        readings.read(at_once=True)
        for one in offered_observables(flock):
            assert readings.values[one] == pytest.approx(float(flock.observe(one)), nan_ok=True), (
                one
            )


def test_a_snapshot_stays_as_it_was():
    flock = Flock("vem", agents=30, rng=2, eta=1.0)
    now, before = flock.snapshot(), flock.observe("correlation-length")
    flock.advance(5)
    assert OBSERVABLES["correlation-length"].measure(now) == before
    assert flock.observe("correlation-length") != before


def test_what_is_not_watched_any_more_is_not_shown_any_more():
    readings = FlockReadings(Flock("vem", agents=20, rng=2))
    readings.read(at_once=True)
    assert "nearest-neighbour" not in readings.values
    readings.watch(frozenset({"nearest-neighbour"}))
    readings.read(at_once=True)
    assert readings.values["nearest-neighbour"] == readings.flock.observe("nearest-neighbour")
    readings.watch(frozenset())
    readings.read(at_once=True)
    assert "nearest-neighbour" not in readings.values
    assert {"groups", "polarisation"} <= set(readings.values)


def test_what_is_costly_is_measured_aside_and_comes_later():
    flock = Flock("vem", agents=50, rng=2)
    readings = FlockReadings(flock, watched=frozenset({"correlation-length"}))
    readings.read()
    assert "polarisation" in readings.values
    assert "correlation-length" not in readings.values
    measured = flock.observe("correlation-length")
    flock.advance(2)

    def come() -> bool:
        readings.read()
        return "correlation-length" in readings.values

    until(come)
    assert readings.values["correlation-length"] == pytest.approx(measured)


def test_fluctuations_are_of_the_plotted_part_of_the_run():
    readings = FlockReadings(StubFlock(preset_spec(agents=8)))
    series = [0.0] * 100 + [0.2, 0.4] * 50
    for tick, value in enumerate(series):
        readings.series("polarisation").add(tick, value)
    assert readings.over("susceptibility", last=99) == pytest.approx(8 * 0.01)
    assert readings.over("susceptibility") == pytest.approx(8 * np.var(series))
    assert readings.over("binder", last=99) == pytest.approx(1 - 0.0136 / 3 / 0.1**2)
    assert math.isnan(FlockReadings(StubFlock(preset_spec(agents=8))).over("binder"))


def test_only_those_that_fly_are_counted():
    flock = Flock("safe", agents=12, rng=4)
    flock.arrays.crash_record[:4, :2] = [0, 1]
    readings = FlockReadings(flock)
    readings.read(at_once=True)
    assert len(readings.crashes) == 4
    assert readings.sizes.sum() == 8
    assert readings.values["polarisation"] == pytest.approx(
        np.linalg.norm(flock.heading[4:].mean(axis=0))
    )
    for tick, value in enumerate([0.2, 0.4]):
        readings.series("polarisation").add(tick, value)
    assert readings.over("susceptibility") == pytest.approx(8 * 0.01)


def test_a_flock_that_has_all_crashed_is_told_without_an_error():
    flock = Flock("safe", agents=6, rng=4)
    flock.advance(2)
    flock.arrays.crash_record[:, :2] = [0, 1]
    readings = FlockReadings(flock, watched=frozenset(offered_observables(flock)))
    readings.read(at_once=True)
    assert len(readings.crashes) == 6
    assert (readings.values["groups"], len(readings.sizes)) == (0.0, 0)


def test_scales_come_from_the_declared_ranges():
    assert scale("polarisation") == Range(0.0, 1.0)
    assert scale("largest-group") == Range(0.0, math.inf, "N")
    assert scale("drag-saved") == Range(-math.inf, math.inf)
    assert [unit(name) for name in ("correlation-length", "groups")] == ["length", ""]


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("polarisation", 1.0, "1.000"),
        ("groups", 3.0, "3"),
        ("correlation-length", 3.14159, "3.14"),
        ("correlation-length", math.nan, "–"),
        ("obstacle-distance", math.inf, "far"),
        ("energy-saved", -1.26, "-1.3 %"),
        ("groups", None, "–"),
    ],
)
def test_values_are_told_in_few_figures(name, value, text):
    assert format_observable(name, value) == text


def test_energy_is_told_only_of_those_who_measure_it():
    energy = {"drag-saved": 20.0, "energy-saved": 7.0}
    world = World("wrap", (5.0, 5.0), ("wrap", "wrap"))
    without = cards("flock", world, {"polarisation": 1.0})
    assert not {"drag saved", "power saved"} & set(without)
    told_ones = cards("flock", world, {"polarisation": 1.0} | energy)
    assert told_ones == without | {"drag saved": "20.0 %", "power saved": "7.0 %"}


def test_cards_are_written_as_declared_and_a_dash_stands_for_what_is_not_known_yet():
    world, vem, unled = (
        World("wrap", (5.0, 5.0), ("wrap", "wrap")),
        *(MODELS[name] for name in ("vem", "boundary-points")),
    )
    values = {"polarisation": 0.98765, "consistency": 0.98765, "mean-neighbours": 4.0}
    assert cards("flock", world, values, vem) == {
        "polarisation": "0.988",
        "consistency": "0.9877",
        "angular momentum": "–",
        "neighbours": "4.0",
        "groups": "–",
        "largest group": "–",
    }
    assert "consistency" not in cards("flock", world, {}, vem), "no information agent leads it"
    assert "consistency" not in cards("flock", world, values, unled)


def test_groups_are_bars_the_largest_first():
    bars = size_bars(np.arange(20, 0, -1))
    assert bars.count("<i ") == 12
    assert "and 8 more" in bars
    assert bars.index(">20<") < bars.index(">19<")
    assert "height:34px" in bars
