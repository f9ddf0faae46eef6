"""Thrift's compact protocol, in which footers and page headers of Parquet are written.

What stands in a struct is declared: a `Shape` names the fields that are read, everything else is
read over. https://github.com/apache/thrift/blob/master/doc/specs/thrift-compact-protocol.md
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

TRUE, FALSE, BYTE, I16, I32, I64, DOUBLE, BINARY, LIST, SET, MAP, STRUCT = range(1, 13)
INTEGERS = (I16, I32, I64)
BITS = {I16: 16, I32: 32, I64: 64}
DEEPEST = 16
"""Structs and lists within each other."""


class Damaged(ValueError):
    """It is no sound Parquet file."""


class Shape(NamedTuple):
    """The fields of a struct that are read: by number the kind of each.

    A kind is one of the protocol's numbers (TRUE: a boolean), a shape, or a list of one of these.
    """

    fields: Mapping[int, Any]


class ThriftReader:
    """Reads structs from the bytes of `content`, from byte `at` on."""

    def __init__(self, content: bytes, at: int = 0):
        self.content = content
        self.at = at

    def byte(self) -> int:
        """The next byte. Raises Damaged at the end."""
        if not 0 <= self.at < len(self.content):
            raise Damaged
        self.at += 1
        return self.content[self.at - 1]

    def number(self) -> int:
        """A number of seven bits in each byte, below 2^64."""
        value = self.byte()
        if value < 0x80:
            return value
        value &= 0x7F
        for shift in range(7, 70, 7):
            more = self.byte()
            value |= (more & 0x7F) << shift
            if more < 0x80:
                if value >> 64:
                    raise Damaged
                return value
        raise Damaged

    def signed(self, bits: int = 64) -> int:
        """A number whose last bit is its sign. Raises Damaged for one of more bits."""
        value = self.number()
        if value >> bits:
            raise Damaged
        return (value >> 1) ^ -(value & 1)

    def binary(self) -> bytes:
        """Bytes that begin with their length."""
        end = self.number() + self.at
        if end > len(self.content):
            raise Damaged
        found = self.content[self.at : end]
        self.at = end
        return found

    def count(self) -> tuple[int, int]:
        """How many values a list has, and of which kind. Raises Damaged for more than can be."""
        head = self.byte()
        count = self.number() if head >> 4 == 15 else head >> 4
        if count > len(self.content) - self.at:  # each has a byte at least
            raise Damaged
        return count, head & 0x0F

    def struct(self, shape: Shape, depth: int = 0) -> dict[int, Any]:
        """The fields of a struct by their numbers, of those that its shape has.

        Raises Damaged for a field that is there twice or has another kind.
        """
        if depth > DEEPEST:
            raise Damaged
        found: dict[int, Any] = {}
        field = 0
        while head := self.byte():
            field = field + (head >> 4) if head >> 4 else self.signed(16)
            kind = head & 0x0F
            wanted = shape.fields.get(field)
            if wanted is None:
                if kind not in (TRUE, FALSE):  # which have no bytes of their own in a struct
                    self.skip(kind, depth + 1)
            elif field in found:
                raise Damaged
            elif kind in (TRUE, FALSE) and wanted == TRUE:
                found[field] = kind == TRUE
            else:
                found[field] = self.value(kind, wanted, depth + 1)
        return found

    def value(self, kind: int, wanted: Any, depth: int) -> Any:
        """A value of a kind, which must be the one that is wanted."""
        if kind in INTEGERS and kind == wanted:
            return self.signed(BITS[kind])
        if kind == BINARY == wanted:
            return self.binary()
        if kind == BYTE == wanted:
            return self.byte()
        if kind == STRUCT and isinstance(wanted, Shape):
            return self.struct(wanted, depth)
        if kind == LIST and isinstance(wanted, list):
            count, kind = self.count()
            return [self.value(kind, wanted[0], depth + 1) for _ in range(count)]
        raise Damaged

    def skip(self, kind: int, depth: int) -> None:
        """Read over a value. Raises Damaged for what Parquet does not have."""
        if depth > DEEPEST:
            raise Damaged
        if kind in (TRUE, FALSE, BYTE):
            self.at += 1
        elif kind in INTEGERS:
            self.number()
        elif kind == DOUBLE:
            self.at += 8
        elif kind == BINARY:
            self.binary()
        elif kind in (LIST, SET):
            count, kind = self.count()
            for _ in range(count):
                self.skip(kind, depth + 1)
        elif kind == STRUCT:
            self.struct(NOTHING, depth)
        else:
            raise Damaged


NOTHING = Shape({})
"""Of a struct that is read over."""


def written_struct(shape: Shape, values: Mapping[int, Any]) -> bytes:
    """A struct of these fields, as `ThriftReader.struct` reads it."""
    out = bytearray()
    write_struct(out, shape, values)
    return bytes(out)


def write_struct(out: bytearray, shape: Shape, values: Mapping[int, Any]) -> None:
    """Append a struct of these fields, all of which are of its shape."""
    last = 0
    for field, value in sorted(values.items()):
        wanted = shape.fields[field]
        kind = kind_of(wanted, value)
        step = field - last
        if step < 16:
            out.append(step << 4 | kind)
        else:
            out.append(kind)
            write_number(out, field << 1)
        last = field
        if kind not in (TRUE, FALSE):
            write_value(out, wanted, value)
    out.append(0)


def kind_of(wanted: Any, value: Any) -> int:
    """The protocol's number for a value of a declared kind."""
    if isinstance(wanted, Shape):
        return STRUCT
    if isinstance(wanted, list):
        return LIST
    return FALSE if wanted == TRUE and not value else int(wanted)


def write_value(out: bytearray, wanted: Any, value: Any) -> None:
    """Append a value of a declared kind."""
    if isinstance(wanted, Shape):
        write_struct(out, wanted, value)
    elif isinstance(wanted, list):
        kind = kind_of(wanted[0], True)
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
