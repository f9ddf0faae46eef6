"""The first start of a model: how long its loop compiles, and how long by numba's usual way.

uv run python benchmarks/first_start.py [MODEL ...]

Each in a process of its own with an empty cache; "usual": every part of the loop callable from
Python, as `numba.njit` makes it.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile

CHILD = """
import sys, time
import numba
import worlds.compiled
model, usual = sys.argv[1], sys.argv[2] == "usual"
if usual:
    options = worlds.compiled.OPTIONS | {"no_cfunc_wrapper": False}
    worlds.compiled.compiled = numba.njit(**options, forceinline=True)
from agents import Flock
flock = Flock(model, rng=1)
begins = time.perf_counter()
flock.run(1)
print(time.perf_counter() - begins)
"""


def first_start(model: str, way: str) -> float:
    """Seconds of the first tick of a model that nobody has compiled."""
    with tempfile.TemporaryDirectory() as cache:
        done = subprocess.run(
            [sys.executable, "-c", CHILD, model, way],
            env=os.environ | {"FLOCKSCOPE_CACHE": cache},
            capture_output=True,
            text=True,
            check=True,
        )
    return float(done.stdout)


def main() -> None:
    """Print a line for each model."""
    for model in sys.argv[1:] or ["hwvem", "squashing-best", "guarded"]:
        ours, usual = first_start(model, "ours"), first_start(model, "usual")
        print(f"{model}: {ours:.1f} s; usual {usual:.1f} s; ratio {ours / usual:.2f}")


if __name__ == "__main__":
    main()
