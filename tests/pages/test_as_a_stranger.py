"""The README's first commands as programs of their own, in a shell that knows no flockscope."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pages.blocks import ROOT, blocks_of

UV = f"""#!/bin/sh
# Stands for uv: runs a program of the environment that these tests run in.
[ "$1" = run ] || exit 64
shift
[ "$1" != --no-dev ] || shift
program=$1
shift
exec "{Path(sys.executable).parent}/$program" "$@" $MORE
"""
PIP = """#!/bin/sh
# Stands for pip: nothing is asked of a network.
[ "$*" = "install uv" ]
"""
BROWSER = """
import os, signal, sys, urllib.request
with urllib.request.urlopen(sys.argv[1], timeout=60) as answer:
    page = answer.read()
with open("seen", "wb") as file:
    file.write(page)
os.kill(os.getppid(), signal.SIGINT)
"""
"""Stands for a browser: keeps the page and presses Ctrl-C."""
TIMEOUT = 300.0


@pytest.fixture
def shell(checkout, tmp_path):
    """Runs lines in a shell in a checkout, where the only programs of ours are uv's."""
    programs = tmp_path / "bin"
    programs.mkdir()
    for name, text in (("uv", UV), ("pip", PIP)):
        (programs / name).write_text(text)
        (programs / name).chmod(0o755)
    browser = tmp_path / "browser.py"
    browser.write_text(BROWSER)
    known = {name: os.environ[name] for name in ("HOME", "NUMBA_CACHE_DIR") if name in os.environ}

    def run(lines, more="", given=None, at=checkout):
        environment = known | {
            "PATH": f"{programs}:/usr/bin:/bin",
            "BROWSER": f"{sys.executable} {browser} %s",
            "MORE": more,
        }
        return subprocess.run(
            ["sh", "-e", "-c", lines],
            cwd=at,
            env=environment,
            input=given,
            capture_output=True,
            text=True,
            timeout=TIMEOUT,
        )

    return run


def block_with(page, words):
    """The one block of a page with these words."""
    (found,) = [block for block in blocks_of(page) if words in block.code]
    return found.code


def test_a_plain_flockscope_is_not_found_there(shell):
    assert shell("flockscope --version").returncode == 127


def test_the_first_command_opens_the_laboratory(shell, checkout):
    done = shell(block_with("README.md", "&& uv run --no-dev flockscope"), more="--port 0")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("flockscope is at http://")
    assert "Traceback" not in done.stderr
    assert b"<html" in (checkout / "seen").read_bytes()


def test_the_first_worlds_are_drawn_and_made_and_flown_in(shell, checkout):
    """README says to put `uv run` before each command."""
    printed = block_with("docs/first-examples.md", "world make maze")
    done = shell("".join(f"uv run {line}\n" for line in printed.splitlines()))
    assert done.returncode == 0, done.stderr
    assert (checkout / "obstacles.png").read_bytes()[:4] == b"\x89PNG"
    assert "[mission]" in (checkout / "maze.toml").read_text()


def test_the_python_of_a_page_is_given_to_uv_run_python(shell):
    given = block_with("docs/rules/vem.md", "import Flock")
    done = shell("uv run python -", given=given, at=ROOT)  # elsewhere it would compile again
    assert done.returncode == 0, done.stderr
    assert 0.0 <= float(done.stdout) <= 1.0
