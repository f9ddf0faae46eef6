"""Keep compiled kernels on disk, under names made from their code, so that none is ever stale.

numba does not notice an edit of a function that a kernel calls, and finds a kernel by the path of
its file. So each kernel gets a cache folder named by a hash over the bytecode of every function
that it reaches and the value of every constant: another checkout, another environment of the same
Python and numba finds it too. A wheel may bring a folder of kernels beside the code.

What cannot be written is done without; what is damaged is compiled anew; what others own or may
write to is neither read nor written (`worlds.owned_files`), since whoever wrote a kernel has its
reader execute it. Each is told once.
"""

from __future__ import annotations

import functools
import hashlib
import importlib.metadata
import os
import pickle
import sys
import types
import zlib
from pathlib import Path
from typing import Any

import numba
import numpy as np
import platformdirs
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.dispatcher import Dispatcher
from numba.core.registry import cpu_target
from numba.core.serialize import dumps

from worlds import code_libraries, compilation
from worlds.compilation import entry, levels_here
from worlds.owned_files import NotOwned, open_in, owned_folder, read_owned, write_owned

SHIPPED = Path(__file__).parents[1]
"""Where a wheel brings its folder of kernels: beside the code, and as trustworthy."""
FOLDER, SUFFIX = "kernels", ".kernel"
FORMAT = "a checksum, then what numba keeps, machine code alone, compressed"
"""What a file holds: another format is another kernel."""
ZLIB_LEVEL = 6
IN_LLVM = (
    *("flat.py", "vector_lanes.py", "eight_others.py", "own_parameters.py"),
    *("pairs/thread_barrier.py", "pairs/term_sums.py"),
)
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
    versions = numba.__version__, importlib.metadata.version("llvmlite"), sys.version_info[:2]
    digest = hashlib.sha256(repr((*versions, FORMAT)).encode())
    for name in IN_LLVM:
        digest.update((Path(__file__).parent / name).read_bytes())
    digest.update(Path(str(code_libraries.__file__)).read_bytes())  # how loops are optimised
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
        return checked_content(read_owned(base, *parts), base)
    except NotOwned as error:
        tell_unused(error)
        return None
    except OSError:
        return None


def read_shipped(*parts: str) -> bytes | None:
    """The same of a file that the wheel brings: who installed the code has installed it too."""
    try:
        return checked_content(SHIPPED.joinpath(*parts).read_bytes(), SHIPPED)
    except OSError:
        return None


def checked_content(content: bytes, base: Path) -> bytes | None:
    """What stands behind its checksum, None where it is damaged."""
    if hashlib.sha256(content[CHECKSUM:]).digest() == content[:CHECKSUM]:
        return content[CHECKSUM:]
    tell_once(f"compiled kernels in {base} are damaged: they are compiled anew", "damaged")
    return None


def write_checked(content: bytes, base: Path, *parts: str) -> None:
    """Write a file with its checksum. Raises OSError."""
    write_owned(hashlib.sha256(content).digest() + content, base, *parts)


def unpickled(content: bytes | None) -> Any:
    """What was pickled; None where a module or a class that it names has moved: compile anew."""
    # Unpickling runs code. Only `read_owned` and the wheel bring content here.
    try:
        return None if content is None else pickle.loads(zlib.decompress(content))
    except (ImportError, AttributeError):
        return None


@functools.cache
def target_name() -> str:
    """What this process compiles for: the CPU, and a hash of its features and of the system."""
    system, cpu, features = cpu_target.target_context.codegen().magic_tuple()
    return f"{cpu}-{hashlib.sha256(f'{system} {features}'.encode()).hexdigest()[:8]}"


def runnable_targets() -> tuple[str, ...]:
    """The target of this process, then lower levels: theirs run here with the same bits."""
    cpu, _, system = target_name().rpartition("-")
    levels = levels_here()
    lower = levels[levels.index(cpu) + 1 :] if cpu in levels else ()
    return target_name(), *(f"{level}-{system}" for level in lower)


def signature_name(signature: Any) -> str:
    """The end of the name of a file: what a kernel's arguments are."""
    return hashlib.sha256(repr(signature).encode()).hexdigest()[:16] + SUFFIX


class KernelCache(_Cache):
    """Where numba finds what a function compiles to, and keeps it: a file for each signature.

    A kernel is found by its code and the CPU that it is made for, wherever the checkout stands.
    What the wheel brings is taken where this user has nothing of his own.
    """

    def __init__(self, base: Path, *parts: str):
        self.base = base
        self.parts = parts

    @property
    def cache_path(self) -> str:
        """The folder of the files."""
        return str(self.base.joinpath(*self.parts))

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """What was compiled for a signature, None if nothing sound is there."""
        target_context.refresh()
        payload = unpickled(self.read(signature_name(sig)))
        return None if payload is None else CompileResult._rebuild(target_context, *payload)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled for a signature, if that can be."""
        if data.library.has_dynamic_globals:  # an address, which another process cannot use
            return
        content = zlib.compress(dumps(data._reduce()), ZLIB_LEVEL)
        name = f"{target_name()}.{signature_name(sig)}"
        try:
            write_checked(content, self.base, *self.parts, name)
        except OSError as error:
            tell_unwritable(error)

    def read(self, signature: str) -> bytes | None:
        """A kernel's content, this user's or the wheel's; None if there is none that is sound."""
        own = read_checked(self.base, *self.parts, f"{target_name()}.{signature}")
        if own is not None:
            return own
        brought = (read_shipped(*self.parts, f"{one}.{signature}") for one in runnable_targets())
        return next((content for content in brought if content is not None), None)

    def is_intact(self) -> bool:
        """Whether anything is kept for this CPU, all of it undamaged."""
        own = self.base.joinpath(*self.parts).glob(f"{target_name()}.*{SUFFIX}")
        names = [*own, *self.shipped_files()]
        signatures = {path.name.partition(".")[2] for path in names}
        return bool(signatures) and all(self.read(one) is not None for one in signatures)

    def shipped_files(self) -> list[Path]:
        """What the wheel brings of this function that runs here."""
        folder = SHIPPED.joinpath(*self.parts)
        return [
            path for target in runnable_targets() for path in folder.glob(f"{target}.*{SUFFIX}")
        ]

    def enable(self) -> None:
        """Always."""

    def disable(self) -> None:
        """Never."""

    def flush(self) -> None:
        """Leave what is kept: it is right for as long as its name is."""


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
    base, parts = cache_base(), (FOLDER, digest.hexdigest()[:24])
    folder = base.joinpath(*parts)
    lock = folder / "lock"
    entry._cache = KernelCache(base, *parts)
    try:
        with owned_folder(base, *parts, make=True) as folder_descriptor:
            os.close(open_in(folder_descriptor, lock, os.O_WRONLY | os.O_CREAT))
    except OSError as error:
        tell_unwritable(error)
        return folder
    entry.lock = lock
    return folder


def is_kept(entry) -> bool:
    """Whether what `entry` compiles to is on disk, for this CPU."""
    return isinstance(entry._cache, KernelCache) and entry._cache.is_intact()


def count_kernels(base: Path) -> dict[str, tuple[int, int]]:
    """How many kernels are kept below a folder, and their bytes, by the target of each."""
    counts: dict[str, tuple[int, int]] = {}
    for path in sorted(base.glob(f"{FOLDER}/*/*{SUFFIX}")):
        target = path.name.partition(".")[0].rpartition("-")[0]
        number, size = counts.get(target, (0, 0))
        counts[target] = number + 1, size + path.stat().st_size
    return counts


def is_at_hand(entry) -> bool:
    """Whether `entry` need not be compiled before it runs: it has been, or is on disk."""
    return bool(entry.signatures) or is_kept(entry)


def compile_to_disk(function, in_llvm: Path | None = None):
    """Compile a function that Python calls, kept on disk under a name made from what it does.

    `in_llvm`: a file with LLVM's own words that it reaches, beside those of `IN_LLVM`.
    """
    compiled_function = entry(function)
    digest = base_digest()
    if in_llvm is not None:
        digest.update(in_llvm.read_bytes())
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
