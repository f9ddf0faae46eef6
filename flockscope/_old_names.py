"""Names of before 0.1.0, which scripts and plug-ins may still use."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any


def old_names(module: ModuleType, names: Mapping[str, str]) -> Callable[[str], Any]:
    """A module's `__getattr__` that gives what an old name stands for, with a warning."""

    def look_up(name: str) -> Any:
        if name not in names:
            raise AttributeError(f"module {module.__name__!r} has no attribute {name!r}")
        warnings.warn(
            f"{module.__name__}.{name} is called {names[name]} now", FutureWarning, stacklevel=2
        )
        return getattr(module, names[name])

    return look_up
