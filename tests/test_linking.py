"""What a loop takes in as it was written down, and functions that numba compiles by itself."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from worlds.code_libraries import TRIED, LoopLibrary, PartLibrary, module_of, reached_libraries
from worlds.compilation import compiled, entry, shared

ROOT = Path(__file__).parents[1]


@numba.njit
def theirs(x):
    """A function of a plug-in that knows nothing of ours."""
    return math.hypot(x, 4.0)


@compiled
def twice(x):
    """A part of a part."""
    return 2.0 * theirs(x)


@shared
def thrice(x):
    """A part that stays a function of its own."""
    return twice(x) + theirs(x)


@compiled
def both(x):
    """A part that reaches the same function in two ways."""
    return twice(x) + thrice(x)


@entry
def loop(x):
    """What Python calls."""
    return both(x) + max(x, 100.0)


@numba.njit
def outside(x):
    """A function of a plug-in that calls a part of ours."""
    return both(x)


def test_a_loop_takes_in_all_that_it_reaches():
    assert loop(3.0) == pytest.approx(125.0)
    assert both(3.0) == pytest.approx(25.0)


def test_a_part_can_print(tmp_path):
    """In a process of its own: without its environment, it would wait for ever."""
    (tmp_path / "said.py").write_text(
        "from worlds.compilation import compiled, entry\n"
        "@compiled\ndef part(x):\n    print('at', x)\n    return x\n"
        "@entry\ndef loop(x):\n    return part(x)\n"
        "loop(3.0)\n"
    )
    said = subprocess.run(
        [sys.executable, tmp_path / "said.py"],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=120.0,
    )
    assert said.stdout == "at 3.0\n", said.stderr


def test_a_function_that_numba_compiles_itself_can_call_a_part():
    assert outside(3.0) == pytest.approx(25.0)


def test_each_part_is_taken_in_once_and_its_callers_come_first():
    assert numba.__version__.startswith(TRIED), "try it with this version, then add it to TRIED"
    loop(3.0)
    (made,) = (one.library for one in loop.overloads.values())
    assert isinstance(made, LoopLibrary)
    names = [module_of(one).name for one in reached_libraries(made)]
    order = [names.index(part) for part in ("both", "thrice", "twice")]
    assert order == sorted(order)
    assert len(names) == len(set(names))
    (part,) = (one.library for one in twice.overloads.values())
    assert isinstance(part, PartLibrary)
    assert part.get_pointer_to_function("twice") == 0
