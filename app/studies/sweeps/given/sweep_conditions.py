"""Comparisons that a file may make: between axes, and of an observable with a number; no code."""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple

from worlds.input_error import InputError, unknown

LONGEST = 500
"""Characters of a condition."""
COMPARED: dict[type[ast.cmpop], Callable[[Any, Any], bool]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
RECKONED: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
WORDS = "axes and numbers with < <= > >= == != + - * / ( ), joined by and, or, not"


class Condition:
    """A condition between axes, such as `dr_a > dr_o and eta <= 2`. Raises InputError.

    >>> Condition("dr_a > dr_o + 1", ["dr_a", "dr_o"]).holds({"dr_a": 3, "dr_o": 1})
    True
    """

    def __init__(self, text: str, axes: Collection[str]):
        self.text = text
        if len(text) > LONGEST:
            raise InputError(f"a condition has at most {LONGEST} characters")
        try:
            self.tree = ast.parse(text.strip(), mode="eval").body
            check(self.tree, text, axes)
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            if isinstance(error, InputError):
                raise
            raise not_understood(text) from None
        if not isinstance(self.tree, ast.Compare | ast.BoolOp | ast.UnaryOp):
            raise not_understood(text)

    def holds(self, values: Mapping[str, Any]) -> bool:
        """Whether it holds for the axes of a cell. Raises InputError where they cannot be
        compared."""
        try:
            return bool(value(self.tree, values))
        except (TypeError, ArithmeticError):
            said = ", ".join(f"{name} = {one!r}" for name, one in values.items())
            raise InputError(f"{self.text!r} cannot be said of {said}") from None


def not_understood(text: str) -> InputError:
    """The refusal of what is no condition."""
    return InputError(f"{text!r} is not a condition: {WORDS}")


def check(node: ast.AST, text: str, axes: Collection[str]) -> None:
    """Refuse whatever is not a comparison of axes and numbers. Raises InputError."""
    match node:
        case ast.BoolOp(values=parts):
            pass
        case ast.UnaryOp(op=ast.Not() | ast.USub(), operand=one):
            parts = [one]
        case ast.BinOp(left=left, op=op, right=right) if type(op) in RECKONED:
            parts = [left, right]
        case ast.Compare(left=left, ops=ops, comparators=others) if all(
            type(one) in COMPARED for one in ops
        ):
            parts = [left, *others]
        case ast.Constant(value=bool() | int() | float() | str()):
            return
        case ast.Name(id=name):
            if name not in axes:
                raise unknown("axis", name, axes, repr(text))
            return
        case _:
            raise not_understood(text)
    for one in parts:
        check(one, text, axes)


def value(node: ast.AST, values: Mapping[str, Any]) -> Any:
    """What a part of a condition comes to."""
    match node:
        case ast.BoolOp(op=ast.And(), values=parts):
            return all(value(one, values) for one in parts)
        case ast.BoolOp(values=parts):
            return any(value(one, values) for one in parts)
        case ast.UnaryOp(op=ast.Not(), operand=one):
            return not value(one, values)
        case ast.UnaryOp(operand=one):
            return -value(one, values)
        case ast.BinOp(left=left, op=op, right=right):
            return RECKONED[type(op)](value(left, values), value(right, values))
        case ast.Compare(left=left, ops=ops, comparators=others):
            found = [value(one, values) for one in (left, *others)]
            pairs = zip(found, ops, found[1:], strict=False)
            return all(COMPARED[type(op)](one, other) for one, op, other in pairs)
        case ast.Constant(value=one):
            return one
        case ast.Name(id=name):
            return values[name]
    raise AssertionError(node)


class ObservableBound(NamedTuple):
    """An observable and the bound that it is to keep to."""

    name: str
    sign: str
    bound: float

    def holds(self, measured: float) -> bool:
        """Whether a value keeps to it; nan does not."""
        return bool(SIGNS[self.sign](measured, self.bound))


SIGNS = {
    ">=": operator.ge,
    "<=": operator.le,
    ">": operator.gt,
    "<": operator.lt,
    "==": operator.eq,
    "!=": operator.ne,
}
COMPARISON = re.compile(r"\s*([\w.:/-]+)\s*(>=|<=|==|!=|>|<)\s*([-+.\w]+)\s*")


def comparison(text: str) -> ObservableBound:
    """A comparison of an observable with a number. Raises InputError.

    >>> comparison("mean-neighbours >= 3")
    ObservableBound(name='mean-neighbours', sign='>=', bound=3.0)
    """
    found = COMPARISON.fullmatch(text[:LONGEST])
    try:
        if found and len(text) <= LONGEST:
            return ObservableBound(found[1], found[2], float(found[3]))
    except ValueError:
        pass
    raise InputError(
        f"{text[:100]!r} is not allowed: one comparison of an observable with a number is needed, "
        "such as 'polarisation >= 0.9'"
    )
