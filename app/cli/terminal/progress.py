"""How far the work is, on stderr: a bar with the time left once it takes more than two seconds."""

from __future__ import annotations

import os
import shlex
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

import typer

from app.cli.terminal.console import INTERRUPTED, make_console
from app.cli.terminal.outcome_table import print_stderr
from worlds.number_text import duration

if TYPE_CHECKING:
    from agents import Flock
    from agents.recordings.recorder import Recorder

TIMEOUT = 2.0
"""Seconds of work without a bar."""
LINE_EVERY = 30.0
"""Seconds between two lines where stderr is not a terminal."""


class Progress:
    """A context manager; call `update` as often as you like."""

    def __init__(self, title: str, quiet: bool = False, stopping: StopSignals | None = None):
        self.title = title
        self.quiet = quiet
        self.stopping = stopping
        self.begun = self.told = time.monotonic()
        self.bar: Any = None
        self.task: Any = None

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.stop()

    def update(self, share: float, left: float | None = None, text: str = "") -> None:
        """Tell the share done, in [0, 1], and the seconds left, by default in proportion.

        Raises KeyboardInterrupt once `stopping` is asked: Python drops one that a signal raises
        while it calls a finalizer.
        """
        if self.stopping is not None and self.stopping.asked:
            raise KeyboardInterrupt
        now = time.monotonic()
        spent = now - self.begun
        if self.quiet or spent < TIMEOUT:
            return
        if left is None:
            left = spent * (1.0 - share) / max(share, 1e-9)
        if sys.stderr.isatty():
            self.draw(share, left, text)
        elif now - self.told >= LINE_EVERY:
            self.told = now
            line = f"{self.title}: {share:.0%} done, {duration(left)} left {text}"
            print(line.rstrip(), file=sys.stderr)

    def draw(self, share: float, left: float, text: str) -> None:
        """Draw the bar."""
        if self.bar is None:
            self.bar = make_bar()
            self.task = self.bar.add_task(self.title, total=1.0, left="", text="")
            self.bar.start()
        self.bar.update(self.task, completed=share, left=f"{duration(left)} left", text=text)


def make_bar() -> Any:
    """A bar of rich on stderr that vanishes when it is done."""
    from rich import progress

    return progress.Progress(
        progress.TextColumn("{task.description}"),
        progress.BarColumn(),
        progress.TaskProgressColumn(),
        progress.TextColumn("{task.fields[left]}"),
        progress.TextColumn("[dim]{task.fields[text]}"),
        console=make_console(stderr=True),
        transient=True,
    )


# Ctrl-C and SIGTERM: ask a run to stop where it can, so that what it has done is kept.

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class StopSignals:
    """While entered, the first signal sets `asked`; a second one interrupts at once.

    With `at_once`, the first one interrupts too, SIGTERM like Ctrl-C, and a second one ends the
    process with this line: what an interrupt breaks off while it is being closed cannot be closed
    any more, and would say so in a traceback. Processes of ours end with the one that began them.
    """

    def __init__(self, at_once: str = ""):
        self.asked = False
        self.at_once = at_once
        self.before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> StopSignals:
        try:
            self.before = {
                signal_number: signal.signal(signal_number, self.handle_signal)
                for signal_number in SIGNALS
            }
        except ValueError:  # only the main thread receives signals
            self.before = {}
        return self

    def __exit__(self, *_: object) -> None:
        interrupted = bool(self.asked and self.at_once)
        for signal_number, handler in self.before.items():
            # Another one while the interpreter ends is to end it, without a traceback.
            signal.signal(signal_number, signal.SIG_DFL if interrupted else handler)

    def handle_signal(self, _number: int, _frame: FrameType | None) -> None:
        """Take a signal."""
        if self.asked and self.at_once:
            restore_cursor = (
                "\n\x1b[?25h" if os.isatty(2) else ""
            )  # below a bar, which hides the cursor
            os.write(
                2, f"{restore_cursor}{self.at_once}\n".encode()
            )  # `print` may be interrupted in itself
            os._exit(INTERRUPTED)
        interrupts = self.asked or self.at_once
        self.asked = True
        if interrupts:
            raise KeyboardInterrupt


@contextmanager
def runs_progress(title: str, runs: Path, quiet: bool) -> Iterator[Progress]:
    """A bar while runs are made and kept in `runs`; after Ctrl-C a line tells how to go on."""
    again = f"flockscope {shlex.join(sys.argv[1:])}"
    stopped = f"flockscope: stopped; finished runs are in {runs}; go on with: {again}"
    try:
        with StopSignals(at_once=stopped) as stopping, Progress(title, quiet, stopping) as progress:
            yield progress
    except KeyboardInterrupt:
        print_stderr(stopped)
        raise typer.Exit(INTERRUPTED) from None


def exit_process() -> None:
    """End the process, which is done, even while one of its threads compiles.

    In the usual farewell LLVM takes away what that thread stands on: it would crash, or hang.
    """
    if threading.active_count() > 1:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(0)


# Running a flock in short stretches, so that it can be watched, recorded and stopped.

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

    A flock that is empty for good ends the run, unless it is to be looked at to its last tick. A
    recording is whole in either case. `look` is called after each of the last `over` ticks, and
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
        while flock.tick < last and not stopping.asked and not ended(flock, over):
            until_frame = every - (flock.tick - first) % every
            until_looked_at = max(1, last - over - flock.tick) if over else ticks
            n = min(stretch, last - flock.tick, until_frame if recorder else ticks, until_looked_at)
            started = time.monotonic()
            flock.advance(n, until_ended=not over)
            check()
            if flock.tick > last - over:
                look()
            stretch = stretch_length(stretch, time.monotonic() - started)
            if recorder and ((flock.tick - first) % every == 0 or flock.tick == last):
                write()
                written = flock.tick
            progress.update((flock.tick - first) / ticks, text=f"tick {flock.tick}")
        if written != flock.tick:
            write()
        return flock.tick == last or ended(flock, over)


def ended(flock: Flock, over: int) -> bool:
    """Whether everybody has left for good, and nobody wants to look at the rest of the run."""
    return not over and flock.world.has_gates and flock.has_ended


def stretch_length(stretch: int, seconds: float) -> int:
    """Ticks of the next stretch, from how long the last one took."""
    if seconds < SHORT:
        return 2 * stretch
    return max(1, stretch // 2) if seconds > LONG else stretch
