"""What a page cannot do is refused before anything is compiled for it."""

from __future__ import annotations

import dataclasses
import re

import pytest
from pydantic import model_validator

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.models.declare import Zone
from agents.models.model import Model
from agents.web.web_program import growth, of_slider, sliders, web_program
from tests.worlds.test_web_assembly import Running
from worlds.input_error import InputError
from worlds.web_assembly import MemoryImage, web_module

COUZIN = MODELS["couzin"]


class CheckedParameters(COUZIN.rule.parameters):
    """Parameters that look at each other."""

    @model_validator(mode="after")
    def _fit(self):
        return self


def longest(p, times=2.0):
    """The reach of some parameters, by a plain function that calls another."""
    return times * outermost(p) + getattr(p, "length_of_nobody", 0.25)


def outermost(p):
    """The outer radius of the last zone."""
    return p.r_r + p.dr_o + p.dr_a


class HelpedParameters(COUZIN.rule.parameters):
    """Parameters whose reach is computed by functions of its own."""

    @property
    def range(self) -> float:
        """How far agents notice each other."""
        return longest(self)


class TextParameters(COUZIN.rule.parameters):
    """Parameters whose reach is nothing that numba compiles."""

    @property
    def range(self) -> float:
        """How far agents notice each other."""
        return float(re.sub("x", "", f"x{self.r_r}")) + 20.0


def flock_of(monkeypatch, **changes) -> Flock:
    """A flock of Couzin's rule with something declared otherwise."""
    rule = dataclasses.replace(COUZIN.rule, name="changed", **changes)
    monkeypatch.setitem(MODELS, "changed", Model(rule, COUZIN.body))
    return Flock("changed", agents=5, rng=1)


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"parameters": CheckedParameters}, "has checks of its own"),
        (
            {"zones": (Zone("repulsion", lambda p: p.r_r * p.dr_o),)},
            "the zone of repulsion .* is no sum of parameters",
        ),
    ],
)
def test_what_a_page_could_not_keep_to_is_refused(monkeypatch, changes, why):
    flock = flock_of(monkeypatch, **changes)
    with pytest.raises(InputError, match=why) as caught:
        web_program(flock)
    assert "\n" not in str(caught.value)


def test_how_many_are_neighbours_has_a_slider_only_where_it_counts():
    assert "k" not in [one.name for one in sliders(Flock("vem", agents=5, rng=1))]
    nearest = Flock("vem", agents=5, rng=1, neighbours="nearest")
    assert "k" in [one.name for one in sliders(nearest)]


def test_a_reach_may_call_plain_functions(monkeypatch):
    flock = flock_of(monkeypatch, parameters=HelpedParameters)
    image = MemoryImage()
    image.add("parameters", flock.context.parameters)
    image.finish()
    module = web_module(
        {"range": of_slider(flock, HelpedParameters.range.fget, "range").code("range")}
    )
    running = Running(module.content, image)
    running.call("range", image)
    assert running.read(image.answer, "<d")[0] == pytest.approx(flock.reach, rel=1e-15)


def test_a_reach_that_cannot_be_compiled_is_refused_in_a_line(monkeypatch):
    flock = flock_of(monkeypatch, parameters=TextParameters)
    with pytest.raises(InputError, match="a page cannot compute 'range'") as caught:
        of_slider(flock, TextParameters.range.fget, "range").code("range")
    assert "\n" not in str(caught.value)


@pytest.mark.long
def test_what_no_browser_computes_alike_is_refused_in_a_line(monkeypatch):
    monkeypatch.setattr("agents.web.web_program.KNOWN", {"fmod"})
    with pytest.raises(InputError, match="model 'vem' calls sched_yield: a browser") as caught:
        web_program(Flock("vem", agents=5, rng=1))
    assert "\n" not in str(caught.value)


def test_a_flock_whose_agents_are_where_none_can_begin_grows_all_the_same():
    flock = Flock("vem", agents=5, rng=1, world="obstacles")
    solid = flock.world.obstacles[0].footprint().representative_point()
    flock.position[:] = solid.x, solid.y
    assert growth(flock)["flock.position"] == [[1, 0], [0, 2]]
