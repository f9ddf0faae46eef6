"""Modules that others import and do not need yet: imported when something of them is asked for."""

from __future__ import annotations

import importlib
import importlib.abc
import importlib.util
import sys
import threading
import types
from functools import partial
from importlib.machinery import ModuleSpec
from typing import Any

REPLACING = threading.Lock()
"""Held while placeholders are taken from among the modules."""


def defer(name: str, *functions: str) -> None:
    """Put off importing a module, unless it has been imported.

    `functions` are names that somebody takes without calling them: the module is imported when
    they are called.
    """
    if DeferredParents not in sys.meta_path:
        sys.meta_path.insert(0, DeferredParents)
    sys.modules.setdefault(name, DeferredModule(name, *functions))


class DeferredModule(types.ModuleType):
    """A module that is imported when something of it is first asked for.

    Python's own LazyLoader loads it as soon as a second module imports it.
    """

    def __init__(self, name: str, *functions: str):
        super().__init__(name)
        self.__path__: list[str] = []  # `from ... import` looks for it before any name
        for function in functions:
            setattr(self, function, partial(self._call, function))

    def _call(self, function: str, *args: Any, **options: Any) -> Any:
        """What the module's own function returns."""
        return getattr(self.load(), function)(*args, **options)

    def __getattr__(self, name: str) -> Any:
        """A name of the module itself."""
        return getattr(self.load(), name)

    def load(self) -> types.ModuleType:
        """The module itself, which takes this one's place among the modules.

        So do the others of its package, which may import each other.
        """
        package = self.__name__.partition(".")[0]
        # Threads ask at once. Whoever comes second must neither miss a placeholder nor take away
        # the module that has come in its place. Python's own lock is for the import below: to wait
        # for it with this one in hand could wait for ever.
        with REPLACING:
            for key, module in tuple(sys.modules.items()):
                if key.partition(".")[0] == package and isinstance(module, DeferredModule):
                    del sys.modules[key]
        return importlib.import_module(self.__name__)


class DeferredParents:
    """Finds modules of a package that is put off: the package is imported first."""

    @staticmethod
    def find_spec(name: str, _path: Any = None, _target: Any = None) -> ModuleSpec | None:
        """Where a module is, once its package is there; that may have imported it by then."""
        parent = sys.modules.get(name.rpartition(".")[0])
        if not isinstance(parent, DeferredModule):
            return None
        parent.load()
        if name in sys.modules:
            return ModuleSpec(name, AlreadyLoaded())
        return importlib.util.find_spec(name)


class AlreadyLoaded(importlib.abc.Loader):
    """Loads a module that is there, and leaves it as it is."""

    def create_module(self, spec: ModuleSpec) -> types.ModuleType:
        module = sys.modules[spec.name]
        self.spec = module.__spec__
        return module

    def exec_module(self, module: types.ModuleType) -> None:
        module.__spec__ = self.spec
