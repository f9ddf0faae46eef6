"""Columns of one constant value, which take no memory and no time.

A rule is written once, with three components. In 2-D its `near.z` and `near.uz` are a column of
zeros, the compiler sees them, and what would be done with them disappears. So with `near.heard`, a
column of ones in a flock where everyone is heard.
"""

from __future__ import annotations

import operator
from dataclasses import dataclass
from typing import Any

from numba import types
from numba.core.datamodel import models
from numba.core.extending import intrinsic, overload, register_model


class ConstantColumn(types.Type):
    """Numba type of a column of one value (float)."""

    def __init__(self, value: float):
        super().__init__(name=f"ConstantColumn({value})")
        self.value = value


ZEROS, ONES = ConstantColumn(0.0), ConstantColumn(1.0)
register_model(ConstantColumn)(models.OpaqueModel)


@dataclass(frozen=True)
class PlainColumn:
    """A column of one value (float) where a rule runs as plain Python."""

    value: float

    def __getitem__(self, j: Any) -> float:
        """The value."""
        return self.value


def zeros() -> Any:
    """A column of zeros."""
    return PlainColumn(0.0)


def ones() -> Any:
    """A column of ones."""
    return PlainColumn(1.0)


@intrinsic
def compiled_zeros(typingctx: Any = None) -> Any:  # noqa: ARG001 - numba hands it over
    """A column of zeros, inside compiled code."""

    def codegen(context, builder, signature, arguments):  # noqa: ARG001
        return context.get_dummy_value()

    return ZEROS(), codegen


@intrinsic
def compiled_ones(typingctx: Any = None) -> Any:  # noqa: ARG001 - numba hands it over
    """A column of ones, inside compiled code."""

    def codegen(context, builder, signature, arguments):  # noqa: ARG001
        return context.get_dummy_value()

    return ONES(), codegen


overload(zeros)(lambda: lambda: compiled_zeros())
overload(ones)(lambda: lambda: compiled_ones())


@overload(operator.getitem)
def constant_at(column, j):  # noqa: ARG001
    """`near.z[j]` in 2-D, `near.heard[j]` where everyone is heard."""
    if isinstance(column, ConstantColumn):
        value = column.value
        return lambda column, j: value  # noqa: ARG005
    return None
