"""What the pages of a Parquet file unpack to, by their own headers, before any is unpacked.

A footer says it too, but a reader makes room for what the header of each page says. Headers are
Thrift structs in its compact protocol: https://github.com/apache/parquet-format.
"""

from __future__ import annotations

MOST_PAGES = 20_000
"""Pages of a column chunk."""
UNPACKED, PACKED = 2, 3
"""Fields of a page's header: bytes of its content unpacked, and in the file."""
TRUE, FALSE, BYTE, INTEGERS, DOUBLE, BINARY = 1, 2, 3, (4, 5, 6), 7, 8
LISTS, STRUCT = (9, 10), 12
DEEPEST = 8
"""Structs and lists within each other."""


class Damaged(ValueError):
    """It is no sound Parquet file."""


def unpacked_bytes(content: bytes) -> int:
    """Bytes that the pages of a column chunk (its `content`, as it lies in the file) unpack to.

    Raises Damaged for headers that are none, and for more pages than anybody writes.
    """
    total = pages = at = 0
    while at < len(content):
        header = Header(content, at)
        packed, unpacked = header.fields.get(PACKED, -1), header.fields.get(UNPACKED, -1)
        pages += 1
        if packed < 0 or unpacked < 0 or pages > MOST_PAGES:
            raise Damaged
        total += unpacked
        at = header.at + packed
    return total


class Header:
    """The integers of a struct that begins at a byte of `content`, and where it ends."""

    def __init__(self, content: bytes, at: int):
        self.content = content
        self.at = at
        self.fields: dict[int, int] = {}
        self.struct(0, self.fields)

    def byte(self) -> int:
        """The next byte. Raises Damaged at the end."""
        if not 0 <= self.at < len(self.content):
            raise Damaged
        self.at += 1
        return self.content[self.at - 1]

    def number(self) -> int:
        """A number of seven bits in each byte."""
        value = 0
        for shift in range(0, 70, 7):
            more = self.byte()
            value |= (more & 0x7F) << shift
            if more < 0x80:
                return value
        raise Damaged

    def signed(self) -> int:
        """A number whose last bit is its sign."""
        value = self.number()
        return (value >> 1) ^ -(value & 1)

    def struct(self, depth: int, fields: dict[int, int] | None = None) -> None:
        """Read over a struct; `fields` takes its integers."""
        field = 0
        while head := self.byte():
            field = field + (head >> 4) if head >> 4 else self.signed()
            kind = head & 0x0F
            if kind in INTEGERS:
                value = self.signed()
                if fields is not None:
                    fields[field] = value
            elif kind not in (TRUE, FALSE):  # which have no bytes of their own in a struct
                self.skip(kind, depth + 1)

    def skip(self, kind: int, depth: int) -> None:
        """Read over a value. Raises Damaged for what page headers do not have."""
        if depth > DEEPEST:
            raise Damaged
        if kind in (TRUE, FALSE, BYTE):
            self.at += 1
        elif kind in INTEGERS:
            self.number()
        elif kind == DOUBLE:
            self.at += 8
        elif kind == BINARY:
            length = self.number()
            self.at += length
        elif kind in LISTS:
            head = self.byte()
            count = self.number() if head >> 4 == 15 else head >> 4
            for _ in range(min(count, len(self.content))):
                self.skip(head & 0x0F, depth + 1)
        elif kind == STRUCT:
            self.struct(depth)
        else:
            raise Damaged
