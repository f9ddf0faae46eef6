"""Sums over pairs of agents: as many numbers as a rule's `term` has, for one agent or eight."""

from __future__ import annotations

from functools import partial
from typing import Any

from numba import types
from numba.core import cgutils
from numba.core.extending import overload

from agents.engine.vector_lanes import FREE, LANES, TRUTHS, address, compile_in_llvm, spread


def no_sums(number: int, like: Any) -> Any:  # noqa: ARG001
    """As many sums, of nothing yet: of lanes where `like` is lanes, else of one agent."""
    return (0.0,) * number


def add_terms(sums: Any, terms: Any) -> Any:
    """The sums with the terms of one pair added; a truth value counts as 0 or 1."""
    return tuple(total + term for total, term in zip(sums, terms, strict=True))


def choose_sums(condition: Any, these: Any, others: Any) -> Any:
    """`these` sums where the condition holds, else the `others`."""
    return these if condition else others


def sums_of(table: Any, number: int, lane: int) -> Any:
    """The sums of one of eight agents, out of a table (number or more, 8)."""
    return tuple(table[:number, lane])


@partial(compile_in_llvm, prefer_literal=True)
def compiled_no_sums(typingctx, number, like):  # noqa: ARG001
    """`no_sums`, in compiled code."""
    of = LANES if like == LANES else types.float64
    kind = types.UniTuple(of, number.literal_value)

    def codegen(context, builder, sig, args):  # noqa: ARG001
        zero = context.get_constant(types.float64, 0.0)
        zeros = [context.cast(builder, zero, types.float64, of)] * kind.count
        return context.make_tuple(builder, kind, zeros)

    return kind(number, like), codegen


@compile_in_llvm
def compile_added(typingctx, sums, terms):  # noqa: ARG001
    """`add_terms`, in compiled code."""
    kind = sums.dtype
    if len(terms) != sums.count:
        return None

    def codegen(context, builder, sig, args):
        results = []
        totals = cgutils.unpack_tuple(builder, args[0], sums.count)
        terms = cgutils.unpack_tuple(builder, args[1], sums.count)
        for total, term, term_type in zip(totals, terms, sig.args[1].types, strict=True):
            flags = FREE if kind == LANES else ()
            if term_type == TRUTHS:
                one_lanes = spread(builder, context.get_constant(types.float64, 1.0), LANES.vector)
                results.append(
                    builder.select(term, builder.fadd(total, one_lanes, flags=flags), total)
                )
            else:
                number = context.cast(builder, term, term_type, kind)
                results.append(builder.fadd(total, number, flags=flags))
        return context.make_tuple(builder, sums, results)

    return sums(sums, terms), codegen


@compile_in_llvm
def compile_chosen(typingctx, condition, these, others):  # noqa: ARG001
    """`choose_sums` of eight agents, in compiled code."""

    def codegen(context, builder, sig, args):  # noqa: ARG001
        both = (cgutils.unpack_tuple(builder, sums, these.count) for sums in args[1:])
        results = [builder.select(args[0], one, other) for one, other in zip(*both, strict=True)]
        return context.make_tuple(builder, these, results)

    return these(condition, these, others), codegen


@partial(compile_in_llvm, prefer_literal=True)
def compiled_sums_of(typingctx, table, number, lane):  # noqa: ARG001
    """`sums_of`, in compiled code."""
    kind = types.UniTuple(types.float64, number.literal_value)

    def codegen(context, builder, sig, args):
        at = context.cast(builder, args[2], sig.args[2], types.intp)
        results = []
        for row in range(kind.count):
            index = context.get_constant(types.intp, row)
            results.append(builder.load(address(context, builder, sig.args[0], args[0], index, at)))
        return context.make_tuple(builder, kind, results)

    return kind(table, number, lane), codegen


@compile_in_llvm
def keep_sums(typingctx, table, sums):  # noqa: ARG001
    """Write the sums of eight agents into the first rows of a table (rows, 8)."""

    def codegen(context, builder, sig, args):
        for row, lanes in enumerate(cgutils.unpack_tuple(builder, args[1], sums.count)):
            at = context.get_constant(types.intp, row), context.get_constant(types.intp, 0)
            begin = address(context, builder, sig.args[0], args[0], *at)
            builder.store(lanes, builder.bitcast(begin, lanes.type.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.none(table, sums), codegen


@overload(no_sums, prefer_literal=True)
def no_sums_compiled(number, like):  # noqa: ARG001
    return lambda number, like: compiled_no_sums(number, like)


@overload(add_terms)
def added_compiled(sums, terms):  # noqa: ARG001
    return lambda sums, terms: compile_added(sums, terms)


@overload(choose_sums)
def chosen_compiled(condition, these, others):  # noqa: ARG001
    return lambda condition, these, others: compile_chosen(condition, these, others)


@overload(sums_of, prefer_literal=True)
def sums_of_compiled(table, number, lane):  # noqa: ARG001
    return lambda table, number, lane: compiled_sums_of(table, number, lane)
