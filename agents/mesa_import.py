"""Import Mesa in half the time, from outside: what it does not need yet is put off.

Mesa imports pandas for its tables and networkx for its graphs, which a flock never asks for, and
has `inspect` look through all modules for the one that calls it.
"""

from __future__ import annotations

import importlib
import inspect
import sys
import types
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any


class DeferredModule(types.ModuleType):
    """A module that is imported when something of it is first asked for.

    Python's own LazyLoader loads it as soon as a second module imports it. `functions` are names
    that somebody takes without calling them: they are imported when they are called.
    """

    def __init__(self, name: str, *functions: str):
        super().__init__(name)
        for function in functions:
            setattr(self, function, partial(self._call, function))

    def _call(self, function: str, *args: Any, **options: Any) -> Any:
        """What the module's own function returns."""
        return self.__getattr__(function)(*args, **options)

    def __getattr__(self, name: str) -> Any:
        """A name of the module itself, which takes this one's place among the modules."""
        if sys.modules.get(self.__name__) is self:
            del sys.modules[self.__name__]
        return getattr(importlib.import_module(self.__name__), name)


@contextmanager
def quick_import() -> Iterator[None]:
    """Within it both are put off, and a frame's module is found by the name that it bears."""
    sys.modules.setdefault("pandas", DeferredModule("pandas"))
    # Mesa takes this one as the default of a network's layout.
    sys.modules.setdefault("networkx", DeferredModule("networkx", "spring_layout"))
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
