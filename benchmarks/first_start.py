"""The first start of a model: CPU seconds that its loop compiles, and in numba's own way.

uv run python benchmarks/first_start.py [MODEL ...]

Each in a process of its own with an empty cache. In numba's own way every part of the loop is
optimised and made machine code by itself, before the loop takes it in.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile

CHILD = """
import sys, time
from numba.core.compiler import Compiler
import worlds.compiled
model, way = sys.argv[1:]
if way != "ours":
    worlds.compiled.PARTS = worlds.compiled.LOOPS = Compiler
from agents import Flock
flock = Flock(model, rng=1)
begins = time.process_time()
flock.run(1)
print(time.process_time() - begins)
"""


def first_start(model: str, way: str) -> float:
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


def main() -> None:
    """Print a line for each model."""
    for model in sys.argv[1:] or ["hwvem", "squashing-best", "guarded"]:
        ours, numbas = first_start(model, "ours"), first_start(model, "numba's")
        print(f"{model}: {ours:.1f} s; numba's own way {numbas:.1f} s; ratio {ours / numbas:.2f}")


if __name__ == "__main__":
    main()
