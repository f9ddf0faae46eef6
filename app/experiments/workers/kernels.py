"""Compiling a model's loop before it is needed, with word of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from agents import Flock


def compile_loop(flock: Flock, tell: Callable[[str], Any] | None) -> None:
    """Compile the loop of a flock, or load it from the cache; the flock stays as it is."""
    from agents import Flock

    if flock.interpret:
        return
    if tell and not flock.is_compiled:
        tell(f"compiling {flock.model.name} (only its first start takes these seconds) ...")
    alone = {"agents": 1, "informed": None, "spacing": None, "seed": 0, "start": "random"}
    twin = Flock(flock.options.but(world=flock.world, **alone))
    twin.run(1)
    twin.stray()
