"""Imports of the tree are written for their names inside `flockscope`; all else stays."""

from __future__ import annotations

import ast
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ONE_NAME = runpy.run_path(str(ROOT / "packing" / "one_name.py"))
rewritten, gather, files = ONE_NAME["rewritten"], ONE_NAME["gather"], ONE_NAME["files"]
ModuleInAString = ONE_NAME["ModuleInAString"]


IN = "flockscope._"


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("from agents import y\n", f"from {IN}agents import y\n"),
        ("from agents.rules.vicsek import V\n", f"from {IN}agents.rules.vicsek import V\n"),
        ("import agents.flock as x\n", f"import {IN}agents.flock as x\n"),
        ("import agents\n", f"import {IN}agents as agents\n"),
        (
            "import os, worlds.world, app as a\n",
            f"import os, {IN}worlds.world, {IN}worlds as worlds, {IN}app as a\n",
        ),
        ("def f():\n\tfrom app.cli import g\n", f"def f():\n\tfrom {IN}app.cli import g\n"),
        ("if x: from worlds import z; y()\n", f"if x: from {IN}worlds import z; y()\n"),
        (
            "from agents.flock import (  # from agents import z\n    Flock as F,\n    known,\n)\n",
            f"from {IN}agents.flock import (  # from agents import z\n    Flock as F,\n"
            "    known,\n)\n",
        ),
        ("from \\\n  agents.flock import F\n", f"from \\\n  {IN}agents.flock import F\n"),
        ("é = 'ü'; from agents import y\n", f"é = 'ü'; from {IN}agents import y\n"),
        ("from agents import y\r\nz = 1\r\n", f"from {IN}agents import y\r\nz = 1\r\n"),
    ],
)
def test_imports_of_ours(source, expected):
    assert rewritten(source, "made.py") == expected
    ast.parse(expected)


@pytest.mark.parametrize(
    "source",
    [
        "from . import agents\nfrom .agents import y\nfrom ..worlds.world import World\n",
        "import agents_of_others\nfrom apps import x\nfrom m import agents\nimport m.agents\n",
        "# from agents import y\n",
        '"""See `agents.engine.cache`.\n\nfrom agents import y\n"""\n',
        "x = 'from agents import y'\n",
        "agents = flock.agents\nprint(agents.select(worlds), app.cli)\n",
        "def f():\n    yield from agents\n",
        "raise ValueError from app\n",
    ],
)
def test_what_stays(source):
    assert rewritten(source, "made.py") == source


@pytest.mark.parametrize(
    "source",
    [
        "import_module('agents.flock')\n",
        "\n\nname = f'agents.engine.{kind}_x'\n",
        "COMMANDS = {'lab': 'app.cli.lab'}\n",
    ],
)
def test_the_name_of_a_module_in_a_string_is_refused(source):
    line = source.count("\n")
    with pytest.raises(
        ModuleInAString, match=rf"^made.py, line {line}: '\w+\.[\w.]+' names a module"
    ):
        rewritten(source, "made.py")


def test_the_lines_stay_where_they_are():
    source = "import agents.flock\n\nfrom worlds.world import (\n    World,\n)\n\nx = 1 / 0\n"
    assert rewritten(source, "made.py").count("\n") == source.count("\n")
    assert rewritten(source, "made.py").splitlines()[6] == "x = 1 / 0"


def test_what_is_bound_is_what_was_bound(tmp_path, monkeypatch):
    made = tmp_path / "flockscope"
    for folder in ("_agents", "_worlds"):
        (made / folder).mkdir(parents=True)
        (made / folder / "__init__.py").write_text("A = 1\n")
    (made / "__init__.py").write_text("")
    (made / "_agents" / "flock.py").write_text("B = 2\n")
    source = "import agents.flock\nfrom worlds import A\nimport agents.flock as x\nimport worlds\n"
    source += "print(agents.A, agents.flock.B, A, x.B, worlds.A)\n"
    script = tmp_path / "script.py"
    script.write_text(rewritten(source, "script.py"))
    monkeypatch.delenv("PYTHONPATH", raising=False)
    ran = subprocess.run([sys.executable, "-P", "-S", "-c",
                          f"import sys; sys.path.insert(0, {str(tmp_path)!r}); "
                          f"exec(open({str(script)!r}).read())"],
                         capture_output=True, text=True, check=False)  # fmt: skip
    assert ran.stdout == "1 2 1 2 1\n", ran.stderr


@pytest.fixture(scope="module")
def gathered(tmp_path_factory):
    """The package as a wheel holds it."""
    made = tmp_path_factory.mktemp("gathered") / "flockscope"
    gather(ROOT, made)
    return made


@pytest.mark.exhaustive
def test_the_whole_tree_is_gathered_under_one_name(gathered):
    assert {path.name for path in gathered.iterdir() if path.is_dir()} == {
        "_agents", "_app", "_worlds", "experiments", "static",
    }  # fmt: skip
    for part in ("app", "agents", "worlds"):
        there = [path.relative_to(ROOT / part) for path in files(ROOT / part)]
        assert there == [
            path.relative_to(gathered / f"_{part}") for path in files(gathered / f"_{part}")
        ]
    assert (gathered / "_worlds" / "layouts" / "wrap.toml").is_file()
    assert (gathered / "experiments" / "liu2021-table1.toml").is_file()
    assert (gathered / "static" / "logo.svg").is_file()


@pytest.mark.exhaustive
def test_nothing_in_it_imports_a_plain_name(gathered):
    for file in files(gathered):
        if file.suffix != ".py":
            continue
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and not node.level:
                names = [node.module]
            assert not {name.partition(".")[0] for name in names} & {"app", "agents", "worlds"}, (
                file
            )
