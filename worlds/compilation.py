"""Compile the functions of rules, bodies and engine with numba, or run them as plain Python.

Sums may be reordered, so that a loop over a neighbourhood block becomes vector instructions; NaN
and infinity keep their meaning, so that a bad number can be found and named. Compiled code counts
no references and so allocates nothing: what it needs it is given.

Within `plain_python()`, and everywhere under NUMBA_DISABLE_JIT=1, the same functions run as the
Python that they are written in.
"""

from __future__ import annotations

import functools
import gc
import platform
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from pathlib import Path
from typing import Any

import llvmlite.binding
import numba
import numpy as np
from filelock import FileLock
from numba.core import types
from numba.core.registry import CPUDispatcher

from worlds.code_libraries import IR, LEVELS, LOOPS, PARTS
from worlds.deferred_module import defer

# numba only looks whether it is there, for products of matrices in compiled code.
defer("scipy.linalg.cython_blas")

OPTIONS: dict[str, Any] = {
    "nopython": True,
    "nogil": True,
    "fastmath": {"reassoc", "nsz", "contract", "arcp"},
    "error_model": "numpy",
    "_nrt": False,
    "no_cfunc_wrapper": True,
}
INLINED = OPTIONS | {"forceinline": True, "no_cpython_wrapper": True}
DISABLED = bool(vars(numba.config)["DISABLE_JIT"])
"""Whether all code runs as plain Python: NUMBA_DISABLE_JIT=1."""
PLAIN: ContextVar[bool] = ContextVar("plain", default=DISABLED)


V3 = ("avx2", "bmi", "bmi2", "cx16", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sse4.2")
V4 = (*V3, "avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl")
"""What a CPU of either level of x86-64 has, by LLVM's names."""


@functools.cache
def levels_here() -> tuple[str, ...]:
    """The levels that this CPU can run, the highest first; none where it is another kind."""
    if platform.machine() not in ("x86_64", "AMD64"):
        return ()
    features = llvmlite.binding.get_host_cpu_features()
    return tuple(
        level
        for level, needs in zip(LEVELS, (V4, V3), strict=True)
        if all(features.get(need) for need in needs)
    )


def choose_target() -> None:
    """Compile for a level of x86-64 rather than for this very CPU, so that kernels fit others too.

    Both levels give the same bits (`code_libraries.optimise`); the host's own CPU may give others,
    and was no faster. It holds for the whole process: what others compile in it with numba is made
    for the level too. numba's variables NUMBA_CPU_NAME and NUMBA_CPU_FEATURES choose another
    target.
    """
    levels = levels_here()
    if levels and vars(numba.config)["CPU_NAME"] is None:
        vars(numba.config).update(CPU_NAME=levels[0], CPU_FEATURES="")


choose_target()


@contextmanager
def plain_python(enabled: bool = True) -> Iterator[None]:
    """Within it, if asked for, compiled functions that this thread calls run as plain Python.

    As compiled, they divide by zero and wrap whole numbers around without a warning.
    """
    if not (enabled or PLAIN.get()):
        yield
        return
    token = PLAIN.set(True)
    try:
        with np.errstate(all="ignore"):
            yield
    finally:
        PLAIN.reset(token)


@contextmanager
def pause_collection() -> Iterator[None]:
    """Within it no garbage is collected: numba makes little, and looking for it takes a tenth."""
    if not gc.isenabled():  # a call around this one, or the user's program, has switched it off
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


class LoopDispatcher(CPUDispatcher):
    """A compiled function that Python calls."""

    lock: Path | None = None
    """Where it is kept on disk: the file that one process at a time holds while it compiles it."""

    def __call__(self, *args: Any) -> Any:
        """Run it, as plain Python where that is asked for."""
        return self.py_func(*args) if PLAIN.get() else super().__call__(*args)

    def compile(self, sig: Any) -> Any:
        """Compile it, or take what another process has compiled and kept meanwhile."""
        # The file's lock comes before numba's own, which super() takes: while this thread waits for
        # another process, the other threads of this one can compile.
        with pause_collection(), nullcontext() if self.lock is None else FileLock(self.lock):
            return super().compile(sig)


class PartDispatcher(LoopDispatcher):
    """A function that compiled functions call, and Python only now and then.

    Most of the time that numba takes for a small function goes into what lets Python call it. A
    loop is made of a hundred such functions, so they are compiled without; one that Python does
    call is compiled once more for it.
    """

    def add_overload(self, cres: Any) -> None:
        """Keep what was compiled out of the table that Python's calls go by."""
        self.overloads[tuple(cres.signature.args)] = cres

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Compile it for a call; an exception says in `uncompiled` what it is of."""
        plain = [types.unliteral(argument) for argument in args]  # one version for all numbers
        try:
            return super().get_call_template(plain, kws)
        except Exception as error:
            if not hasattr(error, "uncompiled"):
                error.uncompiled = self.py_func  # type: ignore[attr-defined]
            raise

    def _compile_for_args(self, *_args: Any, **_options: Any) -> Callable:
        return self.for_python

    @functools.cached_property
    def for_python(self) -> Callable:
        """The same function, as Python can call it."""
        return entry_of_part(self.py_func)


def compiled(function: Callable, takes_text: bool = False) -> Any:
    """Compile a rule, a body or a part of the engine; it becomes part of the loop that calls it.

    One that `takes_text`, as `getattr` takes a name, is only compiled if it may count references;
    of a name that is known while it is compiled nothing is left in the code.

    Such a function is never cached by itself: the loop is, under a name made from everything it
    reaches (see `agents.engine.cache`).
    """
    options = INLINED | {"_nrt": takes_text}
    return PartDispatcher(function, targetoptions=options, pipeline_class=PARTS)


def entry(function: Callable) -> Any:
    """Compile a loop, which Python calls."""
    return LoopDispatcher(function, targetoptions=OPTIONS, pipeline_class=LOOPS)


def ir_dispatcher(function: Callable, takes_text: bool = False) -> Any:
    """Compiles a function no further than to LLVM code: see `code_libraries.IrReady`."""
    options = OPTIONS | {"_nrt": takes_text}
    return LoopDispatcher(function, targetoptions=options, pipeline_class=IR)


entry_of_part: Callable[[Callable], Any] = entry
"""Compiles a part that Python calls; `agents.engine.cache` has it kept on disk as well."""


def shared(function: Callable) -> Any:
    """Compile a long part of the engine that is seldom called: it stays a function of its own."""
    return PartDispatcher(
        function,
        targetoptions=OPTIONS | {"no_cpython_wrapper": True},
        pipeline_class=PARTS,
    )
