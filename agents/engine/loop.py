"""One compiled loop per rule and body, cached on disk, never stale.

numba finds a kernel in its cache only if the kernel reaches the rule as a global of its module, and
it does not notice an edit of a function that the kernel calls. So each rule gets a module of its
own, made from the template `sweep.py` (or `turns.py`), and a cache folder named by a hash over the
bytecode of every function that it reaches and the value of every constant.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import os
import sys
import threading
import types
from collections import namedtuple
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np
import platformdirs
from numba.core.dispatcher import Dispatcher

from agents.engine import template

HERE = Path(__file__).parent
LOADING = threading.Lock()
TEMPLATES = {"sweep": HERE / "sweep.py", "turns": HERE / "turns.py"}


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
    """What a code object does, without where it stands."""
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
    if isinstance(function, Dispatcher):
        digest.update(describe(function.targetoptions).encode())
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


def sweep_module(dim: int, signals: int, parts: dict[str, Callable | None], fields):
    """The module whose `advance` runs whole ticks of a rule.

    `parts` names the compiled functions decide, show, remember, prepare and move; None takes the
    one that does nothing. `fields` are the names of the parameters; the module's `P` holds them.
    """
    filled = {part: made or getattr(template, part) for part, made in parts.items()}
    return load("sweep", {**filled, "DIM": dim, "SIGNALS": signals}, fields)


def turns_module(sweep: types.ModuleType):
    """The module whose `advance` lets the agents of a rule act in turn; `sweep` is its sweep."""
    shared = ("SIGNALS", "act", "nearby", "nearest_images", "ready", "show")
    return load("turns", {part: vars(sweep)[part] for part in shared}, sweep.P._fields)


def load(kind: str, globals_: dict, fields) -> types.ModuleType:
    """A template as a module of its own, with the given globals, compiled under its own cache."""
    digest = hashlib.sha256(repr((numba.__version__, sys.version_info[:3], tuple(fields))).encode())
    digest.update(importlib.metadata.version("llvmlite").encode())
    seen: set[int] = set()
    for part, value in sorted(globals_.items()):
        digest.update(part.encode())
        if isinstance(value, Dispatcher):
            fingerprint(value, digest, seen)
        else:
            digest.update(repr(value).encode())
    module_name = f"agents.engine.{kind}_{digest.hexdigest()[:16]}"
    with LOADING:
        if module_name not in sys.modules:
            sys.modules[module_name] = made(kind, module_name, globals_, fields, digest, seen)
    return sys.modules[module_name]


def made(kind: str, module_name: str, globals_: dict, fields, digest, seen) -> types.ModuleType:
    """The template `kind` executed as a module of that name."""
    spec = importlib.util.spec_from_file_location(module_name, TEMPLATES[kind])
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    module.__dict__.update(globals_, P=parameter_tuple(module_name, fields))
    spec.loader.exec_module(module)
    fingerprint(module.advance, digest, seen)
    module.__dict__["cache_folder"] = cache_base() / "kernels" / digest.hexdigest()[:24]
    setattr(numba.config, "CACHE_DIR", str(module.cache_folder))  # noqa: B010 - made at run time
    module.advance.enable_caching()
    return module


def parameter_tuple(module_name: str, fields) -> type:
    """A NamedTuple class of floats that pickles by its module, as numba's cache needs."""
    return namedtuple("P", fields, module=module_name)


def is_compiled(module: types.ModuleType) -> bool:
    """Whether the kernel is in the cache already, so that the first tick will not wait for it."""
    return bool(module.advance.signatures) or any(module.cache_folder.rglob("*.nbc"))
