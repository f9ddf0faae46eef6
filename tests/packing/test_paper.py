"""The article about flockscope cites what its bibliography has, as the models cite it."""

from __future__ import annotations

import re
from pathlib import Path

from agents.models.sources import PAPERS

FOLDER = Path(__file__).parents[2] / "paper"


def test_what_is_cited_is_in_the_bibliography_as_models_cite_it():
    text = (FOLDER / "paper.md").read_text(encoding="utf-8")
    bibliography = (FOLDER / "paper.bib").read_text(encoding="utf-8")
    keys = re.findall(r"^@\w+\{(\w+),", bibliography, flags=re.MULTILINE)
    assert sorted(keys) == sorted(set(re.findall(r"@(\w+)", text)))
    own = {re.split("[{,]", paper.bibtex)[1]: paper.bibtex.strip() for paper in PAPERS}
    for key in set(keys) & set(own):
        assert own[key] in bibliography
    assert len(set(keys) & set(own)) >= 4


def test_files_that_it_names_are_there():
    text = (FOLDER / "paper.md").read_text(encoding="utf-8")
    named = re.findall(r"`([\w/]+\.py)`", text)
    assert named
    assert [name for name in named if not (FOLDER.parent / name).exists()] == []
