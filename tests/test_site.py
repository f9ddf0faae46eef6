"""The site of the pages is built without a warning, its links hold, and its notebooks have run."""

from __future__ import annotations

import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

from agents.catalogue import MODELS
from app.cli.main import COMMANDS
from app.studies.sweeps.sweep_file import SweepFile

ROOT = Path(__file__).parents[1]
BUILD = ROOT / "docs" / "build_site.py"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site, but for the pages that run flocks, which tests/cli/test_export.py writes."""
    folder = tmp_path_factory.mktemp("site") / "built"
    command = [sys.executable, str(BUILD), "--no-flocks", "--out", str(folder)]
    if os.name == "posix":  # it computes for minutes: what waits for events comes first
        command = ["nice", "-n", "10", *command]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def text(page):
    """The text of a page, without its tags."""
    return re.sub(r"<[^>]+>", "", page.read_text(encoding="utf-8"))


def test_every_page_of_docs_is_in_it(site):
    for page in (ROOT / "docs").rglob("*.md"):
        name = page.relative_to(ROOT / "docs").with_suffix(".html")
        if name.parts[0] not in ("_build", "_made"):
            assert (site / name).exists(), name


def test_notebooks_have_run_and_show_their_pictures(site):
    for notebook in (ROOT / "docs" / "tutorials").glob("*.ipynb"):
        page = (site / "tutorials" / notebook.stem).with_suffix(".html")
        assert re.search(r'<img alt="[^"]*" src="\.\./_images/', page.read_text(encoding="utf-8"))


def test_reference_has_every_command_model_and_key(site):
    commands = text(site / "_made" / "command-line.html")
    assert [name for name in COMMANDS if f"flockscope {name}" not in commands] == []
    parameters = text(site / "_made" / "parameters.html")
    assert [name for name in MODELS if name not in parameters] == []
    keys = text(site / "_made" / "file-formats.html")
    assert [key for key in SweepFile.model_fields if key not in keys] == []
    python = text(site / "_made" / "python-api.html")
    assert "class flockscope.Flock" in python.replace("\n", "")


def test_nothing_is_asked_of_another_machine(site):
    """Scripts, styles and pictures come from the site itself."""
    for page in site.rglob("*.html"):
        loaded = re.findall(
            r'<(?:script|link|img|iframe)[^>]*(?:src|href)="(https?:[^"]+)"',
            page.read_text(encoding="utf-8"),
        )
        assert loaded == [], page


def test_faults_of_a_site_are_found(tmp_path):
    faults = runpy.run_path(str(BUILD))["faults"]
    (tmp_path / "a.html").write_text(
        '<h1 id="top">A</h1><a href="b.html#here">b</a><a href="b.html#gone">b</a>'
        '<a href="c.html">c</a><img src="a.html"><img src="a.html" alt="words">'
        '<a href="#top">up</a><a href="https://example.org/">out</a>'
    )
    (tmp_path / "b.html").write_text('<p id="here">B</p>')
    assert list(faults(tmp_path)) == [
        "a.html: the picture a.html has no words",
        "a.html: b.html#gone: there is no such heading",
        "a.html: c.html leads nowhere",
    ]


def test_a_folder_with_other_files_is_left_alone(tmp_path):
    (tmp_path / "thesis.txt").write_text("mine")
    done = subprocess.run(
        [sys.executable, str(BUILD), "--out", str(tmp_path)], capture_output=True, text=True
    )
    assert done.returncode == 2
    assert "choose an empty folder" in done.stderr
    assert (tmp_path / "thesis.txt").read_text() == "mine"
