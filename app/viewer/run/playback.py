"""A recording that is played: its flock is put where it was, and looked at as any other."""

from __future__ import annotations

from typing import Any

import numpy as np

from agents.flock import Flock
from agents.snapshot import Snapshot
from app.viewer.run.flock_run import FlockRun
from app.viewer.run.frame_builder import FrameRequest
from worlds.input_error import InputError


class Playback(FlockRun):
    """The run of a recording. Nothing in it can be changed; ticks that are not recorded are left
    out, and the flock stays as it was last recorded meanwhile."""

    def __init__(
        self,
        flock: Flock,
        number: int,
        request: FrameRequest,
        watched: frozenset[str],
        stored: Any,
    ):
        super().__init__(flock, number, request, watched)
        self.stored = stored
        """What is played: a `StoredFlock` or `StoredTracks`."""
        self.frames = stored.recording.frames
        self.clock = self.first
        """Which tick it is, recorded or not."""
        self.readings.extremes.keeps = False
        self.compiled = True

    @property
    def first(self) -> int:
        """The first recorded tick."""
        return int(self.frames.ticks[0])

    @property
    def last(self) -> int:
        """The last recorded tick."""
        return int(self.frames.ticks[-1])

    @property
    def is_over(self) -> bool:
        """Whether it has been played to its end."""
        return self.clock >= self.last

    @property
    def is_ready(self) -> bool:
        """Nothing is run, and so nothing is waited for."""
        return True

    @property
    def computed(self) -> tuple[FlockRun, ...]:
        """Nobody: nothing is computed."""
        return ()

    def advance(self, ticks: int) -> None:
        """Play on for so many ticks, at most to the end. Raises InputError for a damaged file."""
        self.show(min(self.clock + ticks, self.last))

    def step(self, frames: int) -> None:
        """Go on by so many of the recorded ticks, at most to the end. Raises InputError."""
        index = int(np.searchsorted(self.frames.ticks, self.flock.tick))
        self.show(int(self.frames.ticks[min(index + frames, len(self.frames.ticks) - 1)]))

    def seek(self, tick: int) -> None:
        """Go to a tick; curves go on from there. Raises InputError."""
        self.show(min(max(tick, self.first), self.last))
        self.readings.cut(self.flock.tick)

    def show(self, tick: int) -> None:
        """Put the flock where it was at a tick, or last before it. Raises InputError."""
        then = self.frames.last_tick_until(tick)
        if then != self.flock.tick:
            restore_snapshot(self.flock, self.frames.at(then))
        self.clock = tick

    def demand_change(self, name: str = "", beside: bool = False) -> None:  # noqa: ARG002
        """Raise InputError for a change of a parameter, or of anything if no name is given."""
        raise InputError(
            f"{self.stored.name} is a recording, in which nothing can be changed: "
            "'Go on from here' makes it a live run, Setup begins a new one"
        )

    def state_to_go_on(self) -> Any:
        """What a live run goes on from at this tick. Raises InputError."""
        return self.stored.going_on(self.flock.tick)


def restore_snapshot(flock: Flock, then: Snapshot) -> None:
    """Have a flock be as in a snapshot of its run; its engine is kept where it can be."""
    if [array.shape for array in flock.arrays] != [array.shape for array in then.arrays]:
        flock.return_to(then)
        return
    for mine, other in zip(flock.arrays, then.arrays, strict=True):
        mine[...] = other
    flock.catches = then.catches
    flock.tick = then.tick
