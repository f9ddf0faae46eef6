"""How every compiled function of flockscope is compiled.

Sums may be reordered, so that a loop over a neighbourhood block becomes vector instructions; NaN
and infinity keep their meaning, so that a bad number can be found and named. Compiled code counts
no references and so allocates nothing: what it needs it is given.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numba
from numba.core.registry import CPUDispatcher

OPTIONS: dict[str, Any] = {
    "nogil": True,
    "fastmath": {"reassoc", "nsz", "contract", "arcp"},
    "error_model": "numpy",
    "_nrt": False,
    "no_cfunc_wrapper": True,
}
INLINED = OPTIONS | {"forceinline": True, "no_cpython_wrapper": True}


class Part(CPUDispatcher):
    """A function that compiled functions call, and Python only now and then.

    Most of the time that numba takes for a small function goes into what lets Python call it. A
    loop is made of a hundred such functions, so they are compiled without; one that Python does
    call is compiled once more for it.
    """

    def add_overload(self, cres: Any) -> None:
        """Keep what was compiled out of the table that Python's calls go by."""
        self.overloads[tuple(cres.signature.args)] = cres

    def _compile_for_args(self, *_args: Any, **_options: Any) -> Callable:
        return self.for_python

    @functools.cached_property
    def for_python(self) -> Callable:
        """The same function, as Python can call it."""
        return entry(self.py_func)


def compiled(function: Callable) -> Any:
    """Compile a rule, a body or a part of the engine; it becomes part of the loop that calls it.

    Such a function is never cached by itself: the loop is, under a name made from everything it
    reaches (see `agents.engine.cache`).
    """
    return Part(function, targetoptions=INLINED)


def entry(function: Callable) -> Any:
    """Compile a loop, which Python calls."""
    return numba.njit(**OPTIONS)(function)


def shared(function: Callable) -> Any:
    """Compile a long part of the engine that is seldom called: it stays a function of its own."""
    return Part(function, targetoptions=OPTIONS | {"no_cpython_wrapper": True})
