"""Builds the flocks and the runs that a simulation is to run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from agents.flock import Flock
from agents.kinds import kind_table
from agents.spec import Spec
from app.viewer.editing.free_places import move_out
from app.viewer.measuring.time_series import refuse_too_dense
from app.viewer.run.flock_run import FlockRun
from app.viewer.run.frame_builder import FrameRequest
from app.viewer.run.paired_run import PairedRun
from app.viewer.run.playback import Playback
from app.viewer.run.stored_flock import InitialState
from app.viewer.run.stored_tracks import StoredTracks
from app.viewer.run.tracks_run import ModelBesideTracks, TracksRun
from worlds.world import World


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
        now, then = flock.all_parameters, stored.spec.all_parameters
        # What is as it was stored stays: of numbers by hand the state has later ones than its spec.
        changed = {
            name: value
            for name, value in spec.all_parameters.items()
            if now.get(name) != value and then.get(name) != value
        }
        if changed:
            flock.set(**changed)
        kinds = kind_table(spec.kinds, spec.to)
        if kinds != kind_table(stored.spec.kinds, stored.spec.to):
            flock.change_kinds(kinds)
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
        if isinstance(stored, StoredTracks):
            if stored.start is None or beside is None:
                return TracksRun(flock, number, request, watched, stored)
            model = replace(stored, start=replace(stored.start, spec=beside)).model_flock()
            return ModelBesideTracks(flock, model, number, request, watched, stored)
        if stored is not None and stored.is_played:
            return Playback(flock, number, request, watched, stored)
        if beside is None:
            return FlockRun(flock, number, request, watched)
        second = self.build_beside(flock, beside)
        refuse_too_dense(second)
        return PairedRun(flock, second, number, request, watched)
