"""Thrift's compact protocol, in which footers and page headers of Parquet are written.

What stands in a struct is declared: a `StructSchema` names the fields that are read, everything
else is read over. https://github.com/apache/thrift/blob/master/doc/specs/thrift-compact-protocol.md
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

TRUE, FALSE, BYTE, I16, I32, I64, DOUBLE, BINARY, LIST, SET, MAP, STRUCT = range(1, 13)
BITS = {I16: 16, I32: 32, I64: 64}
DEEPEST = 16
"""Structs and lists within each other."""
MOST_STRUCTS = 2**20
"""Structs that are kept: half a gigabyte, and the footer of a recording of 800 000 000 rows."""


class ParquetError(ValueError):
    """It is no sound Parquet file."""


class StructSchema(NamedTuple):
    """The fields of a struct that are read: by number the kind of each.

    A kind is one of the protocol's numbers (TRUE: a boolean), a shape, or a list of one of these.
    """

    fields: Mapping[int, Any]


NOTHING = StructSchema({})
"""Of a struct that is read over."""


def read_struct(content: bytes, at: int, shape: StructSchema) -> tuple[dict[int, Any], int]:
    """The fields, by their numbers, of a struct that begins at a byte; and where it ends.

    Of the fields only those that its shape has. Raises Damaged for one that is there twice or has
    another kind, and for what is no struct.
    """
    try:
        return struct(content, at, shape, 0, [MOST_STRUCTS])
    except IndexError:  # the bytes have an end
        raise ParquetError from None


def struct(
    content: bytes, at: int, shape: StructSchema, depth: int, left: list[int]
) -> tuple[dict[int, Any], int]:
    """As `read_struct`, `depth` structs and lists down, of which `left[0]` may still come.

    Raises IndexError at the end of the bytes.

    A footer of a long recording has a million fields: what most of them are is read in place.
    """
    if shape is not NOTHING:  # which takes no memory
        left[0] -= 1
    if depth > DEEPEST or left[0] < 0:
        raise ParquetError
    fields = shape.fields
    found: dict[int, Any] = {}
    field = 0
    while head := content[at]:
        at += 1
        kind: Any = head & 0x0F
        if head > 0x0F:
            field += head >> 4
        else:
            field, at = signed(content, at, I16)
        wanted = fields.get(field)
        value: Any
        if kind in BITS:
            value = content[at]
            at += 1
            if value > 0x7F:
                value, at = number(content, at - 1)
                if value >> BITS[kind]:
                    raise ParquetError
            value = (value >> 1) ^ -(value & 1)
        elif kind == BINARY:
            value, at = binary(content, at)
        elif kind <= FALSE:  # which has no bytes of its own in a struct
            value, kind = kind == TRUE, TRUE
        elif kind == BYTE:
            value = content[at]
            at += 1
        elif kind == STRUCT:
            inner = wanted if isinstance(wanted, StructSchema) else NOTHING
            value, at = struct(content, at, inner, depth + 1, left)
            kind = wanted if inner is wanted else kind
        elif kind == LIST and isinstance(wanted, list):
            value, at = items(content, at, wanted[0], depth + 1, left)
            kind = wanted
        else:
            value, at = skipped(content, at, kind, depth + 1, left)
        if wanted is not None:
            if field in found or kind != wanted:
                raise ParquetError
            found[field] = value
    return found, at + 1


def number(content: bytes, at: int) -> tuple[int, int]:
    """A number of seven bits in each byte, below 2^64; and where it ends."""
    value = 0
    for shift in range(0, 70, 7):
        more = content[at]
        at += 1
        value |= (more & 0x7F) << shift
        if more < 0x80:
            if value >> 64:
                raise ParquetError
            return value, at
    raise ParquetError


def signed(content: bytes, at: int, kind: int) -> tuple[int, int]:
    """A number of a kind whose last bit is its sign; and where it ends."""
    value, at = number(content, at)
    if value >> BITS[kind]:
        raise ParquetError
    return (value >> 1) ^ -(value & 1), at


def binary(content: bytes, at: int) -> tuple[bytes, int]:
    """Bytes that begin with their length; and where they end."""
    length = content[at]
    at += 1
    if length > 0x7F:
        length, at = number(content, at - 1)
    end = at + length
    if end > len(content):
        raise ParquetError
    return content[at:end], end


def count(content: bytes, at: int) -> tuple[int, int, int]:
    """How many values a list has, of which kind, and where they begin."""
    head = content[at]
    at += 1
    size = head >> 4
    if size == 15:
        size, at = number(content, at)
    if size > len(content) - at:  # each has a byte at least
        raise ParquetError
    return size, head & 0x0F, at


def items(
    content: bytes, at: int, wanted: Any, depth: int, left: list[int]
) -> tuple[list[Any], int]:
    """The values of a list, all of the kind that is wanted; and where it ends."""
    size, kind, at = count(content, at)
    found: list[Any] = []
    if kind != kind_of(wanted):
        if size:
            raise ParquetError
        return found, at
    for _ in range(size):
        value: Any
        if kind == STRUCT:
            value, at = struct(content, at, wanted, depth, left)
        elif kind == BINARY:
            value, at = binary(content, at)
        else:
            value, at = signed(content, at, kind)
        found.append(value)
    return found, at


def skipped(content: bytes, at: int, kind: int, depth: int, left: list[int]) -> tuple[None, int]:
    """Nothing, and where a value ends that is read over. Raises Damaged for no kind of Parquet."""
    if depth > DEEPEST:
        raise ParquetError
    if kind in (TRUE, FALSE, BYTE):
        at += 1
    elif kind in BITS:
        _, at = number(content, at)
    elif kind == DOUBLE:
        at += 8
    elif kind == BINARY:
        _, at = binary(content, at)
    elif kind in (LIST, SET):
        size, kind, at = count(content, at)
        for _ in range(size):
            _, at = skipped(content, at, kind, depth + 1, left)
    elif kind == STRUCT:
        _, at = struct(content, at, NOTHING, depth, left)
    else:
        raise ParquetError
    return None, at


def written_struct(shape: StructSchema, values: Mapping[int, Any]) -> bytes:
    """A struct of these fields, all of which are of its shape, as `read_struct` reads it."""
    out = bytearray()
    write_struct(out, shape, values)
    return bytes(out)


def write_struct(out: bytearray, shape: StructSchema, values: Mapping[int, Any]) -> None:
    """Append a struct of these fields."""
    last = 0
    for field, value in sorted(values.items()):
        wanted = shape.fields[field]
        kind = FALSE if value is False else kind_of(wanted)
        out.append((field - last) << 4 | kind)  # no field here is sixteen after another
        last = field
        if kind in BITS:
            write_number(out, value << 1 if value >= 0 else (-value << 1) - 1)
        elif kind > FALSE:
            write_value(out, wanted, value)
    out.append(0)


def kind_of(wanted: Any) -> int:
    """The protocol's number for a declared kind."""
    if isinstance(wanted, int):
        return wanted
    return STRUCT if isinstance(wanted, StructSchema) else LIST


def write_value(out: bytearray, wanted: Any, value: Any) -> None:
    """Append a value of a declared kind."""
    if isinstance(wanted, StructSchema):
        write_struct(out, wanted, value)
    elif isinstance(wanted, list):
        kind = kind_of(wanted[0])
        if len(value) < 15:
            out.append(len(value) << 4 | kind)
        else:
            out.append(0xF0 | kind)
            write_number(out, len(value))
        for each in value:
            write_value(out, wanted[0], each)
    elif wanted == BINARY:
        write_number(out, len(value))
        out += value
    elif wanted == BYTE:
        out.append(value)
    else:
        write_number(out, value << 1 if value >= 0 else (-value << 1) - 1)


def write_number(out: bytearray, value: int) -> None:
    """Append a number of seven bits in each byte."""
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
