"""Running a flock in short stretches, so that it can be watched, recorded and stopped."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING

from app.cli.progress import Progress
from app.cli.stop_signals import StopSignals

if TYPE_CHECKING:
    from agents import Flock
    from agents.record import Recorder

SHORT, LONG = 0.05, 0.2
"""Seconds between which a stretch is kept."""


def run_ticks(
    flock: Flock,
    ticks: int,
    progress: Progress,
    recorder: Recorder | None = None,
    every: int = 1,
    look: Callable[[], None] = lambda: None,
    over: int = 0,
    check: Callable[[], None] = lambda: None,
) -> bool:
    """Run ticks, recording the first, every `every`-th and the last; False if asked to stop.

    A recording is whole in either case. `look` is called after each of the last `over` ticks, and
    `check` after each stretch.
    Raises InputError if the recording cannot be written.
    """
    with StopSignals() as stopping, ExitStack() as stack:
        write: Callable[[], None] = lambda: None  # noqa: E731
        if recorder is not None:
            write = stack.enter_context(recorder).write
        first, last = flock.tick, flock.tick + ticks
        write()
        written = flock.tick
        stretch = 1
        while flock.tick < last and not stopping.asked:
            until_frame = every - (flock.tick - first) % every
            until_looked_at = max(1, last - over - flock.tick) if over else ticks
            n = min(stretch, last - flock.tick, until_frame if recorder else ticks, until_looked_at)
            begun = time.monotonic()
            flock.run(n)
            check()
            if flock.tick > last - over:
                look()
            stretch = next_stretch(stretch, time.monotonic() - begun)
            if recorder and ((flock.tick - first) % every == 0 or flock.tick == last):
                write()
                written = flock.tick
            progress.at((flock.tick - first) / ticks, text=f"tick {flock.tick}")
        if written != flock.tick:
            write()
        return flock.tick == last


def next_stretch(stretch: int, seconds: float) -> int:
    """Ticks of the next stretch, from how long the last one took."""
    if seconds < SHORT:
        return 2 * stretch
    return max(1, stretch // 2) if seconds > LONG else stretch
