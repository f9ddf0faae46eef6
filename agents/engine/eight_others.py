"""Eight others at once: how a rule sums over the agents around one agent.

`eight_from(first, near.n)` stands for eight agents of a block: `near.x[j]` are their coordinates,
and what is written for one of them works on eight, as `vector_lanes` says. Of the last eight some
may not be there: `is_there(j)` is false for them, and what their lanes hold is of no account. In
plain Python it stands for one.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.extending import overload, register_model

from agents.engine.pairs.term_sums import add_terms, no_sums
from agents.engine.vector_lanes import (
    DOUBLE,
    FREE,
    INT64,
    LANES,
    TRUTHS,
    WIDTH,
    compile_in_llvm,
    load,
    spread,
)
from worlds.compilation import compiled


class EightOthers(types.Type):
    """Numba type of eight agents of a block: the first of them, and how many the block has."""


EIGHT = EightOthers("EightOthers")
register_model(EightOthers)(
    lambda manager, kind: models.StructModel(
        manager, kind, [("first", types.intp), ("number", types.intp)]
    )
)


def width() -> int:
    """How many agents are taken at once: in plain Python one."""
    return 1


def eight_from(first: int, number: int) -> Any:  # noqa: ARG001
    """Eight agents from the `first` on of a block of so many."""
    return first


def is_there(others: Any) -> Any:  # noqa: ARG001
    """Whether there is such an agent."""
    return True


def across(lanes: Any) -> Any:
    """The sum of eight values, always in the same order."""
    return lanes


def least(lanes: Any) -> Any:
    """The least of eight values."""
    return lanes


def no_lanes() -> Any:
    """Eight zeros."""
    return 0.0


@compile_in_llvm
def compiled_eight(typingctx, first, number):  # noqa: ARG001
    """`eight_from`, in compiled code."""

    def codegen(context, builder, sig, args):
        others = cgutils.create_struct_proxy(EIGHT)(context, builder)
        others.first = context.cast(builder, args[0], sig.args[0], types.intp)
        others.number = context.cast(builder, args[1], sig.args[1], types.intp)
        return others._getvalue()

    return EIGHT(first, number), codegen


@compile_in_llvm
def first_of(typingctx, others):  # noqa: ARG001
    """The first of eight."""

    def codegen(context, builder, sig, args):  # noqa: ARG001
        return cgutils.create_struct_proxy(EIGHT)(context, builder, value=args[0]).first

    return types.intp(others), codegen


@compile_in_llvm
def compiled_is_there(typingctx, others):  # noqa: ARG001
    """`is_there`, in compiled code."""

    def codegen(context, builder, sig, args):  # noqa: ARG001
        others = cgutils.create_struct_proxy(EIGHT)(context, builder, value=args[0])
        places = ir.Constant(ir.VectorType(INT64, WIDTH), list(range(WIDTH)))
        left = builder.sub(others.number, others.first)
        return builder.icmp_signed("<", places, spread(builder, left, places.type))

    return TRUTHS(others), codegen


@compile_in_llvm
def compiled_across(typingctx, lanes):  # noqa: ARG001
    """`across`, in compiled code."""

    def codegen(context, builder, sig, args):  # noqa: ARG001
        total = ir.Constant(DOUBLE, 0.0)
        for lane in range(WIDTH):
            at = ir.Constant(ir.IntType(32), lane)
            # Without flags numba gives it those of the function, which allow another order.
            total = builder.fadd(total, builder.extract_element(args[0], at), flags=FREE)
        return total

    return types.float64(lanes), codegen


@compile_in_llvm
def compiled_least(typingctx, lanes):  # noqa: ARG001
    """`least`, in compiled code."""

    def codegen(context, builder, sig, args):  # noqa: ARG001
        lanes = [
            builder.extract_element(args[0], ir.Constant(ir.IntType(32), lane))
            for lane in range(WIDTH)
        ]
        total = lanes[0]
        for value in lanes[1:]:
            total = builder.select(builder.fcmp_ordered("<", value, total), value, total)
        return total

    return types.float64(lanes), codegen


@compile_in_llvm
def compiled_no_lanes(typingctx):  # noqa: ARG001
    """`no_lanes`, in compiled code."""
    return LANES(), lambda *_: ir.Constant(LANES.vector, [0.0] * WIDTH)


@overload(width)
def width_compiled():
    return lambda: WIDTH


@overload(eight_from)
def eight_from_compiled(first, number):  # noqa: ARG001
    return lambda first, number: compiled_eight(first, number)


@overload(is_there)
def is_there_compiled(others):
    """For eight, or for one of a block, which is there."""
    if others == EIGHT:
        return lambda others: compiled_is_there(others)
    return lambda others: True  # noqa: ARG005


@overload(across)
def across_compiled(lanes):  # noqa: ARG001
    return lambda lanes: compiled_across(lanes)


@overload(least)
def least_compiled(lanes):  # noqa: ARG001
    return lambda lanes: compiled_least(lanes)


@overload(no_lanes)
def no_lanes_compiled():
    return lambda: compiled_no_lanes()


@overload(operator.getitem)
def eight_of_column(array, at):
    """`near.x[j]` and `near.signal[k, j]` of eight agents."""
    if isinstance(array, types.Array) and at == EIGHT:
        return lambda array, at: load(array, first_of(at))
    if isinstance(array, types.Array) and isinstance(at, types.Tuple) and at.types[-1] == EIGHT:
        return lambda array, at: load(array[at[0]], first_of(at[1]))
    return None


def sums_over_others(number: int, term: Callable) -> Callable:
    """Compiled: (me, near, p). The `number` sums of a `term` over the agents of a block.

    `term(me, near, j, p)`, compiled, has as many numbers, all 0 for agents that are no neighbours,
    also where `is_there(j)` is false. It is asked for eight at once, so there is no `if` in it.
    """

    @compiled
    def around(me, near, p):
        sums = no_sums(number, no_lanes())
        for first in range(0, near.n, width()):
            sums = add_terms(sums, term(me, near, eight_from(first, near.n), p))
        return sums

    return around
