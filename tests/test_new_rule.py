"""The rule in docs/new-rule.md works as printed, in every way that a rule can be used."""

from __future__ import annotations

import importlib
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cli.calling import call, refusal

from agents import Flock, catalogue
from agents.bodies import constant_speed
from agents.catalogue import MODELS, Model
from agents.conformance import outcome
from agents.kinds import Kind
from worlds.input_error import InputError

PAGE = Path(__file__).parents[1] / "docs" / "new-rule.md"
ANOTHER = "## Kinds that a rule knows"
"""The heading below which the page has another rule."""


@pytest.fixture
def fading(tmp_path, monkeypatch):
    code = re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL).group(1)
    (tmp_path / "fading.py").write_text(code)
    monkeypatch.syspath_prepend(str(tmp_path))
    import fading

    monkeypatch.setitem(MODELS, "fading", Model(fading.RULE, constant_speed.BODY))
    yield "fading"
    del sys.modules["fading"]


def test_it_aligns_and_refuses_what_is_out_of_range(fading):
    flock = Flock(fading, agents=100, size=5.0, rng=1, fade=0.3)
    before = flock.observe("polarisation")
    flock.run(200)
    assert flock.observe("polarisation") > max(0.9, before)
    with pytest.raises(InputError, match=r"fade = 9 length is outside \[0.05, 5\]"):
        Flock(fading, fade=9)


def test_it_does_what_it_says_for_two_agents(fading):
    start = {"position": [[1.0, 1.0], [1.4, 1.0]], "heading": [[1.0, 0.0], [0.0, 1.0]]}
    flock = Flock(fading, start=start, size=9.0, rng=1, fade=0.8)
    flock.agents.do("step")
    h = np.exp(-0.4 / 0.8)
    expected = np.array([[1.0, h], [h, 1.0]]) / np.hypot(1.0, h)
    assert np.allclose(flock.heading, expected, atol=1e-12)


def test_what_the_page_proposes_to_try_with_it_comes_true(fading, monkeypatch):
    code = re.search(
        r"```python\n(from flockscope.rules import LessonCheck.*?)```",
        PAGE.read_text("utf-8"),
        re.DOTALL,
    )
    found: dict = {}
    exec(code.group(1), found)
    model = replace(MODELS[fading], tries=found["TRIES"])
    monkeypatch.setitem(MODELS, "fading", model)
    assert outcome(model, "tries").result == "holds", outcome(model, "tries").reason


def test_it_flies_in_three_dimensions(fading):
    flock = Flock(fading, agents=100, dim=3, size=3.0, rng=1)
    flock.run(100)
    assert flock.observe("polarisation") > 0.9


def test_a_rule_may_have_no_noise_at_all(monkeypatch):
    from agents.engine.template import decide
    from agents.models.declare import Parameters, Rule, parameter

    class Bare(Parameters):
        sight: float = parameter(1.0, "How far", symbol="s", source="none", low=0.1, high=2.0)

    rule = Rule("bare", "Bare", "Keeps its heading.", "x", "none", Bare, decide, reach="sight")
    monkeypatch.setitem(MODELS, "bare", Model(rule, constant_speed.BODY))
    flock = Flock("bare", agents=5, size=3.0, rng=1)
    before = flock.heading.copy()
    flock.run(3)
    assert np.array_equal(flock.heading, before)
    assert flock.reach == 1.0


def test_the_fault_that_the_page_prints_is_what_a_typing_error_gives(tmp_path, monkeypatch):
    monkeypatch.setattr(catalogue, "FILES", {})
    monkeypatch.setattr(catalogue, "MODELS", dict(MODELS))
    page = PAGE.read_text(encoding="utf-8")
    code = re.search(r"```python\n(.*?)```", page, re.DOTALL).group(1)
    (tmp_path / "fading.py").write_text(code.replace("p.fade)", "p.fadde)"))
    printed = re.search(r"^flockscope: .*$", page, re.MULTILINE).group(0)
    said = refusal("run", tmp_path / "fading.py", "--interpret", "--agents", 5, "--quiet")
    assert said == printed


def test_the_short_form_on_the_page_is_the_same_rule(tmp_path, monkeypatch):
    page = PAGE.read_text(encoding="utf-8").partition(ANOTHER)[0]
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    path = tmp_path / "both.py"
    path.write_text("\n".join(blocks))
    names: dict = {"__name__": "both"}
    exec(compile(path.read_text(), str(path), "exec"), names)
    flocks = []
    for rule in (names["RULE"], names["SHORT"]):
        monkeypatch.setitem(MODELS, rule.name, Model(rule, constant_speed.BODY))
        flocks.append(Flock(rule.name, agents=9, size=2.0, rng=1, interpret=True))
        flocks[-1].run(3)
    assert np.allclose(flocks[0].heading, flocks[1].heading, atol=1e-12)
    weights = flocks[1].inspect(0).weights
    assert ((weights > 0.0) & (weights < 1.0)).all()


def test_the_three_ways_to_write_it_do_the_same(tmp_path, monkeypatch):
    """Written out, as a weight, and as the term of a pair."""
    page = PAGE.read_text(encoding="utf-8").partition(ANOTHER)[0]
    code = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    (tmp_path / "ways.py").write_text("\n".join(code))
    monkeypatch.syspath_prepend(str(tmp_path))
    ways = importlib.import_module("ways")
    flocks = []
    for rule in ("RULE", "SHORT", "FAST"):
        monkeypatch.setitem(MODELS, rule, Model(getattr(ways, rule), constant_speed.BODY))
        flocks.append(Flock(rule, agents=150, size=6.0, rng=1, eta=0.3, fade=0.4))
        flocks[-1].run(10)
    assert [flock.of_pairs for flock in flocks] == [False, False, True]
    for flock in flocks[1:]:
        assert np.allclose(flock.heading, flocks[0].heading, atol=1e-9)


def test_the_herd_of_the_page_runs_and_flees_from_its_wolf(tmp_path):
    page = PAGE.read_text(encoding="utf-8").partition(ANOTHER)[2]
    path = tmp_path / "herd.py"
    path.write_text(re.search(r"```python\n(.*?)```", page, re.DOTALL).group(1))
    try:
        done = call("run", path, "--agents", 20, "--kind", "wolf=2", "--ticks", 20)
        assert "2 of kind wolf" in done.stdout, done.stderr
        assert "its rule knows: wolf" in call("list", "kinds", "--rule", path).stdout
        assert "(--kind NAME=NUMBER): wolf" in call("list", path).stdout
        start = {"position": [[1.0, 1.0], [1.5, 1.0]], "heading": [[0.0, 1.0], [0.0, 1.0]]}
        flock = Flock("herd", start=start, size=9.0, rng=1, eta=0.0, kinds=[Kind("wolf", 1)])
        flock.run(1)
        assert np.allclose(flock.heading, np.array([[-2.0, 1.0], [-2.0, 1.0]]) / np.sqrt(5.0))
    finally:
        MODELS.pop("herd", None)
