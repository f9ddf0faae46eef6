"""A rule in a file of one's own: wherever a model's name may stand, without a package."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pytest

from agents import Flock, catalogue
from agents.catalogue import MODELS, from_file
from agents.spec import Spec
from app.processes import ChildProcess
from app.viewer.lab.flock_page import PageWriter
from app.viewer.run.paired_run import companion
from cli.calling import call, refusal
from worlds.input_error import InputError

PAGE = Path(__file__).parents[2] / "docs" / "new-rule.md"
CODE = re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[1]  # type: ignore[index]
SMALL = ("--agents", "6", "--ticks", "2", "--seed", "1", "--interpret", "--quiet", "--json")


@pytest.fixture(autouse=True)
def _no_trace(monkeypatch):
    """The catalogue as it was, afterwards."""
    monkeypatch.setattr(catalogue, "FILES", {})
    before, modules = dict(MODELS), set(sys.modules)
    yield
    MODELS.clear()
    MODELS.update(before)
    for name in set(sys.modules) - modules:
        if name.startswith("rule_file_"):
            del sys.modules[name]


@pytest.fixture
def mine(tmp_path):
    """The rule of the page in a file."""
    (tmp_path / "mine.py").write_text(CODE)
    return tmp_path / "mine.py"


def test_a_file_stands_where_a_model_stands_and_an_option_brings_it_too(mine):
    made = [
        json.loads(call("run", *arguments, *SMALL).stdout)
        for arguments in ((mine,), ("--rule", mine), ("fading", "--rule", mine))
    ]
    assert made[0]["spec"]["model"] == "fading"
    for one in made:
        one.pop("seconds", None)
        one.pop("speed", None)
    assert made[0]["observables"] == made[1]["observables"] == made[2]["observables"]


def test_it_is_listed_and_checked_like_a_built_in(mine):
    assert "fade" in call("list", mine).stdout
    named = json.loads(call("list", "fading", "--rule", mine, "--json").stdout)
    assert named["model"]["title"] == "Fading Vicsek model"
    line = refusal("run", mine, "--set", "fade=9", *SMALL)
    assert "fade = 9 length is outside [0.05, 5] length (--set fade)" in line


def test_what_a_run_keeps_goes_on_with_the_rule_named_again(mine, tmp_path):
    state = tmp_path / "state.parquet"
    assert call("run", mine, *SMALL, "--save", state).exit_code == 0
    again = call("run", "--rule", mine, "--state", state, "--ticks", 1, "--interpret", "--json")
    assert json.loads(again.stdout)["spec"]["model"] == "fading"


def test_its_setup_offers_it_in_the_laboratory(mine):
    from app.viewer.lab.panels.setup import MODELS as OFFERED
    from app.viewer.run.run_preset import preset_spec

    name = from_file(str(mine)).name
    assert OFFERED[name].title == "Fading Vicsek model"
    assert Flock(preset_spec(name, agents=5)).model.name == "fading"


def test_a_typing_error_is_one_line(mine):
    mine.write_text(CODE.replace("p.fade)", "p.fadde)"))
    line = next(n for n, one in enumerate(mine.read_text().splitlines(), 1) if "p.fadde" in one)
    said = (
        f"rule 'fading', decide, line {line}: no parameter 'fadde', did you mean 'fade'? (mine.py)"
    )
    assert refusal("run", mine, *SMALL) == f"flockscope: {said}"
    compiled = [one for one in SMALL if one != "--interpret"]
    assert refusal("run", mine, *compiled) == f"flockscope: {said}"


def in_line(text: str) -> int:
    """The line of the page's rule that has a text."""
    return next(n for n, one in enumerate(CODE.splitlines(), 1) if text in one)


@pytest.mark.parametrize(
    ("code", "said"),
    [
        (CODE.replace("for j in", "for j im"), f"mine.py, line {in_line('for j in')}: invalid"),
        (CODE.replace("RULE =", "NAME ="), "mine.py has neither a RULE nor a MODEL"),
        ("RULE = 3", "a Rule or a Model is needed, not int"),
        ("import math\nmath.no", "mine.py, line 2: AttributeError: module 'math'"),
        ("raise SystemExit(3)", "mine.py, line 1: SystemExit: 3"),
        (CODE.replace('name="fading"', 'name="vem"'), "there is a model 'vem' already"),
        (CODE.replace("@compiled\n", ""), "rule 'fading': decide is not @compiled"),
        (CODE.replace("decide=decide,", ""), "missing 1 required positional argument: 'decide'"),
        (CODE.replace("decide=decide,", "decide=decide, wish='velocity',"), "takes heading"),
        ("\0", "source code"),
    ],
)
def test_what_is_wrong_with_a_file_is_one_line(mine, code, said):
    mine.write_text(code)
    assert said in refusal("run", mine, *SMALL)
    assert "mine.py" in refusal("run", "--rule", mine, *SMALL)


def test_a_file_that_is_not_there_is_one_line(tmp_path):
    assert "nothing.py' cannot be read: No such file" in refusal("list", tmp_path / "nothing.py")


def test_an_edited_file_replaces_its_rule_and_the_same_one_stays(mine):
    first = from_file(mine)
    assert from_file(mine) is first
    assert not catalogue.is_built_in(first.name), "its runs are made in processes"
    mine.write_text(CODE.replace("0.5,", "0.7,"))
    assert Flock("fading", agents=2, rng=1).parameters.fade == 0.5
    assert from_file(mine) is not first
    assert Flock("fading", agents=2, rng=1).parameters.fade == 0.7


def test_a_name_in_a_spec_or_from_a_browser_is_never_run_as_a_file(mine):
    with pytest.raises(InputError, match="unknown model"):
        Flock(str(mine))


def test_the_page_of_its_flock_is_written_in_a_process_of_its_own(mine):
    """As the laboratory does, which tells that process the files that it knows."""
    spec = Flock(from_file(str(mine)).name, agents=6, rng=1).spec.to_toml()
    with ChildProcess(PageWriter, [str(mine)]) as child:
        page = child.ask("write", spec, timeout=300.0).result()
    assert "Fading Vicsek model" in page


def test_a_page_of_two_flocks_goes_on_from_where_they_are(mine):
    first = Flock("vem", agents=6, rng=1)
    second = companion(first, Spec(from_file(str(mine)).name))
    for flock in (first, second):
        flock.run(7)
    with ChildProcess(PageWriter, [str(mine)]) as child:
        page = child.ask("write_pair", first, second, timeout=300.0).result()
    assert page.count("&quot;tick&quot;:7,") == 2
    assert f"{first.model.rule.title} beside Fading Vicsek model" in page
