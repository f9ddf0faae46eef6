"""The third axis of a flat world: a column that is 0 wherever it is read, and costs nothing.

A rule is written once, with three components. In 2-D its `near.z` and `near.uz` have this type, the
compiler sees the zeros, and what would be done with them disappears.
"""

from __future__ import annotations

import operator
from typing import Any

from numba import types
from numba.core.datamodel import models
from numba.core.extending import intrinsic, overload, register_model


class ZeroColumn(types.Type):
    """Numba type of a column of zeros."""

    def __init__(self):
        super().__init__(name="ZeroColumn")


ZERO_COLUMN = ZeroColumn()
register_model(ZeroColumn)(models.OpaqueModel)


@intrinsic
def zeros(typingctx: Any = None) -> Any:  # noqa: ARG001 - numba hands it over
    """A column of zeros, inside compiled code."""

    def codegen(context, builder, signature, arguments):  # noqa: ARG001
        return context.get_dummy_value()

    return ZERO_COLUMN(), codegen


@overload(operator.getitem)
def zero_at(column, j):  # noqa: ARG001
    """`near.z[j]` in 2-D."""
    if isinstance(column, ZeroColumn):
        return lambda column, j: 0.0  # noqa: ARG005
    return None
