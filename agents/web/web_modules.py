"""The WebAssembly of pages, kept on disk under names made from its code, as kernels are.

A page of the same model then takes no compiling, whatever its seed and its values. See
`agents.engine.cache` for whose files are read.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import FunctionType
from typing import Any

import numba
from numba.core.errors import NumbaError

import worlds.web_assembly
import worlds.web_binary
from agents.engine.cache import (
    base_digest,
    cache_base,
    fingerprint,
    read_checked,
    tell_unwritable,
    write_checked,
)
from agents.web.web_math import FUNCTIONS, page_function
from worlds.compilation import compiled
from worlds.input_error import InputError
from worlds.web_assembly import LinkedCode, linked_code, web_module

FOLDER = "pages"
"""Of the cache's folder."""
MOST_AT_HAND = 8
"""Modules that a process has at hand."""
AT_HAND: dict[str, bytes] = {}
LOOP_SHARE, CODE_SHARE = 0.45, 0.55
"""Of the time that a module takes: until the loop is LLVM code, and until all functions are."""
SOURCES = (worlds.web_assembly, worlds.web_binary)
"""What makes a module of LLVM code."""


@dataclass(frozen=True)
class PageFunction:
    """A function that a page calls."""

    function: Any
    """Compiled, by `worlds.compilation.entry` or `compiled`."""
    arguments: Sequence[Any]
    """Such as it is called with."""
    takes_text: bool = False
    """See `worlds.compilation.compiled`."""

    def code(self, name: str) -> LinkedCode:
        """Its LLVM code. Raises InputError where numba does not compile what follows from
        parameters."""
        try:
            return linked_code(self.function, self.arguments, self.takes_text)
        except NumbaError:
            if not self.takes_text:
                raise
            raise InputError(
                f"a page cannot compute {name!r} when a slider is moved: numba does not compile it"
            ) from None

    def describe(self) -> str:
        """What its code depends on, in words that are the same in every process."""
        kinds = [(str(numba.typeof(one)), field_names(one)) for one in self.arguments]
        return repr((self.function.__name__, digest_of(self.function), kinds, self.takes_text))


@functools.lru_cache(maxsize=256)
def digest_of(function: Any) -> str:
    """A hash of a compiled function and all that it reaches."""
    digest = hashlib.sha256()
    fingerprint(function, digest, set())
    return digest.hexdigest()


def field_names(value: Any) -> Any:
    """The names of the members of a tuple, and of theirs: numba's type of it may not say them."""
    if not isinstance(value, tuple):
        return ()
    return getattr(value, "_fields", len(value)), tuple(field_names(one) for one in value)


def module_of(
    functions: Mapping[str, PageFunction], update: Callable[[float], None] = lambda _: None
) -> bytes:
    """The module that exports these functions by their names, compiled if it is not kept.

    `update` hears the share that is done. Raises InputError.
    """
    digest = base_digest()
    for source in SOURCES:
        digest.update(Path(source.__file__ or "").read_bytes())
    own = {name: PageFunction(one, ()) for name, one in FUNCTIONS.items()}
    for name, one in (own | dict(functions)).items():
        digest.update(f"{name} {one.describe()}".encode())
    key = digest.hexdigest()[:32]
    place = cache_base(), FOLDER, f"{key}.wasm"
    content = AT_HAND.get(key) or read_checked(*place)
    if content is None:
        code = {}
        for name, one in functions.items():
            code[name] = one.code(name)
            update(LOOP_SHARE)
        update(CODE_SHARE)
        own_code = {name: functools.partial(page_function, name) for name in FUNCTIONS}
        content = web_module(code, own_code).content
        try:
            write_checked(content, *place)
        except OSError as error:
            tell_unwritable(error)
    AT_HAND[key] = content
    for oldest in list(AT_HAND)[:-MOST_AT_HAND]:
        del AT_HAND[oldest]
    return content


def with_callees(function: FunctionType, callers: tuple[FunctionType, ...] = ()) -> FunctionType:
    """A plain function whose callees are plain, too, as numba takes it: it calls them compiled.

    One that calls itself stays as it is, which numba refuses.
    """
    known, callers = function.__globals__, (*callers, function)
    callees = {
        name: compiled(with_callees(callee, callers), takes_text=True)
        for name in function.__code__.co_names
        if isinstance(callee := known.get(name), FunctionType) and callee not in callers
    }
    return FunctionType(
        function.__code__,
        known | callees,
        function.__name__,
        function.__defaults__,
        function.__closure__,
    )
