"""Builds the flocks and the runs that a simulation is to run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from agents.flock import Flock
from agents.snapshot import Snapshot
from agents.spec import Spec
from app.viewer.editing.free_places import move_out
from app.viewer.measuring.time_series import refuse_too_dense
from app.viewer.run.flock_run import FlockRun
from app.viewer.run.frame_builder import FrameRequest
from app.viewer.run.paired_run import PairedRun
from app.viewer.run.stored_flock import InitialState, StoredFlock
from worlds.input_error import InputError
from worlds.world import World

# A recording that is played: its flock is put where it was, and looked at as any other.


class Playback(FlockRun):
    """The run of a recording. Nothing in it can be changed; ticks that are not recorded are left
    out, and the flock stays as it was last recorded meanwhile."""

    def __init__(
        self,
        flock: Flock,
        number: int,
        request: FrameRequest,
        watched: frozenset[str],
        stored: StoredFlock,
    ):
        super().__init__(flock, number, request, watched)
        self.stored = stored
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


def restore_snapshot(flock: Flock, then: Snapshot) -> None:
    """Have a flock be as in a snapshot of its run; its engine is kept where it can be."""
    if [array.shape for array in flock.arrays] != [array.shape for array in then.arrays]:
        flock.return_to(then)
        return
    for mine, other in zip(flock.arrays, then.arrays, strict=True):
        mine[...] = other
    flock.tick = then.tick


def recording_error(stored: StoredFlock) -> InputError:
    """What is told to those who would change a recording."""
    return InputError(
        f"{stored.name} is a recording, in which nothing can be changed: "
        "'Go on from here' makes it a live run, Setup begins a new one"
    )


class FlockRunBuilder:
    """Builds by `build`, and what is beside it by `build_beside`."""

    def __init__(self, build: Callable[..., Flock], build_beside: Callable[[Flock, Spec], Flock]):
        self.build = build
        self.build_beside = build_beside

    def flock(self, spec: Spec, stored: InitialState | None, **more: Any) -> Flock:
        """The flock of a run, where it begins: with the spec's parameters and world, also if it is
        gone on from a state. Raises InputError.
        """
        if stored is None:
            return self.build(spec, **more)
        flock = stored.flock(self.build, **more)
        if stored.is_played:
            return flock
        if isinstance(spec.world, World) and spec.world != flock.world:
            flock.change_world(spec.world)
            flock.position[:] = move_out(spec.world, flock.position)
        if flock.parameters.model_dump() != spec.parameters:
            flock.set(**spec.parameters)
        return flock

    def run(
        self,
        flock: Flock,
        beside: Spec | None,
        stored: InitialState | None,
        number: int,
        request: FrameRequest,
        watched: frozenset[str],
    ) -> FlockRun:
        """The run of a flock, and of the one beside it; of a recording that it is played.

        Raises InputError.
        """
        if isinstance(stored, StoredFlock) and stored.is_played:
            return Playback(flock, number, request, watched, stored)
        if beside is None:
            return FlockRun(flock, number, request, watched)
        second = self.build_beside(flock, beside)
        refuse_too_dense(second)
        return PairedRun(flock, second, number, request, watched)
