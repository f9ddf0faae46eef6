"""What an author got wrong in a rule is one line: whose function, which line, and the reason."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from pathlib import Path

import pytest

from agents import Flock
from agents.bodies import constant_speed
from agents.catalogue import MODELS, Model
from agents.models.model_calls import ModelCodeError
from worlds.compilation import compiled

PAGE = Path(__file__).parents[1] / "docs" / "new-rule.md"
SUM = "total += h"
ANSWER = "return Decision(x / total, y / total, z / total)"
FAULTS = [
    ("p.fade)", "p.fad)", "no parameter 'fad', did you mean 'fade'?"),
    ("near.ux[j]", "near.uxx[j]", "near has no 'uxx', did you mean 'ux'?"),
    (SUM, "total += hh", "no name 'hh'"),
    ("math.exp(", "math.expo(", "module 'math' has no attribute 'expo'"),
    (ANSWER, "return x, y, z", "it returns UniTuple(float64 x 3), but a Decision is needed"),
    (ANSWER, "return Decision(x, y)", "'z'"),
    (SUM, "total += h; seen = [h]; total += seen[0]", "cannot make a list, an array"),
    (SUM, "total += h; breakpoint()", "'breakpoint' works in plain Python only"),
    (SUM, "total += own(h)", "'own' is not @compiled"),
]
"""What stands on the page, what stands there instead, and what is said of it."""


def written(folder: Path, right: str, wrong: str) -> tuple[Path, int]:
    """The rule of the page in a file, with something wrong in it, and the line of that."""
    code = re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[1]
    made = code.replace(right, wrong, 1)
    assert made != code
    made = made.replace("class Fading", "def own(x):\n    return x\n\n\nclass Fading", 1)
    path = folder / "fading.py"
    path.write_text(made)
    lines = made.splitlines()
    return path, next(n for n, line in enumerate(lines, 1) if wrong in line)


@pytest.fixture
def wrong_rule(tmp_path, monkeypatch):
    """Makes the rule of the page with something wrong in it a model; returns the line of it."""

    def made(right: str, wrong: str) -> int:
        path, line = written(tmp_path, right, wrong)
        space: dict = {"__name__": "fading"}
        exec(compile(path.read_text(), str(path), "exec"), space)
        monkeypatch.setitem(MODELS, "fading", Model(space["RULE"], constant_speed.BODY))
        return line

    return made


@pytest.mark.parametrize(("right", "wrong", "reason"), FAULTS)
def test_a_fault_is_one_line_with_rule_function_and_line(wrong_rule, right, wrong, reason):
    line = wrong_rule(right, wrong)
    flock = Flock("fading", agents=4, size=3.0, rng=1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ModelCodeError) as caught:
            flock.run(1)
    text = str(caught.value)
    assert text.startswith(f"rule 'fading', decide, line {line}: ")
    assert text.endswith(" (fading.py)")
    assert reason in text
    assert "\n" not in text
    assert len(text) < 300


def test_a_fault_in_plain_python_is_told_alike_and_keeps_its_traceback(wrong_rule):
    line = wrong_rule("p.fade)", "p.fad)")
    flock = Flock("fading", agents=4, size=3.0, rng=1, interpret=True)
    with pytest.raises(ModelCodeError) as caught:
        flock.run(1)
    said = "no parameter 'fad', did you mean 'fade'? (fading.py)"
    assert str(caught.value) == f"rule 'fading', decide, line {line}: {said}"
    assert isinstance(caught.value.__cause__, AttributeError)


def test_a_fault_in_what_only_an_inspection_calls_is_told_too(wrong_rule, monkeypatch):
    wrong_rule("p.fade)", "p.fade + 0.0)")
    right = MODELS["fading"].rule

    @compiled
    def weigh(me, near, p, out):  # noqa: ARG001
        out[0] = p.fad

    monkeypatch.setitem(MODELS, "fading", Model(replace(right, weigh=weigh), constant_speed.BODY))
    flock = Flock("fading", agents=9, size=1.0, rng=1, interpret=True)
    with pytest.raises(
        ModelCodeError, match=r"rule 'fading', weigh, line \d+: no parameter 'fad', did you"
    ):
        flock.inspect(0)


def test_a_function_that_is_not_compiled_is_refused_where_it_is_declared():
    with pytest.raises(TypeError, match="rule 'plain': decide is not @compiled"):
        replace(MODELS["vem"].rule, name="plain", decide=max)
