"""A state of this tree in a process of its own, that flies when it is asked to."""

from __future__ import annotations

import hashlib
import multiprocessing
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path

from turns import Taken, time_work

PREPARED = {}
"""In a process of a tree: the case that it flies now, under "case"."""


def enter(tree: Path, cache: Path | None) -> None:
    """Import from a tree, on one core if the platform lets a process choose."""
    sys.path.insert(0, str(tree))
    if cache is not None:
        os.environ["FLOCKSCOPE_CACHE"] = str(cache)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def prepare(name: str, changes: dict[str, int]) -> tuple[str, int, int]:
    """Compile a case; a digest of where its agents start, how many they are, ticks of a round.

    Changes are to its own numbers of agents and ticks.
    """
    from cases import CASES

    PREPARED["case"] = case = replace(CASES[name], **changes)
    flock = case.flock()
    start = hashlib.sha256(flock.position.tobytes()).hexdigest()
    flock.run(1)
    return start, len(flock.ids), case.ticks


def fly(ticks: int) -> Taken:
    """The time of so many ticks of the prepared case after making its flock and a first tick."""
    flock = PREPARED["case"].flock()
    flock.run(1)
    return time_work(lambda: flock.run(ticks))


class Tree(AbstractContextManager["Tree"]):
    """The process of a tree, and the calls that it answers."""

    def __init__(self, path: Path, cache: Path | None = None):
        self.path = path
        self.process = ProcessPoolExecutor(
            1, multiprocessing.get_context("spawn"), initializer=enter, initargs=(path, cache)
        )

    def __exit__(self, *_: object) -> None:
        self.process.shutdown()

    def prepare(self, name: str, changes: dict[str, int]) -> tuple[str, int, int]:
        """See `prepare`."""
        return self.process.submit(prepare, name, changes).result()

    def fly(self, ticks: int) -> Taken:
        """See `fly`."""
        return self.process.submit(fly, ticks).result()
