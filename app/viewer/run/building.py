"""Builds the flocks and the runs that a simulation is to run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from agents.flock import Flock
from agents.spec import Spec
from app.viewer.editing.free_places import set_free
from app.viewer.measuring.crowd import refuse_too_dense
from app.viewer.run.beside import Pair
from app.viewer.run.past.playback import Playback
from app.viewer.run.past.stored import Beginning, Stored
from app.viewer.run.picture import Wanted
from app.viewer.run.run import Run
from worlds.world import World


class Building:
    """Builds by `build`, and what is beside it by `build_beside`."""

    def __init__(self, build: Callable[..., Flock], build_beside: Callable[[Flock, Spec], Flock]):
        self.build = build
        self.build_beside = build_beside

    def flock(self, spec: Spec, stored: Beginning | None, **more: Any) -> Flock:
        """The flock of a run, where it begins: with the spec's parameters and world, also if it is
        gone on from a state. Raises Refusal.
        """
        if stored is None:
            return self.build(spec, **more)
        flock = stored.flock(self.build, **more)
        if stored.is_played:
            return flock
        if isinstance(spec.world, World) and spec.world != flock.world:
            flock.change_world(spec.world)
            flock.position[:] = set_free(spec.world, flock.position)
        if flock.parameters.model_dump() != spec.parameters:
            flock.set(**spec.parameters)
        return flock

    def run(
        self,
        flock: Flock,
        beside: Spec | None,
        stored: Beginning | None,
        number: int,
        wanted: Wanted,
        watched: frozenset[str],
    ) -> Run:
        """The run of a flock, and of the one beside it; of a recording that it is played.

        Raises Refusal.
        """
        if isinstance(stored, Stored) and stored.is_played:
            return Playback(flock, number, wanted, watched, stored)
        if beside is None:
            return Run(flock, number, wanted, watched)
        second = self.build_beside(flock, beside)
        refuse_too_dense(second)
        return Pair(flock, second, number, wanted, watched)
