"""Parameters that agents have of their own: `p` of one agent, or of eight at once, from a table.

A loop is compiled for flocks whose agents share all parameters, or for those whose agents differ.
What all share stays one number there, which the compiler keeps in a register. The table `own`
(N, Q) has a row for each agent and a column for each parameter that may differ.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.extending import overload

from agents.engine.vector_lanes import LANES, WIDTH, address, compile_in_llvm
from worlds.compilation import compiled


@compile_in_llvm
def lanes_of_rows(typingctx, own, rows, slot, last, column):  # noqa: ARG001
    """A column of the table for the agents of eight slots, as lanes.

    Those from `last` on are of no account and get what the one before `last` has.
    """

    def codegen(context, builder, sig, args):
        own_array, rows_array, slot, last, column = (
            value
            if isinstance(kind, types.Array)
            else context.cast(builder, value, kind, types.intp)
            for value, kind in zip(args, sig.args, strict=True)
        )
        one = context.get_constant(types.intp, 1)
        end = builder.sub(last, one)
        lanes = ir.Constant(LANES.vector, ir.Undefined)
        at = slot
        for lane in range(WIDTH):
            inside = builder.select(builder.icmp_signed("<", at, end), at, end)
            row = builder.load(address(context, builder, sig.args[1], rows_array, inside))
            row = context.cast(builder, row, sig.args[1].dtype, types.intp)
            value = builder.load(address(context, builder, sig.args[0], own_array, row, column))
            lanes = builder.insert_element(lanes, value, ir.Constant(ir.IntType(32), lane))
            at = builder.add(at, one)
        return lanes

    return LANES(own, rows, slot, last, column), codegen


SOURCE = """
def own_of_row(p, own, row):
    return P({of_row})

def own_of_eight(p, own, rows, slot, last):
    return P({of_eight})
"""


def own_functions(parameters: type, differ: tuple[int, ...], module: str) -> dict[str, Callable]:
    """Compiled functions of a loop whose agents differ in those fields of its `P`, by name.

    `differ`: which field each column of `own` is, -1 for a column that the loop does not read.

    `own_of_row`: (p, own, row) -> `p` of the agent of a row. `own_of_eight`: (p, own, rows, slot,
    last) -> `p` of the agents of eight slots, whose rows are `rows[slot:]`, its numbers lanes. They
    are written as Python because numba makes a tuple of some class only where its call stands.
    """
    fields = parameters._fields  # type: ignore[attr-defined]
    column = {field: k for k, field in enumerate(differ) if field >= 0}

    def call(own: str) -> str:
        return ", ".join(
            own.format(column[k]) if k in column else f"p.{field}" for k, field in enumerate(fields)
        )

    of_row = call("own[row, {}]")
    of_eight = call("lanes_of_rows(own, rows, slot, last, {})")
    names: dict[str, Any] = {"P": parameters, "lanes_of_rows": lanes_of_rows, "__name__": module}
    exec(SOURCE.format(of_row=of_row, of_eight=of_eight), names)
    return {name: compiled(names[name]) for name in ("own_of_row", "own_of_eight")}


def may_be_positive(value: Any) -> bool:
    """Whether a number that is not negative is above 0: of one agent; of eight it may always be.

    So code for one agent can leave out what a 0 makes needless. Code for eight goes through it, and
    has to have the same bits there.
    """
    return value > 0.0


@overload(may_be_positive)
def may_be_positive_compiled(value):
    """Of eight agents, or of one."""
    if value == LANES:
        return lambda value: True  # noqa: ARG005
    return lambda value: value > 0.0
