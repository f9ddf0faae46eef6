"""Compiling a model's loop before it is needed, with word of it."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from agents.individuals import uniform

if TYPE_CHECKING:
    from agents import Flock
    from agents.spec import Spec


def compile_loop(flock: Flock, tell: Callable[[str], Any] | None) -> None:
    """Compile the loop of a flock, or load it from the cache; the flock stays as it is."""
    if flock.interpret:
        return
    if tell and not flock.is_compiled:
        tell(f"compiling {flock.model.name} (only its first start takes these seconds) ...")
    flock.compile_tick()


def single_agent_spec(flock: Flock) -> Spec:
    """The run of one agent that takes the same kernels."""
    options = {"agents": 1, "informed": None, "spacing": None, "seed": 0, "start": "random"}
    # What is drawn is no matter, but that agents have their own makes another kernel.
    shared = flock.parameters.model_dump()
    own = {name: uniform(shared[name], shared[name]) for name in flock.individuals}
    alone = flock.options.but(world=flock.world, individuals={}, **options)
    return alone.with_parameters(shared | own)


def compile_measures(flock: Flock) -> None:
    """Compile all that can be measured of a flock."""
    from agents.observables.catalogue import OBSERVABLES

    with warnings.catch_warnings(action="ignore"):
        for observable in OBSERVABLES.values():
            if observable.over is None and observable.applies(flock):
                flock.observe(observable.name)
