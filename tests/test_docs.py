"""The pages say what is declared; that what they print works is tested in tests/pages."""

from __future__ import annotations

import functools
import importlib
import json
import re
import runpy
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from cli.calling import call
from pages.blocks import blocks_of, inline_commands
from PIL import Image

from agents.catalogue import collect
from agents.catalogue import model as by_name
from app.cli.main import COMMANDS
from app.studies.experiment_reader import experiment_names, read_experiment
from app.viewer.gallery.lessons.lessons import lesson_names
from worlds.layout import layout_names

ROOT = Path(__file__).parents[1]
sys.path.append(str(ROOT / "docs"))
lesson_pages = importlib.import_module("lesson_pages")
make_papers = importlib.import_module("make_papers")
MAKE = runpy.run_path(str(ROOT / "docs" / "make.py"))
MODELS = collect()
"""As they are declared: what other tests asked for by NAME-cars is not among them."""
PAGES = {f"{name}.md" for name in MODELS} | {"README.md"}
pages = functools.cache(MAKE["pages"])
paper_pages = functools.cache(make_papers.pages)
GROUPS = ("world", "flight", "formation", "live", "sweep", "new", "tracks")
"""Commands that have commands of their own."""
WRITTEN = [
    "README.md",
    *(f"docs/{page.name}" for page in sorted((ROOT / "docs").glob("*.md"))),
    *(f"docs/papers/{page.name}" for page in sorted((ROOT / "docs" / "papers").glob("*.md"))),
]


def text(name):
    return (ROOT / name).read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "page", sorted((ROOT / "docs").rglob("*.md.in")), ids=lambda page: page.stem
)
def test_a_page_of_the_papers_is_its_template_and_the_stored_results(page):
    made = paper_pages()[page.with_suffix("")]
    written = page.with_suffix("").read_text(encoding="utf-8")
    assert written == made, "run `uv run python docs/make_papers.py`"
    assert "{" not in re.sub(r"`[^`]*`|\$\$[^$]*\$\$", "", made), "a name that stands for no result"


def test_every_page_of_a_paper_has_a_template():
    papers = set((ROOT / "docs" / "papers").glob("*.md"))
    assert papers == {page for page in paper_pages() if page.parent.name == "papers"}


def test_the_results_of_every_experiment_stand_on_one_page():
    shown = [
        name
        for template in make_papers.paper_templates()
        for name in make_papers.experiments_of(template)
    ]
    assert sorted(shown) == sorted(experiment_names())


def test_the_index_of_the_papers_counts_every_verdict():
    (total,) = re.findall(r"^\| \*\*all\*\* \|(.*)\|$", text("docs/papers.md"), re.MULTILINE)
    stored = [json.loads(text(f"docs/papers/{name}.json")) for name in experiment_names()]
    verdicts = [row for result in stored for row in result["rows"] + result["claims"]]
    assert sum(map(int, re.findall(r"\d+", total))) == sum(
        bool(row.get("verdict")) for row in verdicts
    )


@pytest.mark.parametrize("name", experiment_names())
def test_the_stored_results_are_of_today_s_experiments(name):
    """Of as many runs as the experiment asks for, with the claims that it makes."""
    kept = json.loads(text(f"docs/papers/{name}.json"))
    whole = read_experiment(name)
    assert max(row["runs"] + row["absent"] for row in kept["rows"]) == whole.runs
    assert len(kept["rows"]) == len(whole.cases) * len(whole.measures)
    assert bool(kept["claims"]) == any(
        [whole.said, *(case.sweep and case.sweep.trend for case in whole.cases)]
    )


@pytest.mark.parametrize("name", sorted(PAGES))
def test_page_is_the_declaration(name):
    assert text(f"docs/rules/{name}") == pages()[name], "run `uv run python docs/make.py`"


def test_what_is_listed_is_what_is_declared():
    """Made anew in a process of its own: other tests add models to the catalogue of this one."""
    code = f"import runpy, sys; sys.path.append({str(ROOT / 'docs')!r}); " + (
        f"sys.stdout.write(runpy.run_path({str(ROOT / 'docs' / 'make.py')!r})['kept_list']())"
    )
    made = subprocess.run(
        [sys.executable, "-X", "utf8", "-c", code],
        capture_output=True, encoding="utf-8", check=True, cwd=ROOT,
    )  # fmt: skip
    assert text("app/cli/listed.json") == made.stdout, "run `uv run python docs/make.py`"


@pytest.mark.parametrize("name", lesson_pages.STORIES)
def test_the_page_of_a_story_is_its_lesson(name):
    made = lesson_pages.page_of(name)
    assert text(f"docs/lessons/{name}.md") == made, (
        "run `uv run python docs/make_lessons.py --pages`"
    )


def test_every_lesson_has_a_page_that_links_to_what_is_there():
    found = {page.stem for page in (ROOT / "docs" / "lessons").glob("*.md")}
    assert found == set(lesson_names())
    for name in found:
        for link in re.findall(r"\]\((?!https?:)([^)#\s]+)", text(f"docs/lessons/{name}.md")):
            assert (ROOT / "docs" / "lessons" / link).exists(), link


@pytest.mark.parametrize("name", sorted(n for n in PAGES if n != "README.md"))
def test_page_has_its_picture(name):
    png = (ROOT / "docs" / "rules" / name).with_suffix(".png")
    assert png.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_every_model_is_listed_once_and_has_a_page():
    links = re.findall(r"^- \[.*?\]\((.*?)\.md\)", pages()["README.md"], re.MULTILINE)
    assert sorted(links) == sorted(MODELS)
    assert set(pages()) == PAGES


@pytest.mark.parametrize("name", sorted(n for n in PAGES if n != "README.md"))
def test_a_page_says_what_its_model_was_checked_against(name):
    assert re.search(
        r"^\| Checked against \| .*`flockscope paper ", text(f"docs/rules/{name}"), re.M
    )


def test_a_page_names_every_force_and_everything_remembered():
    for name, model in MODELS.items():
        for word in (*model.rule.forces, *model.body.forces, *model.rule.memory):
            assert word.replace("_", " ") in pages()[f"{name}.md"]


def is_model(page, model):
    """Whether there is such a model; a file must be one that the page has made."""
    if model.endswith(".parquet"):
        return f"--record {model}" in (ROOT / page).read_text(encoding="utf-8")
    if model.endswith(".py"):
        written = (ROOT / page).read_text(encoding="utf-8")
        return f"Saved as `{model}`" in written or f"new rule {model}" in written
    return by_name(model)


@pytest.mark.parametrize("page", [*WRITTEN, *(f"docs/rules/{name}" for name in sorted(PAGES))])
def test_what_a_page_links_to_is_there(page):
    for link in re.findall(r"\]\((?!https?:)([^)\s]+)\)", text(page)):
        file, _, mark = link.partition("#")
        target = (ROOT / page).parent / file if file else ROOT / page
        assert target.exists(), link
        if mark:
            headings = re.findall(r"^#+ (.*)$", target.read_text(encoding="utf-8"), re.MULTILINE)
            made = {re.sub(r"[^\w\- ]", "", h.lower()).strip().replace(" ", "-") for h in headings}
            assert mark in made, link


def commands(page):
    """The words of every command that a page shows."""
    for block in blocks_of(page):
        for line in block.lines if block.is_shell else ():
            words = shlex.split(line.split("&&")[-1].replace("uv run --no-dev ", ""))
            if words[0] == "flockscope":
                yield words[1:]


def test_readme_is_short_and_counts_the_models():
    assert len(text("README.md").split()) <= 600
    assert f"| {len(MODELS)} models |" in text("README.md")


def test_a_page_runs_every_command_that_readme_has_in_its_table():
    """Commands in a sentence are only parsed; those in a block of a page are run."""
    run = [words for page in WRITTEN for words in commands(page)]
    named = [shlex.split(line)[1:] for line in inline_commands("README.md")]
    assert len(named) >= 5
    assert [words for words in named if words not in run] == []


def test_the_film_of_readme_plays_for_ever_and_is_small():
    film = ROOT / "docs" / "flock.webp"
    assert "(docs/flock.webp)" in text("README.md")
    assert film.stat().st_size < 3e6
    with Image.open(film) as opened:
        assert opened.n_frames >= 60
        assert opened.info["loop"] == 0


def test_the_python_of_readme_is_eight_lines_and_saves_the_picture_below_it():
    page = text("README.md")
    (code,) = re.findall(r"```python\n(.*?)```\n\n!\[[^\]]+\]\(docs/flock\.png\)", page, re.S)
    assert len(code.splitlines()) <= 8
    assert 'save("flock.png")' in code
    with Image.open(ROOT / "docs" / "flock.png") as picture:
        assert f"size={picture.size}" in code


def after(words, option):
    """The word after an option or a command, if there is one that is no option."""
    rest = words[words.index(option) + 1 :] if option in words else []
    return rest[0] if rest and not rest[0].startswith("-") else None


def test_commands_are_found_wherever_they_stand():
    found = [words[0] for page in WRITTEN for words in commands(page) if words]
    assert set(found) >= {"lab", "run", "paper", "world", "list"}
    assert ["lab", "hwvem-nav"] in list(commands("docs/first-examples.md"))


@pytest.mark.parametrize("page", [*WRITTEN, *(f"docs/rules/{name}" for name in sorted(PAGES))])
def test_the_commands_of_a_page_are_there(page):
    for words in filter(None, commands(page)):
        assert words[0] in COMMANDS
        head = words[:2] if words[0] in GROUPS else words[:1]
        known = set(re.findall(r"--[\w-]+", call(*head, "--help").stdout))
        assert {word for word in words if word.startswith("--")} <= known, words
        model = after(words, words[0]) if words[0] in ("run", "lab", "check") else None
        assert model is None or is_model(page, model), words
        shown = after(words, "show") if words[0] == "world" else None
        world = after(words, "--world") or shown
        assert world is None or world in layout_names() or world.endswith(".toml"), words
        paper = after(words, "paper")
        assert paper is None or paper in experiment_names(), words
