"""Pace, rate limits, plots and notation: what the viewer counts and words by itself."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from agents.catalogue import MODELS
from app.viewer.lab.panels.flock_monitors import layer_bars
from app.viewer.measuring.background_worker import WorkThrottle
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.panels.dials import equation_svg, plain_symbol
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation_limits import ANSWER, Pace
from tests.viewer.stub_flock import StubFlock


def test_readings_count_layers_and_leave_the_unknown_out():
    flock = StubFlock(preset_spec(agents=5))
    flock.position = np.array([[1.0, 1.0], [1.5, 1.0], [1.0, 1.5], [3.5, 3.0], [3.5, 3.2]])
    readings = FlockReadings(flock)
    readings.read(at_once=True)
    assert readings.layers.tolist() == [1, 2]
    assert readings.unknown == 2
    assert readings.values["groups"] == 2.0
    assert readings.values["largest-group"] == 3.0
    assert readings.values["mean-neighbours"] == pytest.approx(8 / 5)
    assert readings.values["polarisation"] == 1.0
    assert readings.values["following"] == pytest.approx(3 / 5)
    assert readings.sizes.tolist() == [3, 2]
    assert readings.series("groups").arrays()[1].tolist() == [2.0]


def test_deep_layers_share_the_last_bar():
    assert layer_bars([1] * 40, 3).count("<i ") == 13
    assert ">29<" in layer_bars([1] * 40, 3)


def test_a_ration_gives_costly_work_its_share():
    rate_limit = WorkThrottle(period=0.1, share=0.1)
    rate_limit.note_duration(0.0, 50.0)
    assert rate_limit.is_due(0.1), "the first time may have had to compile"
    rate_limit.note_duration(1.0, 0.05)
    assert not rate_limit.is_due(1.4)
    assert rate_limit.is_due(1.5)


def test_a_pace_counts_ticks_and_does_not_catch_up():
    pace = Pace(10.0)
    pace.cost = 1e-6
    assert [pace.ticks_due(now) for now in (5.0, 5.05, 5.1, 5.35)] == [1, 0, 1, 2]
    assert pace.ticks_due(60.0) > 1
    assert pace.ticks_due(60.01) == 0


def test_a_pace_keeps_calls_short_at_full_speed():
    pace = Pace(math.inf)
    assert pace.ticks_due(0.0) == 1
    for _ in range(9):
        pace.note_ticks(1, 0.001)
    assert pace.ticks_due(0.0) == int(ANSWER / 0.001)
    pace.note_ticks(20, 20.0)
    assert pace.ticks_due(0.0) == 1


def test_a_pace_tries_a_single_tick_when_something_has_changed():
    pace = Pace(math.inf)
    for _ in range(30):
        pace.note_ticks(1, 1e-6)
    assert pace.ticks_due(0.0) > 1000
    pace.reset_cost()
    assert pace.ticks_due(0.0) == 1


def test_the_rate_is_what_was_done():
    pace = Pace(math.inf)
    for k in range(50):
        pace.note_ticks(3, 0.1)
        rate = pace.rate(0.1 * k)
    assert rate == pytest.approx(30.0)


@pytest.mark.parametrize(
    ("symbol", "text"),
    [
        (r"\eta", "η"),
        ("v_0", "v₀"),
        ("p_1", "p₁"),
        (r"k_\alpha", "k\u202fα"),
        ("k_{IU}", "k\u202fIU"),
        ("w^{nei}", "wⁿᵉⁱ"),
        ("v^0", "v⁰"),
        ("r_{rep}", "rᵣₑₚ"),
        ("Q^*", "Q*"),
        ("r", "r"),
    ],
)
def test_symbols_are_readable_without_latex(symbol, text):
    assert plain_symbol(symbol) == text


@pytest.mark.parametrize("model", MODELS.values(), ids=lambda model: model.name)
def test_every_equation_can_be_drawn(model):
    lines = equation_svg(model.rule.equation)
    assert lines
    assert all(line and line.startswith("<svg") for line in lines)
    drawn = " ".join(map(str, lines))
    assert set(re.findall(r"(?:fill|stroke)[:=] ?\"?([^\";]+)", drawn)) == {"currentColor", "none"}
