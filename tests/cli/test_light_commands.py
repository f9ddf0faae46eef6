"""Commands that only tell what there is import none of the slow libraries."""

import subprocess
import sys

import pytest

from app.cli.choices import LISTED

SLOW = {"mesa", "pandas", "networkx", "scipy", "numba", "matplotlib", "viser", "pyarrow"}
LOADED = """
import runpy, sys
sys.argv = ["flockscope", *sys.argv[1:]]
try:
    runpy.run_module("flockscope", run_name="__main__")
finally:
    print(*sorted({name.partition(".")[0] for name in sys.modules}), file=sys.stderr)
"""


def loaded_by(*args):
    """The packages that a command has loaded when it ends."""
    ran = subprocess.run(
        [sys.executable, "-c", LOADED, *args], capture_output=True, text=True, check=True
    )
    return set(ran.stderr.split())


@pytest.mark.parametrize(
    "command",
    [
        "--help",
        "list",
        "list models",
        "list parameters",
        "list worlds",
        "list observables",
        "list papers",
        "list lessons",
        "list --json",
        "list p1",
        "world --help",
        "world list",
        "paper --help",
        "flight --help",
        "formation --help",
        "live --help",
    ],
)
def test_it_loads_nothing_slow(command):
    LISTED.touch()  # as docs/make.py leaves it: nothing that is declared is newer
    loaded = loaded_by(*command.split())
    assert "typer" in loaded
    assert loaded & SLOW == set()


def test_what_is_slow_would_be_seen():
    assert {"numba", "scipy"} <= loaded_by("list", "hwvem")
