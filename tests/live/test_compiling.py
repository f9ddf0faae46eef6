"""The first start of a rule says that it is compiled; later ones say nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from cli.calling import call

from agents.motion.motion import Motion
from app.live.laboratory.lab_file import example
from app.live.operating.flock_driver import COMPILING, FlockDriver
from app.viewer.live.panels.state_panel import banner_of
from app.viewer.live.session_requests import SessionState

ROOT = Path(__file__).parents[2]
WORDS = COMPILING.format("squashing-cars")


def test_a_driver_says_so_only_if_it_is_not_compiled_yet(monkeypatch):
    FlockDriver(example())
    told = []
    FlockDriver(example(), told.append)
    assert told == []
    monkeypatch.setattr(Motion, "is_compiled", property(lambda _: False))
    FlockDriver(example(), told.append)
    assert told == [WORDS]


SAYS = """
import sys
from app.live.laboratory.lab_file import example
from app.live.operating.flock_driver import COMPILING, FlockDriver

def tell(words):
    print(words)
    sys.exit(0)  # what follows takes a minute

FlockDriver(example(), tell)
print("compiled already")
"""


def test_without_anything_in_the_cache_it_says_so_before_it_compiles(tmp_path):
    made = subprocess.run(
        [sys.executable, "-c", SAYS],
        env=os.environ | {"FLOCKSCOPE_CACHE": str(tmp_path)},
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert made.stdout.splitlines() == [WORDS]


@pytest.mark.parametrize("first", [True, False])
def test_the_terminal_says_so_on_stderr(monkeypatch, first):
    if first:
        monkeypatch.setattr(Motion, "is_compiled", property(lambda _: False))
    made = call("live", "emulate", "--seconds", 0.2)
    assert made.exit_code == 0
    assert (WORDS in made.stderr) == first
    assert "compiling" not in made.stdout


def test_the_page_says_so_while_it_lasts():
    state = SessionState("emulated cars", "dry run", "squashing")
    assert banner_of(state, None).words == "Waiting for the control loop."
    compiling = SessionState("emulated cars", "dry run", "squashing", compiling=WORDS)
    assert banner_of(compiling, None).words == WORDS[:1].upper() + WORDS[1:]
