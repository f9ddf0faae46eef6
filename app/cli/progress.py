"""How far the work is, on stderr: a bar with the time left once it takes more than two seconds."""

from __future__ import annotations

import sys
import time
from typing import Any

from app.cli.terminal import make_console
from worlds.number_text import duration

TIMEOUT = 2.0
"""Seconds of work without a bar."""
LINE_EVERY = 30.0
"""Seconds between two lines where stderr is not a terminal."""


class Progress:
    """A context manager; call `at` as often as you like."""

    def __init__(self, title: str, quiet: bool = False):
        self.title = title
        self.quiet = quiet
        self.begun = self.told = time.monotonic()
        self.bar: Any = None
        self.task: Any = None

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.stop()

    def at(self, share: float, left: float | None = None, text: str = "") -> None:
        """Tell the share done, in [0, 1], and the seconds left, by default in proportion."""
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
