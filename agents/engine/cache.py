"""A cache of compiled kernels on disk that is never stale.

numba does not notice an edit of a function that a kernel calls. So each kernel gets a cache folder
named by a hash over the bytecode of every function that it reaches and the value of every constant.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import os
import sys
import threading
import types
from pathlib import Path

import numba
import numpy as np
import platformdirs
from numba.core.dispatcher import Dispatcher

from worlds.compiled import entry

KEEPING = threading.Lock()
IN_LLVM = ("flat.py", "lanes.py", "pairs/meeting.py", "pairs/sums.py")
"""Files of the engine that write LLVM's own words, which no function's bytecode shows."""


def cache_base() -> Path:
    """Folder of all compiled kernels; the environment variable FLOCKSCOPE_CACHE moves it."""
    return Path(os.environ.get("FLOCKSCOPE_CACHE") or platformdirs.user_cache_dir("flockscope"))


def describe(value: object) -> str:
    """A value in words that are the same in every process: sets have no order of their own."""
    if isinstance(value, set | frozenset):
        return repr(sorted(map(repr, value)))
    if isinstance(value, dict):
        return repr(sorted((describe(k), describe(v)) for k, v in value.items()))
    return repr(value)


def describe_code(code: types.CodeType) -> str:
    """What a code object does, without its place in a file."""
    constants = [
        describe_code(c) if isinstance(c, types.CodeType) else describe(c) for c in code.co_consts
    ]
    return repr((code.co_code, code.co_names, code.co_varnames, code.co_freevars, constants))


def fingerprint(function, digest, seen: set[int]) -> None:
    """Feed a function, and everything it reaches by global name or closure, to the digest."""
    if id(function) in seen:
        return
    seen.add(id(function))
    python = function.py_func if isinstance(function, Dispatcher) else function
    digest.update(describe_code(python.__code__).encode())
    digest.update(python.__module__.encode())  # a kept kernel imports it by this name
    if isinstance(function, Dispatcher):
        digest.update(describe(function.targetoptions).encode())
        compiler = function._compiler.pipeline_class  # type: ignore[attr-defined]
        digest.update(compiler.__qualname__.encode())
    for value in reached(python):
        if isinstance(value, Dispatcher | types.FunctionType):
            fingerprint(value, digest, seen)
        elif isinstance(value, type) and hasattr(value, "_fields"):
            digest.update(repr((value.__name__, value._fields)).encode())
        elif isinstance(value, np.ndarray):
            digest.update(value.tobytes())
        elif isinstance(value, bool | int | float | str | tuple | np.generic):
            digest.update(repr(value).encode())


def reached(python: types.FunctionType) -> list:
    """The values that a function reaches by global name, `module.name` or closure."""
    names = python.__code__.co_names
    values = [python.__globals__[n] for n in names if n in python.__globals__]
    modules = [value for value in values if isinstance(value, types.ModuleType)]
    inside = [vars(m)[n] for m in modules for n in names if n in vars(m)]
    return values + inside + [cell.cell_contents for cell in python.__closure__ or ()]


def new_digest():
    """A digest of what every kernel depends on."""
    versions = numba.__version__, importlib.metadata.version("llvmlite"), sys.version_info[:3]
    digest = hashlib.sha256(repr(versions).encode())
    for name in IN_LLVM:
        digest.update((Path(__file__).parent / name).read_bytes())
    return digest


def keep(entry, digest) -> Path:
    """Keep what `entry` compiles to in a folder named by the digest; returns the folder."""
    folder = cache_base() / "kernels" / digest.hexdigest()[:24]
    with KEEPING:
        setattr(numba.config, "CACHE_DIR", str(folder))  # noqa: B010 - made at run time
        entry.enable_caching()
    forget_if_unreadable(entry)
    entry.lock = folder / "lock"
    return folder


def is_kept(entry) -> bool:
    """Whether what `entry` compiles to is on disk, from this very checkout or installation."""
    return bool(entry._cache._cache_file._load_index())


def forget_if_unreadable(entry) -> None:
    """Forget kernels whose arguments are of classes that have moved since: compile them anew.

    A class that a kernel meets only in its arguments is not in the kernel's name.
    """
    kept = entry._cache._cache_file
    try:
        kept._load_index()
    except (ImportError, AttributeError):
        Path(kept._index_path).unlink(missing_ok=True)


def kept(function):
    """Compile a function that Python calls, kept on disk under a name made from what it does."""
    made = entry(function)
    digest = new_digest()
    fingerprint(made, digest, set())
    keep(made, digest)
    return made
