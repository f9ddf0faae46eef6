"""The glossary explains words that are in use, and no name is one of those they stand for."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.cli.main import COMMANDS, load

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
    "patience",
    "ration",
    "refuge",
    "said",
    "shadow",
    "told",
}
"""Words that say what a standard term says: workspace, context, crash record, surroundings, ..."""
EVERYWHERE = PRIVATE - {"calm", "ground", "said", "shadow", "told"}
"""Those that no package uses; `app` still has the others."""
ON_NO_PAGE = {"aloft", "errand", "patience", "refuge", "refusal", "refusals"}
"""Those that neither pages nor help texts use."""
PACKAGES = ("agents", "app", "flockscope", "worlds")


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


@pytest.mark.parametrize(
    ("folder", "private"),
    [("agents", PRIVATE), ("worlds", PRIVATE), ("app", EVERYWHERE), ("flockscope", EVERYWHERE)],
)
def test_no_name_is_a_private_word(folder, private):
    found = {
        str(file.relative_to(ROOT)): words
        for file in sorted((ROOT / folder).rglob("*.py"))
        if (words := words_of(file.read_text(encoding="utf-8")) & private)
    }
    assert not found


def sources() -> list[Path]:
    """The files of all packages."""
    return [file for folder in PACKAGES for file in sorted((ROOT / folder).rglob("*.py"))]


def test_each_class_has_a_name_of_its_own():
    """`flockscope.Flock` is `agents.Flock` with a window."""
    names = Counter(
        node.name
        for file in sources()
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef)
    )
    assert {name for name, count in names.items() if count > 1} == {"Flock"}


def test_files_share_few_names():
    """Commands of a group, and kinds of experiments beside what they are about, may do so."""
    names = Counter(file.name for file in sources() if file.name != "__init__.py")
    assert sum(count > 1 for count in names.values()) <= 25


PAGES = ["README.md", "CONTRIBUTING.md", "SECURITY.md"]
PAGES += [f"docs/{page.name}" for page in sorted((ROOT / "docs").glob("*.md"))]


@pytest.mark.parametrize("page", PAGES)
def test_no_page_uses_a_private_word(page):
    text = (ROOT / page).read_text(encoding="utf-8").lower()
    assert not set(re.findall(r"[a-z]+", text)) & ON_NO_PAGE


def test_no_help_text_uses_a_private_word():
    assert len(helps := list(help_texts())) > 200
    assert not [text for text in helps if set(re.findall(r"[a-z]+", text.lower())) & ON_NO_PAGE]


def help_texts() -> Iterator[str]:
    """What `--help` says of every command and every option."""
    for name in COMMANDS:
        command = load(name)
        for one in getattr(command, "commands", {"": command}).values():
            yield one.help or ""
            yield from (getattr(option, "help", None) or "" for option in one.params)
