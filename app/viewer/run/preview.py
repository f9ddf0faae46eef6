"""What moves on the page until a run is compiled: the same run as plain Python."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from app.viewer.run.flock_run import FlockRun
from worlds.input_error import InputError

MOST_AGENTS = 300
"""A tick of more agents takes too long in plain Python."""
SLOWEST, OFTEN = 0.4, 3
"""CPU time of a tick that is too long, s, as commands wait for it; and after how many such ticks a
preview rather stands."""
LOOKS = 100
"""Times that the curves are measured on the way to where the preview is."""


def is_quick(run: FlockRun) -> bool:
    """Whether a run may be quick enough in plain Python to be watched."""
    return sum(len(one.flock.ids) for one in run.both) <= MOST_AGENTS


class Preview:
    """What a preview leaves to the compiled run, which repeats it from tick 0 and takes over."""

    def __init__(self, coming: FlockRun):
        self.coming = coming
        """The compiled run, at tick 0."""
        self.changes: list[tuple[int, Callable[[FlockRun], None]]] = []
        """What was changed on the way, and at which tick."""
        self.slow = 0
        """Ticks that have taken too long, one after the other."""

    @property
    def stands(self) -> bool:
        """Whether it is too slow to go on."""
        return self.slow >= OFTEN

    def took(self, seconds: float) -> None:
        """Note what a tick has taken, s of CPU."""
        self.slow = self.slow + 1 if seconds > SLOWEST else 0

    def taken_over(self, shown: FlockRun) -> FlockRun:
        """The compiled run, brought to where the preview is."""
        last = shown.flock.tick
        for tick, change in self.changes:
            self.go_on(tick, last)
            with suppress(InputError):  # as far as rounding makes it another run
                self.coming.change(change)
        self.go_on(last, last)
        for one, before in zip(self.coming.both, shown.both, strict=True):
            one.camera.fastest = before.camera.fastest
        return self.coming

    def go_on(self, until: int, last: int) -> None:
        """Run on to a tick, and look at the curves a few times on the way to the `last`."""
        flock = self.coming.flock
        while flock.tick < until:
            self.coming.advance(min(until - flock.tick, 1 + last // LOOKS))
            for one in self.coming.both:
                one.attempt(one.readings.look)
