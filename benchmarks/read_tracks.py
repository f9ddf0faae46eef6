"""How long tracks take to be read: 100 individuals in 3000 frames, for each format.

    uv run python benchmarks/read_tracks.py [--only petrack,sleap] [--individuals 100]

Seconds by the clock, the best of three, files in the cache of the disk, and how many places a
second that is. One in twenty places is a gap. Wanted: less than a second each.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]
from flockscope.tracks import read  # noqa: E402
from tests.tracks import written_formats  # noqa: E402

WANTED = 1.0
"""Seconds."""
REPEATS = 3
Case = tuple[str, Callable[[Path], Callable[[], Any]]]
"""A name, and what prepares it in a folder: it returns what is timed."""


def use_walk(individuals: int, frames: int) -> None:
    """Have the written formats hold a walk of that size."""
    rng = np.random.default_rng(1)
    steps = rng.normal(0.0, 0.05, (frames, individuals, 2))
    places = rng.uniform(1.0, 9.0, (individuals, 2)) + np.cumsum(steps, axis=0)
    places[rng.random((frames, individuals)) < 0.05] = np.nan
    places[0] = np.nan_to_num(places[0], nan=5.0)
    written_formats.FRAMES, written_formats.COUNT = frames, individuals
    written_formats.PLACES, written_formats.SEEN = places, np.isfinite(places[..., 0])


def reading(form: written_formats.WrittenFormat, folder: Path) -> Callable[[], Any]:
    """Reading a file of a format."""
    path = form.written(folder)
    return partial(read, path, **form.options)


CASES: list[Case] = [
    (f"read {form.name} ({form.file})", partial(reading, form)) for form in written_formats.FORMATS
]


def main() -> None:
    """Print a line for each case."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--only", default="", help="names of formats, with commas")
    options.add_argument("--individuals", type=int, default=100)
    options.add_argument("--frames", type=int, default=3000)
    asked = options.parse_args()
    use_walk(asked.individuals, asked.frames)
    wanted = [name for name in asked.only.split(",") if name]
    places = asked.individuals * asked.frames
    slow = 0
    for name, prepare in CASES:
        if wanted and not any(f" {one} " in f"{name} " for one in wanted):
            continue
        with tempfile.TemporaryDirectory() as folder:
            timed = prepare(Path(folder))
            seconds = []
            for _ in range(REPEATS):
                begun = time.perf_counter()
                timed()
                seconds.append(time.perf_counter() - begun)
        best = min(seconds)
        slow += best > WANTED
        verdict = "" if best <= WANTED else f"  more than {WANTED:g} s"
        print(
            f"{name:<44} {best:6.3f} s  {places / best / 1e6:6.2f} M places/s{verdict}", flush=True
        )
    print(f"{slow} of the cases take more than {WANTED:g} s")


if __name__ == "__main__":
    main()
