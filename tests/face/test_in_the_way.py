"""A module of the user's that hides a package of the checkout is named in one line."""

from __future__ import annotations

import subprocess
import sys

import pytest

PROGRAM = [sys.executable, "-m", "flockscope"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder in which Python is started."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PYTHONPATH", raising=False)
    return tmp_path


def run(*words):
    """A process that has the folder it is started in on its path."""
    return subprocess.run(words, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("name", ["agents", "app", "worlds"])
def test_the_command_says_so_in_one_line(folder, name):
    (folder / f"{name}.py").write_text("print('mine')\n")
    ran = run(*PROGRAM, "list")
    assert (ran.returncode, ran.stdout) == (2, "")
    [line] = ran.stderr.splitlines()
    assert line.startswith(f"flockscope: the module {folder / name}.py is in the way of ")
    assert f"'{name}'" in line
    assert "rename it" in line
    assert "install flockscope" in line


def test_a_package_of_that_name_is_in_the_way_too(folder):
    (folder / "agents").mkdir()
    (folder / "agents" / "__init__.py").write_text("")
    ran = run(*PROGRAM, "run", "vem")
    assert ran.returncode == 2
    assert len(ran.stderr.splitlines()) == 1


def test_so_does_the_script_where_the_path_has_it(folder, monkeypatch):
    (folder / "agents.py").write_text("")
    monkeypatch.setenv("PYTHONPATH", str(folder))
    ran = run(sys.executable, "-c", "from flockscope.__main__ import main; main()")
    assert ran.returncode == 2
    assert ran.stderr.startswith("flockscope: the module ")


@pytest.mark.parametrize(
    "line", ["from flockscope import Flock", "from flockscope.rules import Rule",
             "import agents, flockscope.worlds", "import flockscope.live"]
)  # fmt: skip
def test_an_import_says_so_in_its_last_line(folder, line):
    (folder / "agents.py").write_text("")
    ran = run(sys.executable, "-c", line)
    assert ran.returncode == 1
    assert ran.stderr.splitlines()[-1].startswith(
        f"ImportError: the module {folder / 'agents.py'} is in the way of flockscope's own 'agents'"
    )


def test_a_folder_without_python_is_not_in_the_way(folder):
    (folder / "agents").mkdir()
    (folder / "model.py").write_text("")
    ran = run(*PROGRAM, "cite", "vem", "--json")
    assert ran.returncode == 0, ran.stderr
