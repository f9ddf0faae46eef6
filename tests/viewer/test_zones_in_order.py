"""Zones keep their order while a slider is moved."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.flock import Flock
from agents.spec import Spec
from app.viewer.run.flock_run import are_zones_nested, nearest_allowed, radii, zone_notice
from app.viewer.run.frame_builder import FrameRequest
from app.viewer.run.paired_run import PairedRun, companion
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation import Simulation
from worlds.input_error import InputError


@pytest.fixture(scope="module")
def flock() -> Flock:
    return Flock("safe", agents=4, rng=1)


@pytest.mark.parametrize(
    ("name", "value", "taken"),
    [
        ("d_r", 2.0, 2.0),
        ("d_r", 2.5, 2.5),
        ("d_r", 4.0, 2.5),
        ("d_o", 1.0, 1.34),
        ("d_o", 9.0, 5.0),
        ("d_a", 0.1, 2.5),
        ("d_a", 30.0, 30.0),
        ("alpha", 360.0, 360.0),
    ],
)
def test_a_zone_stops_where_the_next_one_ends(flock, name, value, taken):
    assert nearest_allowed(flock, name, value) == taken


@settings(max_examples=60, deadline=None)
@given(
    st.tuples(*[st.floats(0.05, 30.0)] * 3).map(sorted),
    st.sampled_from(["d_r", "d_o", "d_a"]),
    st.floats(0.05, 30.0),
)
def test_zones_in_order_stay_in_order_and_the_value_is_the_nearest(flock, before, name, value):
    flock.set(**dict(zip(("d_r", "d_o", "d_a"), before, strict=True)))
    taken = nearest_allowed(flock, name, value)
    place = ("d_r", "d_o", "d_a").index(name)
    low, high = ([0.05, *before][place], [*before, 30.0][place + 1])
    assert taken == min(max(value, low), high)


def test_zones_that_are_out_of_order_already_are_left_alone():
    flock = Flock("safe", agents=4, rng=1, d_r=6.0)
    assert not are_zones_nested(radii(flock, flock.parameters))
    assert nearest_allowed(flock, "d_r", 8.0) == 8.0


def test_widths_and_rules_without_zones_know_no_order():
    assert nearest_allowed(Flock("couzin", agents=4, rng=1), "dr_o", 0.0) == 0.0
    assert nearest_allowed(Flock("vem", agents=4, rng=1), "r", 0.1) == 0.1
    assert nearest_allowed(Flock("safe", agents=4, rng=1), "contact", "start") == "start"


def test_it_is_told_and_the_answer_is_the_value_taken():
    simulation = Simulation(preset_spec("safe", agents=4), running=False)
    try:
        assert simulation.ready.wait(60)
        assert simulation.set("d_r", 4.0).result(60) == 2.5
        assert simulation.state.values["d_r"] == 2.5
        words = "d_r stops at 2.5: repulsion ends at 2.5, orientation ends at 2.5"
        assert words in simulation.notices.get(timeout=60)
        with pytest.raises(InputError, match="alpha = 999"):
            simulation.set("alpha", 999.0).result(60)
    finally:
        simulation.close()


def test_of_two_models_both_keep_their_order():
    first = Flock(preset_spec("thesis", agents=4))
    both = PairedRun(first, companion(first, Spec("safe")), 1, FrameRequest())
    both.second.flock.set(d_o=2.0)
    assert both.allowed("d_r", 2.3) == 2.0
    assert "d_r" in zone_notice(first, "d_r", 2.5)
