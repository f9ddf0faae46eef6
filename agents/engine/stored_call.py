"""Call a compiled loop from compiled code: its arguments lie in memory, one word after the other.

Python takes several times as long to hand a loop its sixty arrays as a small flock takes to
tick. So the arguments are written down once, as numba holds them in memory, and a few lines of LLVM
code read them and call the loop at its address. It is the machine code that Python would have
called, so the bits are the same.

Nothing here counts references: whoever writes arguments down keeps the arrays.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import typeof
from numba.core import types
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target
from numba.np.numpy_support import as_dtype

from agents.engine.vector_lanes import compile_in_llvm

WORD = ir.IntType(64)
FAILED = -2
"""What a stored call answers where the loop raised an exception."""
ARRAYS, SURROUNDINGS = 0, 2
"""Which arguments of a loop these are."""
HEAD, POINTER = 5, 4
"""Words of an array before its shape, and which of them says where its numbers are."""


class LoopCaller(NamedTuple):
    """Machine code that calls a loop with arguments from memory."""

    address: int
    """Where it is: a function that takes the address of the words and answers a row, see
    `call_stored`."""
    kinds: tuple[Any, ...]
    """numba's types of the arguments."""
    sizes: tuple[int, ...]
    """How many bytes each is."""
    library: Any
    """What holds the machine code, as long as it is called."""


@cache
def dtype_of(kind: Any) -> np.dtype:
    """NumPy's type of what an array of one of numba's types holds."""
    return np.dtype(as_dtype(kind.dtype))


def words_of(kind: Any, value: Any) -> Iterator[int]:
    """A value of one of numba's types as it lies in memory, in words of 8 bytes.

    Raises TypeError for what is not of the type.
    """
    if isinstance(kind, types.Array):
        # Compiled code takes the type on trust: what is laid out otherwise would be read wrongly.
        if value.dtype != dtype_of(kind) or value.ndim != kind.ndim:
            raise TypeError(f"an array of {value.dtype} is no {kind}")
        if not value.flags.c_contiguous:
            raise TypeError("an array is not contiguous")
        yield from (0, 0, value.size, value.itemsize, value.__array_interface__["data"][0])
        yield from value.shape
        yield from value.strides
    elif isinstance(kind, types.BaseTuple):
        parts: Any = kind
        for part_kind, part in zip(parts, value, strict=True):
            yield from words_of(part_kind, part)
    elif isinstance(kind, types.Float) and isinstance(value, float):
        yield struct.unpack("q", struct.pack("d", value))[0]
    elif not isinstance(kind, types.Float) and isinstance(value, int | np.integer | np.bool_):
        yield int(value)
    else:
        raise TypeError(f"{value!r} is no {kind}")


def size_of(kind: Any) -> int:
    """Bytes of a value of one of numba's types in memory."""
    context = cpu_target.target_context
    size: int = context.get_value_type(kind).get_abi_size(context.target_data)
    return size


@global_compiler_lock
def build_caller(loop: Any, kinds: tuple[Any, ...]) -> LoopCaller:
    """Machine code that calls a loop for arguments of these types; compiles the loop if need be."""
    loop.compile(kinds)
    compiled_loop = loop.overloads[kinds]
    context, description = compiled_loop.target_context, compiled_loop.fndesc
    name = f"stored_call.{description.llvm_func_name}"
    library = context.codegen().create_library(name)
    module = library.create_ir_module(name)
    function = ir.Function(module, ir.FunctionType(WORD, (WORD,)), name=name)
    builder = ir.IRBuilder(function.append_basic_block())
    arguments, offset = [], 0
    for kind in kinds:
        at = builder.add(function.args[0], ir.Constant(WORD, offset))
        pointer = builder.inttoptr(at, context.get_value_type(kind).as_pointer())
        arguments.append(builder.load(pointer))
        offset += size_of(kind)
    convention = context.call_conv
    loop_type = convention.get_function_type(description.restype, kinds)
    address = compiled_loop.library.get_pointer_to_function(description.llvm_func_name)
    callee = builder.inttoptr(ir.Constant(WORD, address), loop_type.as_pointer())
    status, answer = convention.call_function(
        builder, callee, description.restype, kinds, arguments
    )
    bad_row = builder.extract_value(answer, 2)
    builder.ret(builder.select(status.is_ok, bad_row, ir.Constant(WORD, FAILED)))
    library.add_ir_module(module)
    library.finalize()
    sizes = tuple(size_of(kind) for kind in kinds)
    return LoopCaller(library.get_pointer_to_function(name), kinds, sizes, library)


CALLERS: dict[Any, LoopCaller] = {}
"""Of loops with types of arguments; and of loops, for the types that they had last."""


def store_arguments(loop: Any, arguments: tuple[Any, ...]) -> tuple[LoopCaller, list[list[int]]]:
    """A loop's caller for these arguments, and the words of each.

    Asking numba for sixty types takes longer than anything else, so those that the loop had last
    are tried first.
    """
    if loop in CALLERS:
        caller = CALLERS[loop]
        pairs = zip(caller.kinds, arguments, strict=True)
        with suppress(TypeError):
            return caller, [list(words_of(kind, one)) for kind, one in pairs]
    kinds = tuple(typeof(one) for one in arguments)
    if (loop, kinds) not in CALLERS:
        CALLERS[loop, kinds] = build_caller(loop, kinds)
    caller = CALLERS[loop] = CALLERS[loop, kinds]
    words = [list(words_of(kind, one)) for kind, one in zip(kinds, arguments, strict=True)]
    for kind, size, some in zip(kinds, caller.sizes, words, strict=True):
        if 8 * len(some) != size:
            raise TypeError(f"{kind} does not lie in memory word by word")
    return caller, words


def store_value(value: Any) -> np.ndarray:
    """A value as `read_stored` reads it, int64 (W,)."""
    return np.array(list(words_of(typeof(value), value)), np.int64)


class StoredTick:
    """The call of a loop for one tick of a flock, in words that compiled code can hand on.

    Raises TypeError for an argument that does not lie in memory as the loop's caller reads it.
    """

    def __init__(self, loop: Any, arguments: tuple[Any, ...], seed_at: int):
        self.arguments = arguments
        self.caller, words = store_arguments(loop, arguments)
        begins = np.cumsum([0, *map(len, words)]).tolist()
        self.words = np.array([word for some in words for word in some], np.int64)
        self.surroundings_at = begins[SURROUNDINGS]
        self.seed_at, self.tick_at = begins[seed_at], begins[seed_at + 1]
        self.pointers_at = []
        at = begins[ARRAYS]
        for array in arguments[ARRAYS]:
            self.pointers_at.append(at + POINTER)
            at += HEAD + 2 * array.ndim

    def takes(self, arrays: Any, seed: int) -> bool:
        """Go on with arrays of the same shapes and another seed; False where they are others."""
        old_arrays = self.arguments[ARRAYS]
        for old, new in zip(old_arrays, arrays, strict=True):
            if new.shape != old.shape or new.dtype != old.dtype or not new.flags.c_contiguous:
                return False
        for at, array in zip(self.pointers_at, arrays, strict=True):
            self.words[at] = array.__array_interface__["data"][0]
        self.words[self.seed_at] = seed
        self.arguments = (arrays, *self.arguments[1:])
        return True


@compile_in_llvm
def call_stored(typingctx, code, words):  # noqa: ARG001
    """Call a loop by the address of its `LoopCaller` and that of its words; the first row with a
    position that is no number, -1 for none, or FAILED."""

    def codegen(context, builder, sig, args):  # noqa: ARG001
        function = ir.FunctionType(WORD, (WORD,)).as_pointer()
        return builder.call(builder.inttoptr(args[0], function), (args[1],))

    return types.int64(types.int64, types.int64), codegen


@compile_in_llvm
def read_stored(typingctx, example, address):  # noqa: ARG001
    """The value that lies at an address in words, of the type of an example."""

    def codegen(context, builder, sig, args):
        pointer = context.get_value_type(sig.return_type).as_pointer()
        return builder.load(builder.inttoptr(args[1], pointer))

    return example(example, types.int64), codegen


@compile_in_llvm
def write_word(typingctx, address, word):  # noqa: ARG001
    """Write a word at an address."""

    def codegen(context, builder, sig, args):  # noqa: ARG001
        builder.store(args[1], builder.inttoptr(args[0], WORD.as_pointer()))
        return context.get_dummy_value()

    return types.none(types.int64, types.int64), codegen
