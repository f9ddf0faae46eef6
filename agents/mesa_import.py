"""Import Mesa in half the time, from outside: what it does not need yet is put off.

Mesa imports pandas for its tables, networkx for its graphs, SciPy for its grids and tqdm for its
batches, which a flock never asks for, and has `inspect` look through all modules for the one that
calls it.
"""

from __future__ import annotations

import inspect
import sys
import types
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from worlds.deferred_module import defer

DEFERRED = (
    ("pandas",),
    ("networkx", "spring_layout"),
    ("scipy.spatial", "KDTree"),
    ("scipy.spatial.distance", "cdist"),
    ("tqdm",),
    ("tqdm.auto", "tqdm"),
)
"""What is put off, and what Mesa takes of it when it is imported itself."""


@contextmanager
def quick_import() -> Iterator[None]:
    """Within it they are put off, and a frame's module is found by the name that it bears."""
    for name, *functions in DEFERRED:
        defer(name, *functions)
    search = inspect.getmodule

    def getmodule(object: Any, _filename: str | None = None) -> types.ModuleType | None:
        named = object.f_globals.get("__name__") if inspect.isframe(object) else None
        return sys.modules.get(named or "") or search(object, _filename)

    inspect.getmodule = getmodule
    try:
        yield
    finally:
        inspect.getmodule = search


with quick_import():
    import mesa as mesa
