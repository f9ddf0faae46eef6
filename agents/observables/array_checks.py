"""Check the arrays that observables take: rows that are no numbers are left out, bad ones refused.

One rule for all. A row (an agent, a tick of a series) of which a number is nan or infinite is left
out of what is measured, and a `OmittedRowsWarning` warning says how many there were; what is
measured row by row has nan or -1 there. Everything else that is not as described is refused in one
line: what is not real numbers, another shape, lengths that do not match, a heading without length
1, a box without sides. Two kinds of functions leave nothing out: what works element by element has
nan where it is given nan, and where it is asked since when something holds for good, a tick that is
nan is one at which it does not.
"""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from agents.engine.cache import compile_to_disk
from worlds.input_error import InputError

HERE = str(Path(__file__).parent)
SHORTEST, LONGEST = 0.98**2, 1.02**2
"""Squared lengths that a heading may have: those of unit vectors with two decimals do."""


class OmittedRowsWarning(UserWarning):
    """Rows that are not numbers were left out of what was measured; once for each call.

    >>> with warnings.catch_warnings(record=True) as caught:
    ...     warnings.simplefilter("always", OmittedRowsWarning)
    ...     _ = drop_bad_rows(position=np.array([[1.0, math.nan], [2.0, 3.0]]))
    >>> caught[0].message.rows, caught[0].message.of, caught[0].message.what
    (1, 2, 'position')
    """

    def __init__(self, rows: int, of: int, what: str):
        """`rows` of the `of` rows of the arrays named in `what` were left out."""
        self.rows, self.of, self.what = rows, of, what
        are = "row is" if rows == 1 else "rows are"
        super().__init__(f"{what}: {rows} of {of} {are} left out: nan or infinite")


def warn_of_omitted(rows: int, total: int, kind: str) -> None:
    """Say that rows are left out, to whoever called the observable; nothing if there are none."""
    if rows:
        warnings.warn(OmittedRowsWarning(rows, total, kind), skip_file_prefixes=(HERE,))


def numbers(name: str, value: Any, axes: int | None = None) -> np.ndarray:
    """`value` as an array of floats with so many axes, or any; what a mask hides is nan.

    Raises InputError.
    """
    array = floats(name, value)
    if axes is not None and array.ndim != axes:
        raise InputError(f"{name} has shape {array.shape}: an array of {axes} axes is needed")
    return array


def floats(name: str, value: Any) -> np.ndarray:
    """`value` as an array of floats; what a mask hides is nan. Raises InputError."""
    if type(value) is np.ndarray and value.dtype == np.float64:
        return value
    if isinstance(value, np.ma.MaskedArray):
        is_numeric = value.data.dtype.kind in "iuf"
        value = (
            np.where(np.ma.getmaskarray(value), np.nan, value.data) if is_numeric else value.data
        )
    try:
        array = np.asarray(value)
    except ValueError:
        raise InputError(f"{name} is no array: its rows have different lengths") from None
    if array.size == 0 and array.dtype.kind in "biufO":
        return array.astype(float)
    if array.dtype.kind not in "iuf":
        raise InputError(f"{name} holds {array.dtype} values: real numbers are needed")
    return array.astype(float)


def vectors(name: str, value: Any) -> np.ndarray:
    """`value` as floats (N, 2) or (N, 3), one row for each agent; [] is (0, 2). Raises
    InputError."""
    array = numbers(name, value)
    if array.shape == (0,):
        return np.empty((0, 2))
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise InputError(
            f"{name} has shape {array.shape}: (N, 2) or (N, 3) is needed, a row for each agent"
        )
    return array


def column(name: str, value: Any) -> np.ndarray:
    """`value` as floats (K,). Raises InputError."""
    return numbers(name, value, axes=1)


def integers(name: str, value: Any, low: float, high: float = math.inf) -> np.ndarray:
    """`value` as whole numbers from `low` to below `high`, any shape. Raises InputError."""
    array = np.asarray(value)
    if array.size == 0:
        return array.astype(np.int64)
    if array.dtype.kind not in "iu":
        raise InputError(f"{name} holds {array.dtype} values: whole numbers are needed")
    lowest, highest = array.min(), array.max()
    if lowest < low or highest >= high:
        outlier = lowest if lowest < low else highest
        upper_bound = "" if high == math.inf else f" and < {high:g}"
        raise InputError(f"{name} holds {outlier}: whole numbers >= {low}{upper_bound} are needed")
    return array.astype(np.int64, copy=False)


def labels_of(value: Any) -> np.ndarray:
    """`value` as the group of each agent, int (N,), -1 for one that is in none. Raises
    InputError."""
    array = integers("labels", value, -1)
    if array.ndim != 1:
        raise InputError(f"labels have shape {array.shape}: (N,) is needed")
    return array


def pairs(value: Any, n: int) -> np.ndarray:
    """`value` as pairs of rows of n agents, int (M, 2). Raises InputError."""
    array = integers("links", value, 0, n)
    if array.size == 0:
        return array.reshape(0, 2)
    if array.ndim != 2 or array.shape[1] != 2:
        raise InputError(
            f"links have shape {array.shape}: (M, 2) is needed, two rows for each pair"
        )
    return array


def flags(name: str, value: Any) -> np.ndarray:
    """`value` as yes or no for each row, bool (N,); 0 and 1 do. Raises InputError."""
    array = np.asarray(value)
    if array.ndim != 1:
        raise InputError(f"{name} has shape {array.shape}: (N,) is needed")
    if array.dtype != bool and not (array.dtype.kind in "iu" and np.isin(array, (0, 1)).all()):
        if array.size == 0:
            return np.zeros(0, bool)
        raise InputError(f"{name} holds {array.dtype} values: True or False is needed")
    return array.astype(bool, copy=False)


def same_length(**arrays: np.ndarray) -> None:
    """Refuse arrays of which one has more rows than another."""
    counts = {name: len(array) for name, array in arrays.items()}
    if len(set(counts.values())) > 1:
        each = ", ".join(f"{name} {count}" for name, count in counts.items())
        raise InputError(f"arrays do not match in their numbers of rows: {each}")


@compile_to_disk
def check_headings(rows):
    """The sum of all squares of vectors (N, 2) or (N, 3), and how many of them are no headings."""
    total, bad_count = 0.0, 0
    if rows.shape[1] == 2:
        for i in range(np.uintp(rows.shape[0])):
            square = rows[i, 0] * rows[i, 0] + rows[i, 1] * rows[i, 1]
            total += square
            bad_count += 0 if (square >= SHORTEST) & (square <= LONGEST) else 1
    else:
        for i in range(np.uintp(rows.shape[0])):
            square = rows[i, 0] * rows[i, 0] + rows[i, 1] * rows[i, 1] + rows[i, 2] * rows[i, 2]
            total += square
            bad_count += 0 if (square >= SHORTEST) & (square <= LONGEST) else 1
    return total, bad_count


def is_finite(array: np.ndarray) -> bool:
    """Whether all of an array are numbers."""
    if math.isfinite(np.vdot(array, array)):
        return True  # beyond 1e150 the square of a number is not one, and all are looked at
    return bool(np.isfinite(array).all())


def finite_rows(*arrays: np.ndarray) -> np.ndarray:
    """The rows of which all that arrays (N, ...) have are numbers, (N,) bool."""
    fine = [np.isfinite(array).reshape(len(array), -1).all(axis=1) for array in arrays]
    return np.logical_and.reduce(fine)


def drop_bad_rows(**arrays: np.ndarray) -> tuple[Any, ...]:
    """Arrays (N, ...) without the rows of which one of them is no number; warns of these.

    Returns which rows stay, (N,) bool, or None for all, and the arrays. Vectors must have the same
    number of axes. Raises InputError.
    """
    same_length(**arrays)
    shapes = {array.shape[1:] for array in arrays.values()}
    if len(shapes) > 1:
        each = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise InputError(f"arrays do not match in their shapes: {each}")
    if all(is_finite(array) for array in arrays.values()):
        return None, *arrays.values()
    finite = finite_rows(*arrays.values())
    warn_of_omitted(int((~finite).sum()), len(finite), ", ".join(arrays))
    return finite, *(array[finite] for array in arrays.values())


def spread(finite: np.ndarray | None, values: np.ndarray, filler: Any) -> np.ndarray:
    """What was found row by row, with `filler` for the rows that were left out."""
    if finite is None:
        return values
    all_rows = np.full((len(finite), *values.shape[1:]), filler, values.dtype)
    all_rows[finite] = values
    return all_rows


def headings(value: Any) -> np.ndarray:
    """Headings (N, dim) without the rows that are not numbers; warns of these. Raises
    InputError."""
    heading = vectors("heading", value)
    if check_headings(np.ascontiguousarray(heading))[1] == 0:
        return heading
    return units(drop_bad_rows(heading=heading)[1])


def units(heading: np.ndarray) -> np.ndarray:
    """Refuse finite headings (N, dim) that are no unit vectors, such as velocities; or return them.

    A heading of an agent that stands is no number: nan leaves its row out, zeros are refused.
    """
    if check_headings(np.ascontiguousarray(heading))[1]:
        lengths = np.linalg.norm(heading, axis=1)
        bad_length = lengths[np.argmax(np.abs(lengths - 1.0))]
        raise InputError(
            f"heading has a row of length {bad_length:.4g}: unit vectors are needed, or nan for an "
            "agent that has no direction"
        )
    return heading


def box(size: Any, images: Any, dim: int) -> tuple[np.ndarray, np.ndarray]:
    """The sides of a box, floats (dim,) > 0, and the axes seen across the seam, bool (dim,).

    Raises InputError.
    """
    sides, image_axes = numbers("size", size), np.asarray(images)
    if sides.shape != (dim,):
        raise InputError(f"size has shape {sides.shape}: ({dim},) is needed, a side for each axis")
    for side in sides.tolist():
        if not 0.0 < side < math.inf:
            raise InputError(f"size = {sides.tolist()} is not allowed: each side is a length > 0")
    if image_axes.shape != (dim,) or image_axes.dtype.kind not in "biu":
        raise InputError(
            f"images has shape {image_axes.shape} and holds {image_axes.dtype} values: "
            f"({dim},) True or False is needed"
        )
    return sides, image_axes.astype(bool, copy=False)


def length(name: str, value: Any, positive: bool = False) -> float:
    """`value` as a finite number >= 0, or > 0 if `positive`. Raises InputError."""
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not 0.0 <= number < math.inf or (positive and number == 0.0):
        bound = "> 0" if positive else ">= 0"
        raise InputError(f"{name} = {value!r} is not allowed: a finite number {bound} is needed")
    return number
