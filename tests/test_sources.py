"""Models cite the papers that their declarations name, as BibTeX."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import pytest
from cli.calling import call, refusal

from agents import Flock
from agents.catalogue import MODELS
from agents.models import sources
from agents.models.model import Model


def keys(entries):
    return [re.match(r"@\w+\{(\w+),", entry)[1] for entry in entries]


@pytest.mark.parametrize(
    ("model", "expected"),
    [
        ("vem", ["vicsek1995", "liu2021"]),
        ("wvem", ["liu2021", "liu2021drones"]),
        ("boundary-points", ["wu2023"]),
        ("olfati-saber", ["olfatisaber2006", "wu2023"]),
        ("reynolds", ["reynolds1987", "reynolds1999"]),
        ("echelon", ["couzin2002", "flappingwing"]),
        ("couzin-cars", ["couzin2002", "jacobs"]),
        ("inertial-spin", ["attanasi2014", "cavagna2015"]),
        ("pedestrian", ["helbing1995"]),
        ("vasarhelyi", ["vasarhelyi2018", "soria2020"]),
    ],
)
def test_the_papers_of_a_model(model, expected):
    assert keys(sources.cite(MODELS[model])) == expected


def test_every_built_in_model_has_one_and_every_paper_is_cited():
    cited = [sources.cite(model) for model in MODELS.values()]
    assert all(cited)
    assert {entry for one in cited for entry in one} == {paper.bibtex for paper in sources.PAPERS}


@pytest.mark.parametrize("entry", [paper.bibtex for paper in sources.PAPERS], ids=lambda e: e[:20])
def test_an_entry_is_bibtex(entry):
    kind, body = re.fullmatch(r"@(\w+)\{\w+,\n(.*)\n\}", entry, re.DOTALL).groups()
    assert entry.count("{") == entry.count("}")
    fields = dict(re.findall(r"^  (\w+) *= \{(.*?)\},$", body, re.MULTILINE | re.DOTALL))
    needed = {
        "article": {"author", "title", "journal", "year", "volume", "pages"},
        "inproceedings": {"author", "title", "booktitle", "year"},
        "misc": {"title", "note"},
    }
    assert needed[kind] <= set(fields)
    assert entry.isascii()
    assert sources.entries(entry + "\n\n" + entry) == [entry, entry]


def test_a_rule_brings_its_own():
    vem = MODELS["vem"]
    own = "@misc{mine,\n  title = {Mine},\n}"
    made = Model(replace(vem.rule, name="mine", source="this page", bibtex=own), vem.body)
    assert keys(sources.cite(made)) == ["mine", "liu2021"]


def test_the_command_prints_them():
    made = call("cite", "reynolds")
    assert made.exit_code == 0
    assert made.stdout.rstrip("\n") == "\n\n".join(sources.cite(MODELS["reynolds"]))
    assert made.stdout.rstrip("\n") == Flock("reynolds", agents=2, rng=1).cite()
    as_json = json.loads(call("cite", "reynolds", "--json").stdout)
    assert as_json["model"] == "reynolds"
    assert as_json["bibtex"] == sources.cite(MODELS["reynolds"])


def test_a_model_without_a_paper_says_so_in_a_line(monkeypatch):
    vem = MODELS["vem"]
    rule, body = (replace(one, source="ours") for one in (vem.rule, vem.body))
    monkeypatch.setitem(MODELS, "vem", Model(rule, body))
    made = call("cite", "vem")
    assert (made.exit_code, made.stdout) == (0, "vem names no paper known here; its source: ours\n")
    assert json.loads(call("cite", "vem", "--json").stdout)["bibtex"] == []


def test_an_unknown_model_is_refused():
    assert "did you mean 'hwvem'" in refusal("cite", "hwven")


def test_a_flock_says_what_it_is():
    flock = Flock("hwvem", agents=5, size=(4.0, 5.0), rng=7)
    assert repr(flock) == "<Flock hwvem, N = 6, world wrap, tick 0, seed 7>"
