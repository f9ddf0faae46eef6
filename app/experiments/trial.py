"""One run of an experiment: a flock until it is consistent."""

from __future__ import annotations

import hashlib
import json
import threading
import time
from dataclasses import dataclass
from typing import Any

from agents import Flock
from agents.spec import versions
from app.experiments.experiment import Cell, Settings


@dataclass(frozen=True)
class Trial:
    """What makes a run: its cell and its seed."""

    cell: Cell
    seed: int


@dataclass(frozen=True)
class Result:
    """What a run has given."""

    convergence_time: int | None
    """k_con; None if the run was given up."""
    seconds: float


class Stopped(Exception):
    """The run was asked to stop."""


def flock_of(cell: Cell, settings: Settings, seed: int) -> Flock:
    """The flock of a cell at tick 0. Raises Refusal."""
    parameters: dict[str, Any] = dict(cell.parameters)
    return Flock(
        cell.model,
        agents=cell.agents,
        size=cell.size,
        world=settings.world,
        rng=seed,
        **parameters,
    )


def run_trial(trial: Trial, settings: Settings, stop: threading.Event) -> Result:
    """Run a flock until it is consistent or given up. Raises Stopped."""
    begun = time.perf_counter()
    flock = flock_of(trial.cell, settings, trial.seed)

    def go_on() -> None:
        if stop.is_set():
            raise Stopped

    k = flock.run_until_consistent(settings.limit, settings.desired, settings.hold, between=go_on)
    return Result(k, time.perf_counter() - begun)


def fingerprint(cell: Cell, settings: Settings) -> str:
    """A hash of what a cell's numbers depend on beside model, agents, parameters and seed.

    The world and the criterion, the versions, the compiled loop with all that it reaches, and how
    a flock starts.
    """
    flock = flock_of(cell, settings, 0)
    shared = settings.model_dump(exclude={"parameters"}) | {"size": cell.size}
    digest = hashlib.sha256(json.dumps([shared, versions()], sort_keys=True).encode())
    digest.update(flock.loop.cache_folder.name.encode())
    digest.update(flock.position.tobytes())
    digest.update(flock.heading.tobytes())
    return digest.hexdigest()[:12]
