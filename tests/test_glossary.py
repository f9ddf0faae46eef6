"""The glossary explains words that are in use, and no name is one of those they stand for."""

from __future__ import annotations

import io
import re
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8")
ENTRIES = re.findall(r"^- \*\*(.+?)\*\*: (.+?)\]\((.+?)\):?\.?$", PAGE, re.MULTILINE | re.DOTALL)
PRIVATE = {
    "aloft",
    "calm",
    "desk",
    "errand",
    "fallen",
    "fate",
    "ground",
    "law",
    "ration",
    "refuge",
    "said",
    "shadow",
    "told",
}
"""Words that say what a standard term says: workspace, context, crash record, surroundings, ..."""


def test_every_line_is_an_entry_with_a_link():
    assert len(ENTRIES) == len(re.findall(r"^- ", PAGE, re.MULTILINE)) > 30
    assert len({term for term, _, _ in ENTRIES}) == len(ENTRIES)


@pytest.mark.parametrize(("term", "link"), [(term, link) for term, _, link in ENTRIES])
def test_a_term_is_used_where_the_glossary_says(term, link):
    where = (ROOT / "docs" / link.partition("#")[0]).resolve()
    used = " ".join(re.sub(r"[\"#*]", "", where.read_text(encoding="utf-8")).split())
    assert re.search(rf"\b{term}", used.replace("_", " "), re.IGNORECASE), f"{term} in {link}"


def words_of(source: str) -> set[str]:
    """The words of all identifiers of a source, lower case: `nothing_told` is nothing and told."""
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    names = {token.string for token in tokens if token.type == tokenize.NAME}
    return {word.lower() for name in names for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+", name)}


def test_words_are_found_inside_of_names():
    assert words_of("def nothing_told(aDesk): return LAW\n") >= {"told", "desk", "law"}


@pytest.mark.parametrize("folder", ["agents", "worlds"])
def test_no_name_is_a_private_word(folder):
    found = {
        str(file.relative_to(ROOT)): words
        for file in sorted((ROOT / folder).rglob("*.py"))
        if (words := words_of(file.read_text(encoding="utf-8")) & PRIVATE)
    }
    assert not found
