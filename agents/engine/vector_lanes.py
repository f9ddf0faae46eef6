"""Eight agents at once: values that stand for eight, one in each lane of a vector register.

What is written for one agent works on eight where it is given lanes in place of floats: sums,
products and roots are taken lane by lane, a comparison gives a truth value for each lane, and
`where` chooses between two values. There is no `if` that asks about a lane.

Each lane is computed as if it were alone, always in the same order of operations: what stands in
the other lanes never changes its bits. There are eight on every machine, whatever its registers
hold.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.errors import LoweringError
from numba.core.extending import intrinsic, overload, register_model
from numba.core.imputils import lower_builtin, lower_cast
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature

WIDTH = 8
"""Agents at once."""
FREE = ("contract", "nsz")
"""What the compiler may do: a product and a sum in one go, 0 for -0; never another order."""
DOUBLE, INT64, BIT = ir.DoubleType(), ir.IntType(64), ir.IntType(1)


class Eight(types.Type):
    """Numba type of eight values, one in each lane."""

    def __init__(self, name: str, element: ir.Type, plain: tuple[type, ...]):
        super().__init__(name=name)
        self.vector = ir.VectorType(element, WIDTH)
        self.plain = plain
        """Types of Python numbers of which one stands for eight."""

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:  # noqa: ARG002
        """One number stands for eight, a truth value for 0.0 or 1.0."""
        fits = isinstance(other, self.plain) or (self == LANES and other == TRUTHS)
        return Conversion.promote if fits else None

    def unify(self, typingctx: Any, other: Any) -> Any:  # noqa: ARG002
        """A variable that is one number here and eight there is eight."""
        return self if isinstance(other, self.plain) else None


class Vector(models.PrimitiveModel):
    """Eight values are one vector register."""

    def __init__(self, manager: Any, kind: Eight):
        super().__init__(manager, kind, kind.vector)


LANES = Eight("Lanes", DOUBLE, (types.Float, types.Integer, types.Boolean))
WORDS = Eight("Words", INT64, (types.Integer,))
TRUTHS = Eight("Truths", BIT, (types.Boolean,))
register_model(Eight)(Vector)


def spread(builder: Any, value: Any, vector: ir.VectorType) -> Any:
    """The vector that holds a value in all lanes."""
    if isinstance(value, ir.Constant):
        return ir.Constant(vector, [value.constant] * WIDTH)
    first = builder.insert_element(
        ir.Constant(vector, ir.Undefined), value, ir.Constant(ir.IntType(32), 0)
    )
    order = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(first, ir.Constant(vector, ir.Undefined), order)


@lower_cast(types.Float, Eight)
@lower_cast(types.Integer, Eight)
@lower_cast(types.Boolean, Eight)
def cast_number(context, builder, from_type, to_type, value):
    """One number as eight."""
    element = {LANES: types.float64, WORDS: types.uint64, TRUTHS: types.boolean}[to_type]
    number = context.cast(builder, value, from_type, element)
    if to_type == TRUTHS:
        number = builder.trunc(number, BIT) if number.type != BIT else number
    return spread(builder, number, to_type.vector)


@lower_cast(Eight, Eight)
def cast_truths(context, builder, from_type, to_type, value):  # noqa: ARG001
    """Truth values as 0.0 and 1.0."""
    return value if from_type == to_type else builder.uitofp(value, to_type.vector)


IN_PLACE: dict[Any, Any] = {
    operator.add: operator.iadd,
    operator.sub: operator.isub,
    operator.mul: operator.imul,
    operator.truediv: operator.itruediv,
    operator.and_: operator.iand,
    operator.or_: operator.ior,
    operator.xor: operator.ixor,
    operator.rshift: operator.irshift,
}
"""numba does not fall back from `x += y` to `x = x + y` for types of ours."""


def operation(symbol: Any, answer: Eight, *kinds: Eight) -> Callable:
    """Have an operator or a function take eight values of these kinds; wraps what builds it."""

    def wrap(build: Callable) -> Callable:
        class LaneTemplate(AbstractTemplate):
            key = symbol

            def generic(self, args: Any, kws: Any) -> Any:
                if kws or len(args) != len(kinds):
                    return None
                if not any(isinstance(argument, Eight) for argument in args):
                    return None
                for argument_type, kind in zip(args, kinds, strict=True):
                    if kind == TRUTHS != argument_type and symbol is operator.mul:
                        return None
                    if argument_type != kind and kind.can_convert_from(None, argument_type) is None:
                        return None
                return signature(answer, *kinds)

        for operator_symbol in (symbol, IN_PLACE.get(symbol, symbol)):
            infer_global(operator_symbol)(LaneTemplate)

            @lower_builtin(operator_symbol, *kinds)
            def lower(context: Any, builder: Any, sig: Any, values: Any) -> Any:  # noqa: ARG001
                return build(builder, *values)

        return build

    return wrap


operation(operator.add, LANES, LANES, LANES)(lambda b, x, y: b.fadd(x, y, flags=FREE))
operation(operator.sub, LANES, LANES, LANES)(lambda b, x, y: b.fsub(x, y, flags=FREE))
operation(operator.truediv, LANES, LANES, LANES)(lambda b, x, y: b.fdiv(x, y, flags=FREE))
operation(operator.neg, LANES, LANES)(lambda b, x: b.fneg(x, flags=FREE))
operation(operator.pos, LANES, LANES)(lambda _, x: x)
for comparison, sign in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
):
    operation(comparison, TRUTHS, LANES, LANES)(
        lambda b, x, y, sign=sign: b.fcmp_ordered(sign, x, y, flags=FREE)
    )
# Unordered: nan differs from everything.
operation(operator.ne, TRUTHS, LANES, LANES)(lambda b, x, y: b.fcmp_unordered("!=", x, y))
operation(operator.eq, TRUTHS, WORDS, WORDS)(lambda b, x, y: b.icmp_unsigned("==", x, y))
operation(operator.ne, TRUTHS, WORDS, WORDS)(lambda b, x, y: b.icmp_unsigned("!=", x, y))
operation(operator.and_, TRUTHS, TRUTHS, TRUTHS)(lambda b, x, y: b.and_(x, y))
operation(operator.or_, TRUTHS, TRUTHS, TRUTHS)(lambda b, x, y: b.or_(x, y))
operation(operator.xor, TRUTHS, TRUTHS, TRUTHS)(lambda b, x, y: b.xor(x, y))
operation(operator.not_, TRUTHS, TRUTHS)(lambda b, x: b.not_(x))
operation(operator.xor, WORDS, WORDS, WORDS)(lambda b, x, y: b.xor(x, y))
operation(operator.add, WORDS, WORDS, WORDS)(lambda b, x, y: b.add(x, y))
operation(operator.mul, WORDS, WORDS, WORDS)(lambda b, x, y: b.mul(x, y))
operation(operator.rshift, WORDS, WORDS, WORDS)(lambda b, x, y: b.lshr(x, y))


@lower_builtin(operator.is_, Eight, types.Any)
@lower_builtin(operator.is_, types.Any, Eight)
@lower_builtin(operator.is_, Eight, Eight)
def refuse_identity(context, builder, sig, values):  # noqa: ARG001
    """numba has one answer to `is`, not eight."""
    raise LoweringError("`is` cannot compare eight agents at once: use == or !=")


@operation(operator.mul, LANES, TRUTHS, LANES)
def chosen(builder, truth, value):
    """The value where the truth holds, else 0.0."""
    return builder.select(truth, value, ir.Constant(value.type, [0.0] * WIDTH))


operation(operator.mul, LANES, LANES, TRUTHS)(lambda b, value, truth: chosen(b, truth, value))
operation(operator.mul, LANES, LANES, LANES)(lambda b, x, y: b.fmul(x, y, flags=FREE))


def llvm_builder(name: str) -> Callable:
    """What builds a call of one of LLVM's own functions."""

    def build(builder: Any, value: Any) -> Any:
        kind = ir.FunctionType(value.type, (value.type,))
        title = f"llvm.{name}.v{WIDTH}f64"
        callee = cgutils.get_or_insert_function(builder.module, kind, title)
        return builder.call(callee, (value,))

    return build


operation(math.sqrt, LANES, LANES)(llvm_builder("sqrt"))
operation(math.floor, LANES, LANES)(llvm_builder("floor"))
operation(math.radians, LANES, LANES)(
    lambda b, x: b.fmul(x, ir.Constant(x.type, [math.pi / 180.0] * WIDTH), flags=FREE)
)
operation(math.fabs, LANES, LANES)(llvm_builder("fabs"))
operation(abs, LANES, LANES)(llvm_builder("fabs"))
for function in (math.exp, math.log, math.sin, math.cos):
    operation(function, LANES, LANES)(llvm_builder(function.__name__))
operation(min, LANES, LANES, LANES)(lambda b, x, y: b.select(b.fcmp_ordered("<", y, x), y, x))
operation(max, LANES, LANES, LANES)(lambda b, x, y: b.select(b.fcmp_ordered(">", y, x), y, x))


@overload(operator.pow)
@overload(operator.ipow)
def square_of_lanes(value, power):
    """`x ** 2`, the one power that lanes have."""
    is_square = isinstance(power, types.IntegerLiteral) and power.literal_value == 2
    return (lambda value, power: value * value) if value == LANES and is_square else None  # noqa: ARG005


def where(condition: Any, this: Any, other: Any) -> Any:
    """`this` where the condition holds, else `other`; of floats or lanes."""
    return this if condition else other


@overload(where)
def where_of_one(condition, this, other):  # noqa: ARG001
    """The choice for one agent."""
    if isinstance(condition, types.Boolean):
        return lambda condition, this, other: this if condition else other
    return None


operation(where, LANES, TRUTHS, LANES, LANES)(lambda b, truth, x, y: b.select(truth, x, y))


def as_unsigned(number: Any) -> Any:
    """A whole number as uint64."""
    return np.uint64(number)


@overload(as_unsigned)
def words_of_one(number):
    """A whole number of one agent as uint64."""
    return (lambda number: np.uint64(number)) if isinstance(number, types.Integer) else None


operation(as_unsigned, WORDS, WORDS)(lambda _, x: x)


def as_float(number: Any) -> Any:
    """A uint64 as a float."""
    return float(number)


@overload(as_float)
def float_of_one(number):
    """A uint64 of one agent as a float."""
    return (lambda number: float(number)) if isinstance(number, types.Integer) else None


operation(as_float, LANES, WORDS)(lambda b, x: b.uitofp(x, LANES.vector))


def mantissa(number: Any) -> Any:
    """m in [0.5, 1) of a normal number m * 2**e > 0."""
    return math.frexp(number)[0]


def exponent(number: Any) -> Any:
    """e of a normal number m * 2**e > 0, as a float."""
    return float(math.frexp(number)[1])


def power_of_two(number: Any) -> Any:
    """2**k of a whole number k in [-1022, 1023], which may be given as a float."""
    return math.ldexp(1.0, int(number))


@overload(power_of_two)
def power_of_two_of_one(number):
    """The power for one agent."""
    is_number = isinstance(number, types.Float | types.Integer)
    return (lambda number: math.ldexp(1.0, int(number))) if is_number else None


@overload(mantissa)
def mantissa_of_one(number):
    """The mantissa for one agent."""
    return (lambda number: math.frexp(number)[0]) if isinstance(number, types.Float) else None


@overload(exponent)
def exponent_of_one(number):
    """The exponent for one agent."""
    return (
        (lambda number: float(math.frexp(number)[1])) if isinstance(number, types.Float) else None
    )


def bits(value: int) -> ir.Constant:
    """A word in all lanes."""
    return ir.Constant(WORDS.vector, [value] * WIDTH)


@operation(mantissa, LANES, LANES)
def mantissa_of_lanes(builder, value):
    """The bits of the fraction, with those of the exponent of 0.5."""
    word = builder.bitcast(value, WORDS.vector)
    mantissa_bits = builder.and_(word, bits((1 << 52) - 1))
    return builder.bitcast(builder.or_(mantissa_bits, bits(1022 << 52)), LANES.vector)


@operation(exponent, LANES, LANES)
def exponent_of_lanes(builder, value):
    """The bits of the exponent."""
    word = builder.lshr(builder.bitcast(value, WORDS.vector), bits(52))
    return builder.sitofp(builder.sub(word, bits(1022)), LANES.vector)


@operation(power_of_two, LANES, LANES)
def power_of_two_of_lanes(builder, value):
    """The last bits of k + 1023 + 2**52 are the bits of the exponent."""
    shifted = builder.fadd(value, ir.Constant(LANES.vector, [1023.0 + 2.0**52] * WIDTH))
    word = builder.shl(builder.bitcast(shifted, WORDS.vector), bits(52))
    return builder.bitcast(word, LANES.vector)


def compile_in_llvm(function: Callable, **options: Any) -> Any:
    """A function that is written down in LLVM's own words, for compiled code to call."""
    return intrinsic(**options)(function) if options else intrinsic(function)


def address(context: Any, builder: Any, kind: Any, array: Any, *at: Any) -> Any:
    """Where in memory an element of a C array is."""
    array_struct = context.make_array(kind)(context, builder, array)
    return cgutils.get_item_pointer(context, builder, kind, array_struct, at, wraparound=False)


@compile_in_llvm
def load(typingctx, column, first):  # noqa: ARG001
    """Eight values of a column from its element `first` on: Lanes of floats, Words of integers."""
    kind = LANES if column.dtype == types.float64 else WORDS
    wide = column.dtype.bitwidth == 64
    element = kind.vector.element if wide else ir.IntType(column.dtype.bitwidth)

    def codegen(context, builder, sig, args):
        at = context.cast(builder, args[1], sig.args[1], types.intp)
        begin = address(context, builder, sig.args[0], args[0], at)
        begin = builder.bitcast(begin, ir.VectorType(element, WIDTH).as_pointer())
        read = builder.load(begin, align=column.dtype.bitwidth // 8)
        return read if wide else builder.zext(read, kind.vector)

    return kind(column, first), codegen


@compile_in_llvm
def store(typingctx, table, row, lanes):  # noqa: ARG001
    """Write Lanes, or a number for all of them, into a row of a table (rows, 8)."""

    def codegen(context, builder, sig, args):
        at = context.cast(builder, args[1], sig.args[1], types.intp)
        at = at, context.get_constant(types.intp, 0)
        begin = address(context, builder, sig.args[0], args[0], *at)
        value = context.cast(builder, args[2], sig.args[2], LANES)
        builder.store(value, builder.bitcast(begin, LANES.vector.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.none(table, row, lanes), codegen


def is_any(truths: Any) -> Any:
    """Whether a condition holds for any of eight agents; for one, whether it holds."""
    return truths


@compile_in_llvm
def is_any_of_eight(typingctx, truths):  # noqa: ARG001
    """1 where a condition holds for any of eight agents, else 0."""

    def codegen(context, builder, sig, args):  # noqa: ARG001
        bits = builder.bitcast(args[0], ir.IntType(WIDTH))
        any_bit = builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))
        return builder.zext(any_bit, INT64)

    return types.uint64(truths), codegen


@overload(is_any)
def is_any_compiled(truths):
    """Of eight agents, or of one."""
    if truths == TRUTHS:
        return lambda truths: is_any_of_eight(truths)
    return (lambda truths: truths) if isinstance(truths, types.Boolean) else None


class LaneRows(types.Type):
    """Numba type of a table (rows, 8) each row of which is read and written as lanes."""

    def __init__(self, table: types.Array):
        super().__init__(name=f"LaneRows({table})")
        self.table = table


register_model(LaneRows)(
    lambda manager, kind: models.StructModel(manager, kind, [("table", kind.table)])
)


@compile_in_llvm
def lane_rows(typingctx, table):  # noqa: ARG001
    """A table (rows, 8) of which `rows[k]` is row k as lanes."""

    def codegen(context, builder, sig, args):
        rows = cgutils.create_struct_proxy(sig.return_type)(context, builder)
        rows.table = args[0]
        return rows._getvalue()

    return LaneRows(table)(table), codegen


@compile_in_llvm
def table_of(typingctx, rows):  # noqa: ARG001
    """The table of lane rows."""

    def codegen(context, builder, sig, args):
        return cgutils.create_struct_proxy(sig.args[0])(context, builder, value=args[0]).table

    return rows.table(rows), codegen


@overload(operator.getitem)
def lanes_of_row(rows, at):  # noqa: ARG001
    """`rows[k]`."""
    if isinstance(rows, LaneRows):
        return lambda rows, at: load(table_of(rows)[at], 0)
    return None


@overload(operator.setitem)
def write_lanes_of_row(rows, at, lanes):  # noqa: ARG001
    """`rows[k] = lanes`."""
    if isinstance(rows, LaneRows):
        return lambda rows, at, lanes: store(table_of(rows), at, lanes)
    return None
