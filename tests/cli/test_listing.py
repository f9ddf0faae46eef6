"""`flockscope list`: all names on one screen, one thing in full, each as JSON."""

import json
import os
import re

import pytest

from agents.catalogue import MODELS
from agents.models.declare import declared
from agents.observables.catalogue import OBSERVABLES
from app.cli import choices
from app.studies.experiment_reader import experiment_names
from cli.calling import call, refusal
from worlds.layout import layout_names


def test_what_is_declared_after_the_list_was_kept_is_listed(tmp_path, monkeypatch):
    kept = tmp_path / "listed.json"
    kept.write_text('{"models": [{"name": "old"}]}')
    declaring = tmp_path / "agents" / "rules" / "mine.py"
    declaring.parent.mkdir(parents=True)
    declaring.write_text("")
    monkeypatch.setattr(choices, "ROOT", tmp_path)
    monkeypatch.setattr(choices, "LISTED", kept)
    os.utime(declaring, (1e9, 1e9))
    os.utime(kept, (1e9 - 100, 1e9 - 100))  # written together
    assert choices.rows() == {"models": [{"name": "old"}]}
    os.utime(kept, (1e9 - 1000, 1e9 - 1000))
    assert [row["name"] for row in choices.rows()["models"]] == list(MODELS)


def shown(*args):
    result = call("list", *args)
    assert result.exit_code == 0, result.stderr
    assert result.stderr == ""
    return result.stdout


def test_the_overview_is_one_screen_and_names_everything():
    text = shown()
    lines = text.rstrip("\n").split("\n")
    assert 24 <= len(lines) <= 48
    assert max(map(len, lines)) <= 80
    names = re.findall(r"[\w.-]+", text)
    for name in [*MODELS, *layout_names(), *OBSERVABLES, *experiment_names()]:
        if not name.count("-cars") or name in MODELS:
            assert name in names
    assert "`flockscope list hwvem`" in text


@pytest.mark.parametrize("name", ["hwvem", "echelon", "boundary-points"])
def test_a_model_is_shown_with_all_that_its_parameters_declare(name):
    text = " ".join(shown(name).split())
    for one in declared(MODELS[name].parameters):
        assert f"{one.name} " in text
        assert f"in {one.allowed}" in text
        assert " ".join(f"{one.description} ({one.source})".split()) in text
    found = json.loads(shown(name, "--json"))
    assert [row["name"] for row in found["model"]["parameters"]] == list(
        MODELS[name].parameters.model_fields
    )
    assert found["model"]["title"] == MODELS[name].title
    for row in found["model"]["parameters"]:
        assert {"symbol", "unit", "low", "high", "default", "source"} <= row.keys()


@pytest.mark.parametrize("name", ["hwvem", "squashing-best"])
def test_a_model_is_shown_with_what_there_is_to_try(name):
    text = " ".join(shown(name).split())
    listed = json.loads(shown(name, "--json"))["model"]["tries"]
    for one, row in zip(MODELS[name].to_try, listed, strict=True):
        assert one.words in text
        assert one.see in text
        assert row["set"] == one.set
        assert row["proof"]["observable"] == one.proof.observable
        assert row["anew"] == one.anew


def test_a_model_is_shown_with_the_models_it_is_related_to():
    assert json.loads(shown("gregoire-chate", "--json"))["model"]["related"][0] == "vicsek1995"
    assert "see also: vicsek1995, " in shown("gregoire-chate")


def test_one_thing_of_every_kind_is_shown():
    for name, words, kind in (
        ("obstacles", "flockscope world show obstacles", "world"),
        ("liu2021-table2", "flockscope paper liu2021-table2", "paper"),
        ("susceptibility", "--observe susceptibility --over", "observable"),
        ("p2", "of hwvem", "parameter"),
        ("vem-cars", "flockscope run vem-cars", "model"),
    ):
        text = shown(name)
        assert words in text
        assert max(map(len, text.split("\n"))) <= 80
        assert list(json.loads(shown(name, "--json"))) == [kind]


def test_a_name_of_two_kinds_shows_both():
    assert list(json.loads(shown("layers", "--json"))) == ["observable", "parameter"]


def test_an_unknown_name_is_one_line_with_the_nearest():
    assert refusal("list", "hwven") == (
        "flockscope: unknown name 'hwven': did you mean 'hwvem'? (`flockscope list` shows all)"
    )
    assert "did you mean" not in refusal("list", "qqqqqq")


def test_one_agent_is_no_agents():
    line = call("run", "hwvem", "--agents", 1, "--ticks", 1, "--quiet").stdout.split("\n")
    assert line[0].startswith(
        "Hierarchical weighting Vicsek model: 1 agent and 1 information agent"
    )
    assert line[1].startswith("tick 1; 1 tick took")
