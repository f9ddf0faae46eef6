"""A cache of compiled kernels on disk that is never stale.

numba does not notice an edit of a function that a kernel calls. So each kernel gets a cache folder
named by a hash over the bytecode of every function that it reaches and the value of every constant.
What cannot be written is done without; what is damaged is compiled anew. Either is told once.
"""

from __future__ import annotations

import functools
import hashlib
import importlib.metadata
import itertools
import os
import pickle
import sys
import threading
import types
from pathlib import Path
from typing import Any

import numba
import numpy as np
import platformdirs
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.dispatcher import Dispatcher

from worlds.compiled import entry

KEEPING = threading.Lock()
IN_LLVM = ("flat.py", "lanes.py", "pairs/meeting.py", "pairs/sums.py")
"""Files of the engine that write LLVM's own words, which no function's bytecode shows."""
CHECKSUM = hashlib.sha256().digest_size
"""Bytes at the head of every file: the checksum of the rest."""


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
    digest = hashlib.sha256(repr((*versions, CHECKSUM)).encode())
    for name in IN_LLVM:
        digest.update((Path(__file__).parent / name).read_bytes())
    return digest


@functools.cache
def tell_once(words: str) -> None:
    """Tell the user something, once, on stderr."""
    print(f"flockscope: {words}", file=sys.stderr)


class KernelFiles(IndexDataCacheFile):
    """The files of a kernel, each with a checksum; one that is damaged counts as not there."""

    def save(self, key: Any, data: Any) -> None:
        """Keep what was compiled for a key: first itself, then the index that names it."""
        names = self._load_index()
        taken = set(names.values())
        name = names.get(key) or next(
            name for name in map(self._data_name, itertools.count(1)) if name not in taken
        )
        self._save_data(name, data)
        self._save_index(names | {key: name})

    def whole(self) -> bool:
        """Whether anything is kept, all of it undamaged."""
        paths = [self._data_path(name) for name in self._load_index().values()]
        return bool(paths) and all(read(path) is not None for path in paths)

    def _load_index(self) -> dict:
        return unpickled(read(self._index_path)) or {}

    def _save_index(self, overloads: dict) -> None:
        self._write(self._index_path, overloads)

    def _load_data(self, name: str) -> Any:
        return unpickled(read(self._data_path(name)))

    def _save_data(self, name: str, data: Any) -> None:
        self._write(self._data_path(name), data)

    def _write(self, path: str, value: Any) -> None:
        content = self._dump(value)
        with self._open_for_write(path) as file:
            file.write(hashlib.sha256(content).digest() + content)


def read(path: str) -> bytes | None:
    """The content of a file behind its checksum, None if there is none, or none that is whole."""
    try:
        content = Path(path).read_bytes()
    except OSError:
        return None
    if hashlib.sha256(content[CHECKSUM:]).digest() == content[:CHECKSUM]:
        return content[CHECKSUM:]
    tell_once(f"compiled kernels in {cache_base()} are damaged: they are compiled anew")
    return None


def unpickled(content: bytes | None) -> Any:
    """What was pickled; None where a module or a class that it names has moved: compile anew."""
    try:
        return None if content is None else pickle.loads(content)
    except (ImportError, AttributeError):
        return None


class KernelCache(FunctionCache):
    """numba's cache of one function over such files; without what cannot be written."""

    _cache_file: KernelFiles

    def __init__(self, function: types.FunctionType):
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = KernelFiles(self._cache_path, self._impl.filename_base, stamp)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled, if that can be."""
        try:
            super().save_overload(sig, data)
        except OSError as error:
            tell_unwritable(error)


def tell_unwritable(error: OSError) -> None:
    """Tell that kernels are not kept."""
    tell_once(
        f"compiled kernels cannot be kept in {cache_base()} ({error.strerror}): every start "
        "compiles anew"
    )


def keep(entry, digest) -> Path:
    """Keep what `entry` compiles to in a folder named by the digest; returns the folder."""
    folder = cache_base() / "kernels" / digest.hexdigest()[:24]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "lock").touch()
    except OSError as error:
        tell_unwritable(error)
        return folder
    with KEEPING:
        setattr(numba.config, "CACHE_DIR", str(folder))  # noqa: B010 - made at run time
        entry._cache = KernelCache(entry.py_func)
    entry.lock = folder / "lock"
    return folder


def is_kept(entry) -> bool:
    """Whether what `entry` compiles to is on disk, from this very checkout or installation."""
    return isinstance(entry._cache, KernelCache) and entry._cache._cache_file.whole()


def is_at_hand(entry) -> bool:
    """Whether `entry` need not be compiled before it runs: it has been, or is on disk."""
    return bool(entry.signatures) or is_kept(entry)


def kept(function):
    """Compile a function that Python calls, kept on disk under a name made from what it does."""
    made = entry(function)
    digest = new_digest()
    fingerprint(made, digest, set())
    keep(made, digest)
    return made
