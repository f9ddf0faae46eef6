"""Watches the files of rules: what is saved in one, the running flock goes on under."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from pathlib import Path

EVERY = 0.3
"""Time between two looks at the files, s."""


class RuleFiles:
    """Looks at files by name of their model, and calls `changed` for one that has other content.

    A file that is being written, or is away for a moment as some editors have it, is waited for:
    its content counts once two looks have found the same.
    """

    def __init__(
        self,
        files: Mapping[str, Path],
        changed: Callable[[Path], object],
        clock: Callable[[], float] = time.monotonic,
    ):
        self.files, self.changed, self.clock = files, changed, clock
        self.taken: dict[Path, bytes] = {}
        """What the rules were made of."""
        self.seen: dict[Path, bytes] = {}
        """What the last look has found."""
        self.due = clock()
        self.look()

    def look(self) -> None:
        """Look whether anything is new, if it is time to."""
        if self.clock() < self.due:
            return
        self.due = self.clock() + EVERY
        for path in dict.fromkeys(self.files.values()):
            try:
                content = path.read_bytes()
            except OSError:
                continue
            known = self.taken.setdefault(path, content)
            if content != known and content == self.seen.get(path):
                self.taken[path] = content
                self.changed(path)
            self.seen[path] = content
