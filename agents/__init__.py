"""The flock: rules, bodies, the engine that runs them and what is measured of them.

`Flock` and `Member` are imported when they are asked for: a spec needs no compiler.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from agents.flock import Flock as Flock
    from agents.member import Member as Member

__all__ = ["Flock", "Member"]


def __getattr__(name: str) -> Any:
    if name in __all__:
        return getattr(import_module(f"{__name__}.{name.lower()}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
