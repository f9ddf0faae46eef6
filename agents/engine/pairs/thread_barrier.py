"""Let the threads of a tick wait for one another, without Python and without a lock."""

from __future__ import annotations

import sys
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils

from agents.engine.vector_lanes import address, compile_in_llvm
from worlds.compilation import compiled

ARRIVED, ROUND, NEXT, STOP, BAD = range(5)
"""What the numbers of a meeting are: how many have come, how often all have met, the next slot that
nobody has taken, whether to wait no longer, and from there on what each thread has found."""
YIELD = "SwitchToThread" if sys.platform == "win32" else "sched_yield"
SPINS = 4000
"""Looks at the others before a thread lets the machine do something else."""


def element(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Where the element of an int64 array is that is meant by two arguments."""
    at = context.cast(builder, args[1], sig.args[1], types.intp)
    return address(context, builder, sig.args[0], args[0], at)


@compile_in_llvm
def add(typingctx, numbers, at, value):  # noqa: ARG001
    """Add to an element, no other thread coming between; what it was before."""

    def codegen(context, builder, sig, args):
        amount = context.cast(builder, args[2], sig.args[2], types.int64)
        return builder.atomic_rmw("add", element(context, builder, sig, args), amount, "seq_cst")

    return types.int64(numbers, at, value), codegen


@compile_in_llvm
def read(typingctx, numbers, at):  # noqa: ARG001
    """An element as other threads have left it by now."""

    def codegen(context, builder, sig, args):
        return builder.load_atomic(element(context, builder, sig, args), "seq_cst", 8)

    return types.int64(numbers, at), codegen


@compile_in_llvm
def write(typingctx, numbers, at, value):  # noqa: ARG001
    """Write an element so that other threads see it."""

    def codegen(context, builder, sig, args):
        number = context.cast(builder, args[2], sig.args[2], types.int64)
        builder.store_atomic(number, element(context, builder, sig, args), "seq_cst", 8)
        return context.get_dummy_value()

    return types.none(numbers, at, value), codegen


@compile_in_llvm
def yield_thread(typingctx):  # noqa: ARG001
    """Let another thread of the machine run."""

    def codegen(context, builder, sig, args):  # noqa: ARG001
        kind = ir.FunctionType(ir.IntType(32), ())
        yield_function = cgutils.get_or_insert_function(builder.module, kind, YIELD)
        builder.call(yield_function, ())
        return context.get_dummy_value()

    return types.none(), codegen


@compiled
def meet_threads(meeting, parts):
    """Go on once all `parts` threads have come here, or one of them has said that it will not."""
    if parts == 1:
        return
    round_now = read(meeting, ROUND)
    if add(meeting, ARRIVED, 1) == parts - 1:
        # Before ROUND rises: the others go on as soon as they see it, and may come here again.
        write(meeting, ARRIVED, 0)
        write(meeting, NEXT, 0)
        add(meeting, ROUND, 1)
        return
    spins = 0
    while read(meeting, ROUND) == round_now and read(meeting, STOP) == 0:
        spins += 1
        if spins > SPINS:
            yield_thread()
