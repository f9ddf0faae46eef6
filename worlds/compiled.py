"""How every compiled function of flockscope is compiled.

Sums may be reordered, so that a loop over a neighbourhood block becomes vector instructions; NaN
and infinity keep their meaning, so that a bad number can be found and named. Compiled code counts
no references and so allocates nothing: what it needs it is given.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba

OPTIONS: dict[str, Any] = {
    "nogil": True,
    "fastmath": {"reassoc", "nsz", "contract", "arcp"},
    "error_model": "numpy",
    "_nrt": False,
}


def compiled(function: Callable) -> Any:
    """Compile a rule, a body or a part of the engine; it becomes part of the loop that calls it.

    Such a function is never cached by itself: the loop is, under a name made from everything it
    reaches (see `agents.engine.cache`).
    """
    return numba.njit(**OPTIONS, forceinline=True)(function)


def entry(function: Callable) -> Any:
    """Compile a loop, which Python calls."""
    return numba.njit(**OPTIONS)(function)
