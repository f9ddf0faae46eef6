"""The flock: rules, bodies, the engine that runs them and what is measured of them.

`Flock` and `Member` are imported when they are asked for: a spec needs no compiler.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from agents.flock import Flock as Flock
    from agents.mesa_interface import Member as Member

__all__ = ["Flock", "Member"]

HOMES = {"Flock": "flock", "Member": "mesa_interface"}
"""The module of each name."""


def __getattr__(name: str) -> Any:
    if name in HOMES:
        return getattr(import_module(f"{__name__}.{HOMES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
