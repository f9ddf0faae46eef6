"""What sliders span, and in which steps: of every parameter of every model."""

from __future__ import annotations

import html
import itertools
import json
import math
import re

import pytest
import viser

from agents.catalogue import MODELS
from agents.models.declare import Parameters, declared, parameter
from agents.models.slider_range import fits_default, is_wide
from app.front.server import admit_browsers, close_server, open_server
from app.viewer.panels.dials import Dials, decimals, slider_stops, step_of, widen_range
from app.viewer.panels.parameters import add_control

EVERY_MODEL = pytest.mark.parametrize("model", MODELS.values(), ids=lambda model: model.name)


@pytest.fixture(scope="module")
def gui():
    server = open_server(port=0)
    admit_browsers(server)
    yield server.gui
    close_server(server)


def place(one, value: float) -> float:
    """Where a slider has a value, from 0 at its left end to 1, as dials.js draws it."""
    low, high = one.proposed
    if is_wide(low, high):
        return math.log(value / low) / math.log(high / low)
    return (value - low) / (high - low)


def numbers(model) -> list:
    """The parameters of a model that are numbers."""
    return [one for one in declared(model.parameters) if one.kind == "number"]


@EVERY_MODEL
def test_sliders_can_be_put_on_the_default_the_ends_and_round_numbers_between(model):
    for one in numbers(model):
        low, high = one.proposed
        made = slider_stops(low, high, step_of(one), one.default)
        assert (made[0], made[-1]) == (low, high)
        assert one.default in made
        assert made == sorted(set(made))
        assert one.low <= low < high <= one.high
        assert len(made) <= 600
        assert len(made) >= 15 or step_of(one) >= 1.0
        assert all(value in (float(f"{value:.6g}"), one.default) for value in made)


@EVERY_MODEL
def test_no_slider_stands_at_an_end_unless_that_is_where_the_range_ends(model):
    for one in numbers(model):
        if one.default not in (0.0, one.high):
            assert 0.015 < place(one, one.default) < 0.95, one.name


def test_a_scale_of_logarithms_has_as_many_stops_in_every_decade_and_no_gaps():
    made = slider_stops(0.001, 10.0, 0.01, 0.01)
    assert made[:4] == [0.001, 0.0011, 0.0012, 0.0013]
    for low in (0.001, 0.01, 0.1, 1.0):
        assert sum(low <= one < 10.0 * low * (1.0 - 1e-9) for one in made) == 90
    assert max(math.log10(b / a) for a, b in itertools.pairwise(made)) < 0.0415
    assert not is_wide(0.1, 10.0), "two decades are no more than two"
    assert is_wide(0.0999, 10.0)


@pytest.mark.parametrize(
    ("shown", "value", "allowed", "wanted"),
    [
        ((0.5, 20.0), 20.0, (0.1, 100.0), (0.5, 20.0)),
        ((0.5, 20.0), 21.0, (0.1, 100.0), (0.5, 50.0)),
        ((0.5, 20.0), 99.0, (0.1, 99.5), (0.5, 99.5)),
        ((0.5, 20.0), 0.3, (0.1, 100.0), (0.2, 20.0)),
        ((0.5, 20.0), 0.0, (0.0, 100.0), (0.0, 20.0)),
        ((0.001, 10.0), 0.0, (0.0, 100.0), (0.001, 10.0)),
        ((-0.5, 1.0), -3.0, (-4.0, 4.0), (-4.0, 1.0)),
        ((-9.0, -5.0), -1.0, (-9.0, 4.0), (-9.0, 4.0)),
    ],
)
def test_a_slider_grows_to_show_what_is_allowed_and_outside(shown, value, allowed, wanted):
    assert widen_range(shown, value, allowed) == wanted


@EVERY_MODEL
def test_every_number_that_is_allowed_can_be_shown_and_typed(model):
    for one in numbers(model):
        for value in (
            one.low,
            one.high,
            *(t.set[one.name] for t in model.to_try if one.name in t.set),
        ):
            low, high = widen_range(one.proposed, value, (one.low, one.high))
            assert low <= value <= high or (value <= 0.0 and is_wide(low, high))
        for value in (one.low, one.high, one.default):
            assert round(value, decimals(one)) == pytest.approx(value, rel=1e-6)


def told(dials: Dials) -> dict:
    """What the page is told of sliders."""
    return json.loads(html.unescape(re.search(r'data-dials="(.*?)"', dials.place.content)[1]))


def test_the_page_is_told_of_every_slider_and_only_when_something_is_new(gui):
    for model in MODELS.values():
        dials = Dials(gui)
        made = {one.name: add_control(gui, one, one.default) for one in declared(model.parameters)}
        for one in declared(model.parameters):
            dials.add(one, made[one.name])
        dials.refresh()
        sliders = {
            one._impl.uuid for one in made.values() if isinstance(one, viser.GuiSliderHandle)
        }
        assert set(told(dials)) == sliders
        assert dials.marks.content == ""
        assert len(dials.place.content) < 60_000
        text = dials.place.content
        dials.refresh()
        assert dials.place.content is text


def test_a_slider_spans_more_for_a_value_outside_until_its_first_one_is_back(gui):
    dials = Dials(gui)
    one = next(p for p in declared(MODELS["reynolds"].parameters) if p.name == "r_separation")
    control = add_control(gui, one, one.default)
    dials.add(one, control)
    control.value = 70.0
    uuid = control._impl.uuid
    ends = lambda: (told(dials)[uuid]["stops"][0], told(dials)[uuid]["stops"][-1])  # noqa: E731
    dials.refresh()
    assert ends() == (0.1, 100.0)
    assert f'label[for="{uuid}"]' in dials.marks.content
    control.value = 3.0
    dials.refresh()
    assert ends() == (0.1, 100.0), "it does not shrink while it is dragged"
    control.value = one.default
    dials.refresh()
    assert ends() == one.proposed
    assert dials.marks.content == ""


def declare(**range_) -> None:
    class Mine(Parameters):
        x: float = parameter(1.0, "X", symbol="x", source="a test", **range_)

    assert declared(Mine)[0].proposed == range_["proposed"]


def test_what_is_proposed_is_allowed_and_holds_the_default():
    declare(low=0.0, high=9.0, proposed=(0.5, 2.0))
    for wrong in ((2.0, 5.0), (0.0, 0.5), (-1.0, 2.0), (0.5, 10.0), (1.0, 1.0), (0.5, math.inf)):
        with pytest.raises(ValueError, match="proposed = "):
            declare(low=0.0, high=9.0, proposed=wrong)


def test_a_model_of_another_scale_has_a_range_of_its_own():
    assert fits_default((0.0, 2.0), 0.5, 0.7)
    assert fits_default((0.0, 6.0), 0.0, 0.1)
    assert not fits_default((0.5, 20.0), 6.0, 0.6)
    assert not fits_default((0.5, 20.0), 6.0, 25.0)
    own, tenth = (
        {one.name: one.proposed for one in declared(MODELS[name].parameters)}
        for name in ("vasarhelyi", "vasarhelyi-tenth")
    )
    assert own["a_max"] == (0.5, 20.0)
    assert tenth["a_max"] == (0.05, 5.0)
