"""Keep compiled kernels on disk, under names made from their code, so that none is ever stale.

numba does not notice an edit of a function that a kernel calls. So each kernel gets a cache folder
named by a hash over the bytecode of every function that it reaches and the value of every constant.
What cannot be written is done without; what is damaged is compiled anew; what others own or may
write to is neither read nor written (`worlds.owned_files`), since whoever wrote a kernel has its
reader execute it. Each is told once.
"""

from __future__ import annotations

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
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    UserProvidedCacheLocator,
)
from numba.core.dispatcher import Dispatcher

from worlds import compilation
from worlds.compilation import entry
from worlds.owned_files import NotOwned, open_in, owned_folder, read_owned, write_owned

KEEPING = threading.Lock()
IN_LLVM = ("flat.py", "vector_lanes.py", "pairs/thread_barrier.py", "pairs/term_sums.py")
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


def fingerprint(function, digest, visited: set[int]) -> None:
    """Feed a function, and everything it reaches by global name or closure, to the digest."""
    if id(function) in visited:
        return
    visited.add(id(function))
    python = function.py_func if isinstance(function, Dispatcher) else function
    digest.update(describe_code(python.__code__).encode())
    digest.update(python.__module__.encode())  # a kept kernel imports it by this name
    if isinstance(function, Dispatcher):
        digest.update(describe(function.targetoptions).encode())
        compiler = function._compiler.pipeline_class  # type: ignore[attr-defined]
        digest.update(compiler.__qualname__.encode())
    for value in global_values(python):
        if isinstance(value, Dispatcher | types.FunctionType):
            fingerprint(value, digest, visited)
        elif isinstance(value, type) and hasattr(value, "_fields"):
            digest.update(repr((value.__name__, value._fields)).encode())
        elif isinstance(value, np.ndarray):
            digest.update(value.tobytes())
        elif isinstance(value, bool | int | float | str | tuple | np.generic):
            digest.update(repr(value).encode())


def global_values(python: types.FunctionType) -> list:
    """The values that a function reaches by global name, `module.name` or closure."""
    names = python.__code__.co_names
    values = [python.__globals__[n] for n in names if n in python.__globals__]
    modules = [value for value in values if isinstance(value, types.ModuleType)]
    inside = [vars(m)[n] for m in modules for n in names if n in vars(m)]
    return values + inside + [cell.cell_contents for cell in python.__closure__ or ()]


def base_digest():
    """A digest of what every kernel depends on."""
    versions = numba.__version__, importlib.metadata.version("llvmlite"), sys.version_info[:3]
    digest = hashlib.sha256(repr((*versions, CHECKSUM)).encode())
    for name in IN_LLVM:
        digest.update((Path(__file__).parent / name).read_bytes())
    return digest


WARNED_OF: set[str] = set()
"""What the user has been warned of."""


def tell_once(message: str, about: str) -> None:
    """Tell the user something on stderr, the first time that it is about this."""
    if about not in WARNED_OF:
        WARNED_OF.add(about)
        print(f"flockscope: {message}", file=sys.stderr)


def read_checked(base: Path, *parts: str) -> bytes | None:
    """A file's content behind its checksum, None if there is none, or none that is sound."""
    try:
        content = read_owned(base, *parts)
    except NotOwned as error:
        tell_unused(error)
        return None
    except OSError:
        return None
    if hashlib.sha256(content[CHECKSUM:]).digest() == content[:CHECKSUM]:
        return content[CHECKSUM:]
    tell_once(f"compiled kernels in {base} are damaged: they are compiled anew", "damaged")
    return None


def write_checked(content: bytes, base: Path, *parts: str) -> None:
    """Write a file with its checksum. Raises OSError."""
    write_owned(hashlib.sha256(content).digest() + content, base, *parts)


class KernelFiles(IndexDataCacheFile):
    """The files of a kernel, each with a checksum; one that is damaged counts as not there."""

    def __init__(self, base: Path, folder: str, name: str, stamp: Any):
        super().__init__(folder, name, stamp)
        self.base = base
        self.parts = Path(folder).relative_to(base).parts

    def save(self, key: Any, data: Any) -> None:
        """Keep what was compiled for a key: first itself, then the index that names it."""
        names = self._load_index()
        used_names = set(names.values())
        name = names.get(key) or next(
            name for name in map(self._data_name, itertools.count(1)) if name not in used_names
        )
        self._save_data(name, data)
        self._save_index(names | {key: name})

    def is_intact(self) -> bool:
        """Whether anything is kept, all of it undamaged."""
        names = self._load_index().values()
        return bool(names) and all(self._read(name) is not None for name in names)

    def _load_index(self) -> dict:
        return unpickled(self._read(self._index_name)) or {}

    def _save_index(self, overloads: dict) -> None:
        self._write(self._index_name, overloads)

    def _load_data(self, name: str) -> Any:
        return unpickled(self._read(name))

    def _save_data(self, name: str, data: Any) -> None:
        self._write(name, data)

    def _read(self, name: str) -> bytes | None:
        """A file's content behind its checksum, None if there is none, or none that is sound."""
        return read_checked(self.base, *self.parts, name)

    def _write(self, name: str, value: Any) -> None:
        write_checked(self._dump(value), self.base, *self.parts, name)


def unpickled(content: bytes | None) -> Any:
    """What was pickled; None where a module or a class that it names has moved: compile anew."""
    # Unpickling runs code. Only `read_owned` brings content here: files of this user alone.
    try:
        return None if content is None else pickle.loads(content)
    except (ImportError, AttributeError):
        return None


class KernelLocator(UserProvidedCacheLocator):
    """Where the files of a kernel are; its folder is made with them."""

    def ensure_cache_path(self) -> None:
        """Leave it to who writes there to make it, for this user alone."""


NOWHERE_ELSE: list[Any] = [KernelLocator]


class KernelResults(CompileResultCacheImpl):
    """How numba keeps what it compiles, in no other place than ours."""

    _locator_classes = NOWHERE_ELSE


class KernelCache(FunctionCache):
    """numba's cache of one function over such files; without what cannot be written."""

    _impl_class = KernelResults
    _cache_file: KernelFiles

    def __init__(self, function: types.FunctionType, base: Path):
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = KernelFiles(base, self._cache_path, self._impl.filename_base, stamp)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled, if that can be."""
        try:
            super().save_overload(sig, data)
        except OSError as error:
            tell_unwritable(error)


def tell_unwritable(error: OSError) -> None:
    """Tell that kernels are not kept, and why."""
    if isinstance(error, NotOwned):
        tell_unused(error)
        return
    tell_once(
        f"compiled kernels cannot be kept in {cache_base()} ({error.strerror}): every start "
        "compiles anew",
        "unwritable",
    )


def tell_unused(error: NotOwned) -> None:
    """Tell that kernels are not read, because somebody else may have written them."""
    tell_once(
        f"compiled kernels in {cache_base()} are not used, since {error.strerror}: they are "
        "compiled anew; FLOCKSCOPE_CACHE names a folder that only you may write to",
        "not owned",
    )


def keep_on_disk(entry, digest) -> Path:
    """Keep what `entry` compiles to in a folder named by the digest; returns the folder."""
    base, parts = cache_base(), ("kernels", digest.hexdigest()[:24])
    folder = base.joinpath(*parts)
    lock = folder / "lock"
    try:
        with owned_folder(base, *parts, make=True) as folder_descriptor:
            os.close(open_in(folder_descriptor, lock, os.O_WRONLY | os.O_CREAT))
    except OSError as error:
        tell_unwritable(error)
        return folder
    # numba reads the folder from a setting of the whole process as it makes a cache, so two threads
    # would mix up their folders.
    with KEEPING:
        setattr(numba.config, "CACHE_DIR", str(folder))  # noqa: B010 - made at run time
        entry._cache = KernelCache(entry.py_func, base)
    entry.lock = lock
    return folder


def is_kept(entry) -> bool:
    """Whether what `entry` compiles to is on disk, from this very checkout or installation."""
    return isinstance(entry._cache, KernelCache) and entry._cache._cache_file.is_intact()


def is_at_hand(entry) -> bool:
    """Whether `entry` need not be compiled before it runs: it has been, or is on disk."""
    return bool(entry.signatures) or is_kept(entry)


def compile_to_disk(function):
    """Compile a function that Python calls, kept on disk under a name made from what it does."""
    compiled_function = entry(function)
    digest = base_digest()
    fingerprint(compiled_function, digest, set())
    keep_on_disk(compiled_function, digest)
    return compiled_function


def compile_part_to_disk(function):
    """The same for a part of a loop, which Python calls by itself: to inspect an agent, in tests.

    A function without a file, such as one that was typed, is compiled in every process.
    """
    return (
        compile_to_disk(function)
        if Path(function.__code__.co_filename).is_file()
        else entry(function)
    )


compilation.entry_of_part = compile_part_to_disk
