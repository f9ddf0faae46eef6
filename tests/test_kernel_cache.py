"""Compiled kernels come from the cache when nothing changed, and never when a rule did."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from agents.engine.cache import compile_to_disk
from worlds.compilation import levels_here

PLUGIN = """
from flockscope import MODELS
from flockscope.rules import CONSTANT_SPEED, Model, Rule, Vicsek, Decision, compiled
from turning import turn

@compiled
def decide(me, near, surroundings, p):
    return turn(me)

RULE = Rule("turner", "Turner", "Turns.", "x", "none", Vicsek, decide)
MODELS["turner"] = Model(RULE, CONSTANT_SPEED)
"""
HELPER = """
from flockscope.rules import Decision, compiled

{constant}

@compiled
def turn(me):
    return Decision({x}, {y}, 0.0)
"""
SCRIPT = """
import plugin
from flockscope import Flock
flock = Flock("turner", agents=3, rng=1)
print(flock.is_compiled)
if {runs}:
    flock.run(1)
    print([round(float(u), 3) for u in flock.heading[0]])
"""


def run(folder: Path, constant: str, x: str, y: str, runs: bool = True) -> list[str]:
    (folder / "plugin.py").write_text(PLUGIN)
    (folder / "turning.py").write_text(HELPER.format(constant=constant, x=x, y=y))
    environment = {
        **os.environ,
        "FLOCKSCOPE_CACHE": str(folder / "cache"),
        "PYTHONPATH": str(folder),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    script = SCRIPT.format(runs=runs)
    done = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
    )
    return done.stdout.splitlines()


def test_an_edit_is_never_run_stale_and_an_unedited_rule_is_not_compiled_again(tmp_path):
    """The edit is in a function that the rule calls, in another file: what numba does not see."""
    assert run(tmp_path, "WAY = -1.0", "WAY", "0.0") == ["False", "[-1.0, 0.0]"]
    assert run(tmp_path, "WAY = -1.0", "WAY", "0.0") == ["True", "[-1.0, 0.0]"]
    assert run(tmp_path, "WAY = -1.0", "0.0", "WAY", runs=False) == ["False"]
    assert run(tmp_path, "WAY = 1.0", "WAY", "0.0") == ["False", "[1.0, 0.0]"], "a constant counts"


MOVED = """
import sys
from {module} import Place
from agents.engine.cache import compile_to_disk

def doubled(place):
    return 2.0 * place.x

print(compile_to_disk(doubled)(Place(3.0)))
"""


def test_kernels_whose_arguments_have_moved_to_another_module_are_compiled_anew(tmp_path):
    def doubled(module: str) -> str:
        (tmp_path / f"{module}.py").write_text(
            "from typing import NamedTuple\nclass Place(NamedTuple):\n    x: float\n"
        )
        (tmp_path / "script.py").write_text(MOVED.format(module=module))
        environment = {
            **os.environ,
            "FLOCKSCOPE_CACHE": str(tmp_path / "cache"),
            "PYTHONPATH": os.pathsep.join([str(tmp_path), os.getcwd()]),
        }
        done = subprocess.run(
            [sys.executable, str(tmp_path / "script.py")],
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert doubled("here") == "6.0\n"
    (tmp_path / "here.py").unlink()
    assert doubled("there") == "6.0\n"


GONE = """
from worlds.compilation import compiled

@compiled
def twice(x):
    return 2.0 * x

def doubled(x):
    return twice(x)
"""


def test_a_kernel_of_a_module_that_is_gone_is_compiled_anew(tmp_path, monkeypatch):
    """As of a rule that a notebook has made."""
    monkeypatch.setenv("FLOCKSCOPE_CACHE", str(tmp_path))
    path = tmp_path / "gone.py"
    path.write_text(GONE)
    code = compile(GONE, str(path), "exec")
    for _ in range(2):
        names: dict = {"__name__": "gone"}
        exec(code, names)
        made = compile_to_disk(names["doubled"])
        assert made(3.0) == 6.0
    assert sum(made.stats.cache_misses.values()) == 1


AT_ONCE = """
import time, sys
from agents.engine.cache import compile_to_disk

def doubled(x):
    return 2.0 * x

made = compile_to_disk(doubled)
while time.time() < float(sys.argv[1]):
    pass
made(3.0)
print(sum(made.stats.cache_misses.values()))
"""


def test_processes_that_want_the_same_kernel_at_once_compile_it_once(tmp_path):
    (tmp_path / "script.py").write_text(AT_ONCE)
    environment = {
        **os.environ,
        "FLOCKSCOPE_CACHE": str(tmp_path / "cache"),
        "PYTHONPATH": os.getcwd(),
    }
    start = str(time.time() + 8.0)
    command = [sys.executable, str(tmp_path / "script.py"), start]
    asked = [
        subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
        for _ in range(3)
    ]
    assert sorted(int(one.communicate()[0]) for one in asked) == [0, 0, 1]


DOUBLED = """
import resource, sys
from agents.engine.cache import compile_to_disk, is_kept

def doubled(x):
    return 2.0 * x

def trebled(x):
    return 3.0 * x

if {most}:
    resource.setrlimit(resource.RLIMIT_FSIZE, ({most}, {most}))
made = compile_to_disk(doubled), compile_to_disk(trebled)
print(is_kept(made[0]), made[0](3.0), made[1](3.0), sum(made[0].stats.cache_misses.values()))
"""


def calls(
    folder: Path, cache: Path, most: int = 0, script: str = DOUBLED
) -> tuple[list[str], list[str]]:
    """What calls of two kernels print, and what is told; files hold at most `most` bytes."""
    (folder / "script.py").write_text(script.replace("{most}", str(most)))
    environment = {**os.environ, "FLOCKSCOPE_CACHE": str(cache), "PYTHONPATH": os.getcwd()}
    done = subprocess.run(
        [sys.executable, str(folder / "script.py")],
        env=environment | {"PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.split(), done.stderr.splitlines()


def test_a_cache_that_cannot_be_written_is_told_once_and_done_without(tmp_path):
    (tmp_path / "no-folder").write_text("")
    printed, told = calls(tmp_path, tmp_path / "no-folder")
    assert printed == ["False", "6.0", "9.0", "1"]
    assert len(told) == 1
    assert told[0].startswith(f"flockscope: compiled kernels cannot be kept in {tmp_path}")
    assert not list(tmp_path.rglob("*.kernel"))


def test_a_full_disk_is_told_once_and_done_without(tmp_path):
    printed, told = calls(tmp_path, tmp_path / "cache", most=100)
    assert printed == ["False", "6.0", "9.0", "1"]
    assert len(told) == 1
    assert "cannot be kept" in told[0]
    assert not [one for one in tmp_path.rglob("*.kernel*") if one.is_file()]


@pytest.mark.parametrize(
    "damage",
    [lambda whole: whole[:-20], lambda _: b"", lambda whole: whole[:80] + b"?" + whole[81:]],
    ids=["cut", "empty", "one byte"],
)
def test_what_is_damaged_is_told_once_and_compiled_anew(tmp_path, damage):
    assert calls(tmp_path, tmp_path / "cache") == (["False", "6.0", "9.0", "1"], [])
    for path in tmp_path.rglob("*.kernel"):
        path.write_bytes(damage(path.read_bytes()))
    printed, told = calls(tmp_path, tmp_path / "cache")
    assert printed == ["False", "6.0", "9.0", "1"]
    assert len(told) == 1
    assert "are damaged: they are compiled anew" in told[0]
    assert calls(tmp_path, tmp_path / "cache") == (["True", "6.0", "9.0", "0"], [])


def test_another_checkout_finds_what_this_one_has_compiled(tmp_path):
    """Kernels are found by their code, not by the path of their files."""
    for place in ("here", "there"):
        (tmp_path / place).mkdir()
    assert calls(tmp_path / "here", tmp_path / "cache") == (["False", "6.0", "9.0", "1"], [])
    assert calls(tmp_path / "there", tmp_path / "cache") == (["True", "6.0", "9.0", "0"], [])


BROUGHT = """
from pathlib import Path
from agents.engine import cache
cache.SHIPPED = Path({shipped!r})
"""


def test_what_a_wheel_brings_is_taken_where_the_user_has_nothing(tmp_path):
    """And is compiled anew where it is damaged, and no part of the user's own folder."""
    calls(tmp_path, tmp_path / "wheel")
    script = BROUGHT.format(shipped=str(tmp_path / "wheel")) + DOUBLED
    assert calls(tmp_path, tmp_path / "cache", script=script) == (["True", "6.0", "9.0", "0"], [])
    assert not list((tmp_path / "cache").rglob("*.kernel"))
    for path in (tmp_path / "wheel").rglob("*.kernel"):
        path.write_bytes(path.read_bytes()[:-1])
    printed, told = calls(tmp_path, tmp_path / "cache", script=script)
    assert printed == ["False", "6.0", "9.0", "1"]
    assert told == [
        f"flockscope: compiled kernels in {tmp_path / 'wheel'} are damaged: they are compiled anew"
    ]


LEVEL = """
import hashlib
from agents import Flock
for model in ("topological", "pedestrian"):
    flock = Flock(model, rng=1)
    flock.run(30)
    print(hashlib.sha256(flock.position.tobytes()).hexdigest())
"""


@pytest.mark.skipif(len(levels_here()) < 2, reason="this CPU runs one level of x86-64 alone")
def test_every_level_of_x86_64_gives_the_same_bits(tmp_path):
    """These two had others when the compiler chose how many terms to add at once."""
    bits = set()
    for level in levels_here():
        environment = {
            **os.environ,
            "FLOCKSCOPE_CACHE": str(tmp_path),
            "NUMBA_CPU_NAME": level,
            "NUMBA_CPU_FEATURES": "",
        }
        command = [sys.executable, "-c", LEVEL]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        bits.add(done.stdout)
    assert len(bits) == 1
    assert len({path.name.partition(".")[0] for path in tmp_path.rglob("*.kernel")}) == 2
