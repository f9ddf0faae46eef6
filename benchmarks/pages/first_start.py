"""The first start: of the command, of a model that nobody has compiled, and of a fresh clone.

    uv run python benchmarks/pages/first_start.py [--install] [MODEL ...]

First the CPU seconds of what every command and every script pays, the least of several processes
that have their .pyc files. Then those that the loop of each model compiles, beside numba's own way,
each in a process of its own with an empty cache; in numba's own way every part of the loop is
optimised and made machine code by itself, before the loop takes it in.

`--install` takes minutes: how large an environment is without and with the developers' group, and
how long it takes by the clock from cloning to the page of README's first command, and to the first
tick of its flock without a page, which is compiled for it. Packages come from uv's cache, if it has
them.
"""

from __future__ import annotations

import argparse
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).parents[2]
ROUNDS = 9
COMMAND = [sys.executable, "-m", "flockscope"]
TIMEOUT = 900.0
"""Seconds that a page may take to be served."""
CHILD = """
import sys, time
from numba.core.compiler import Compiler
import worlds.compilation
model, way = sys.argv[1:]
if way != "ours":
    worlds.compilation.PARTS = worlds.compilation.LOOPS = Compiler
from agents import Flock
flock = Flock(model, rng=1)
begins = time.process_time()
flock.run(1)
print(time.process_time() - begins)
"""


def cpu_of(words: list[str]) -> float:
    """CPU seconds of a program from its start to its end: the least of several rounds."""
    times = []
    for _ in range(ROUNDS):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(words, cwd=ROOT, stdout=subprocess.DEVNULL, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(times)


def print_commands() -> None:
    """Print what commands that only tell something cost, and importing the face."""
    seconds = cpu_of([*COMMAND, "--help"])
    print(f"--help: {seconds:.2f} s of CPU")
    for words in ("list", "list models", "world list", "paper --help"):
        spent = cpu_of([*COMMAND, *words.split()])
        print(f"{words}: {spent:.2f} s; over --help {spent / seconds:.2f}")
    nothing = cpu_of([sys.executable, "-c", "pass"])
    for names in ("", "World", "MODELS", "Flock"):
        code = f"from flockscope import {names}" if names else "import flockscope"
        print(f"{code}: {cpu_of([sys.executable, '-c', code]) - nothing:.3f} s beside Python's own")


def first_tick(model: str, way: str) -> float:
    """CPU seconds of the first tick of a model that nobody has compiled."""
    with tempfile.TemporaryDirectory() as cache:
        done = subprocess.run(
            [sys.executable, "-c", CHILD, model, way],
            env=os.environ | {"FLOCKSCOPE_CACHE": cache},
            capture_output=True,
            text=True,
            check=True,
        )
    return float(done.stdout)


def print_models(models: list[str]) -> None:
    """Print a line for each model."""
    for model in models:
        own_times, numbas = first_tick(model, "ours"), first_tick(model, "numba's")
        print(
            f"{model}: {own_times:.1f} s; numba's own way {numbas:.1f} s; "
            f"ratio {own_times / numbas:.2f}"
        )


def fresh_environment(folder: Path) -> dict[str, str]:
    """Surroundings of a program in which nothing is installed or compiled yet."""
    own = {"UV_PROJECT_ENVIRONMENT": str(folder / "env"), "FLOCKSCOPE_CACHE": str(folder / "cache")}
    environment = {name: value for name, value in os.environ.items() if name != "VIRTUAL_ENV"}
    return environment | own


def megabytes(*options: str) -> float:
    """What an environment takes on the disk, in units of 10^6 bytes."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sync = ["uv", "sync", "--quiet", "--locked", *options]
        subprocess.run(sync, cwd=ROOT, env=fresh_environment(folder), check=True)
        files = [path.lstat() for path in (folder / "env").rglob("*")]
        return sum(512 * path.st_blocks for path in files) / 1e6


def time_to_page(clone: Path, surroundings: dict[str, str]) -> None:
    """Start README's first command in a clone, read its page, and stop it."""
    words = ["uv", "run", "--quiet", "--no-dev", "flockscope", "lab", "--port", "0", "--no-open"]
    with subprocess.Popen(
        words, cwd=clone, env=surroundings, text=True, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
    ) as process:  # fmt: skip
        assert process.stdout is not None
        try:
            address = next(
                match[0] for line in process.stdout if (match := re.search(r"http://\S+:\d+", line))
            )
            with urllib.request.urlopen(address, timeout=TIMEOUT) as answer:
                assert b"<html" in answer.read()
        finally:
            os.killpg(process.pid, signal.SIGKILL)


def time_to_tick(clone: Path, surroundings: dict[str, str]) -> None:
    """Run the flock of README's first command in a clone, without a page, for its first tick."""
    words = ["uv", "run", "--quiet", "--no-dev", "flockscope", "run", "--ticks", "1", "hwvem"]
    subprocess.run(
        words, cwd=clone, env=surroundings, check=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip


def since_cloned(until: Callable[[Path, dict[str, str]], None]) -> float:
    """Seconds by the clock from nothing at all, not even a clone, until something has happened."""
    with tempfile.TemporaryDirectory() as name:
        folder, clone = Path(name), Path(name) / "clone"
        started = time.perf_counter()
        subprocess.run(["git", "clone", "--quiet", str(ROOT), str(clone)], check=True)
        until(clone, fresh_environment(folder))
        return time.perf_counter() - started


def main() -> None:
    """Print what is asked for."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("models", nargs="*", default=["hwvem", "squashing-best", "guarded"])
    arguments.add_argument("--install", action="store_true", help="environments and a clone too")
    parsed = arguments.parse_args()
    print_commands()
    print_models(parsed.models)
    if parsed.install:
        for title, options in (("without", ["--no-dev"]), ("with", [])):
            size = megabytes(*options)
            print(f"environment {title} the developers' group: {size:.0f} MB")
        print(f"from clone to the page of the laboratory: {since_cloned(time_to_page):.1f} s")
        print(f"from clone to a flock that has moved: {since_cloned(time_to_tick):.1f} s")


if __name__ == "__main__":
    main()
