"""Check the footer of a Parquet file that anybody may have made, and write it anew.

A library that meets a footer with something missing may end the whole process, which no `except`
can catch. So its footer is never shown to one. What is needed is read here, checked
against the length of the file and against itself, and written down again; all else, statistics and
indexes among it, is left out. https://github.com/apache/parquet-format has `parquet.thrift`.
"""

from __future__ import annotations

import base64
import binascii
import os
from collections.abc import Iterator, Mapping
from typing import Any, BinaryIO, NamedTuple

# Thrift's compact protocol, in which footers and page headers of Parquet are written.
#
# What stands in a struct is declared: a `StructSchema` names the fields that are read, everything
# else is read over. https://github.com/apache/thrift/blob/master/doc/specs/thrift-compact-
# protocol.md

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
    content: bytes, at: int, shape: StructSchema, depth: int, budget: list[int]
) -> tuple[dict[int, Any], int]:
    """As `read_struct`, `depth` structs and lists down, of which `left[0]` may still come.

    Raises IndexError at the end of the bytes.

    A footer of a long recording has a million fields: what most of them are is read in place.
    """
    if shape is not NOTHING:  # which takes no memory
        budget[0] -= 1
    if depth > DEEPEST or budget[0] < 0:
        raise ParquetError
    fields = shape.fields
    values: dict[int, Any] = {}
    field = 0
    while head := content[at]:
        at += 1
        kind: Any = head & 0x0F
        if head > 0x0F:
            field += head >> 4
        else:
            field, at = signed(content, at, I16)
        field_kind = fields.get(field)
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
            inner = field_kind if isinstance(field_kind, StructSchema) else NOTHING
            value, at = struct(content, at, inner, depth + 1, budget)
            kind = field_kind if inner is field_kind else kind
        elif kind == LIST and isinstance(field_kind, list):
            value, at = items(content, at, field_kind[0], depth + 1, budget)
            kind = field_kind
        else:
            value, at = skip_value(content, at, kind, depth + 1, budget)
        if field_kind is not None:
            if field in values or kind != field_kind:
                raise ParquetError
            values[field] = value
    return values, at + 1


def number(content: bytes, at: int) -> tuple[int, int]:
    """A number of seven bits in each byte, below 2^64; and where it ends."""
    value = 0
    for shift in range(0, 70, 7):
        byte = content[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
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
    content: bytes, at: int, item_kind: Any, depth: int, budget: list[int]
) -> tuple[list[Any], int]:
    """The values of a list, all of the kind that is wanted; and where it ends."""
    size, kind, at = count(content, at)
    values: list[Any] = []
    if kind != kind_of(item_kind):
        if size:
            raise ParquetError
        return values, at
    for _ in range(size):
        value: Any
        if kind == STRUCT:
            value, at = struct(content, at, item_kind, depth, budget)
        elif kind == BINARY:
            value, at = binary(content, at)
        else:
            value, at = signed(content, at, kind)
        values.append(value)
    return values, at


def skip_value(
    content: bytes, at: int, kind: int, depth: int, budget: list[int]
) -> tuple[None, int]:
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
            _, at = skip_value(content, at, kind, depth + 1, budget)
    elif kind == STRUCT:
        _, at = struct(content, at, NOTHING, depth, budget)
    else:
        raise ParquetError
    return None, at


def struct_bytes(shape: StructSchema, values: Mapping[int, Any]) -> bytes:
    """A struct of these fields, all of which are of its shape, as `read_struct` reads it."""
    out = bytearray()
    write_struct(out, shape, values)
    return bytes(out)


def write_struct(out: bytearray, shape: StructSchema, values: Mapping[int, Any]) -> None:
    """Append a struct of these fields."""
    last = 0
    for field, value in sorted(values.items()):
        field_kind = shape.fields[field]
        kind = FALSE if value is False else kind_of(field_kind)
        out.append((field - last) << 4 | kind)  # no field here is sixteen after another
        last = field
        if kind in BITS:
            write_number(out, value << 1 if value >= 0 else (-value << 1) - 1)
        elif kind > FALSE:
            write_value(out, field_kind, value)
    out.append(0)


def kind_of(field_kind: Any) -> int:
    """The protocol's number for a declared kind."""
    if isinstance(field_kind, int):
        return field_kind
    return STRUCT if isinstance(field_kind, StructSchema) else LIST


def write_value(out: bytearray, field_kind: Any, value: Any) -> None:
    """Append a value of a declared kind."""
    if isinstance(field_kind, StructSchema):
        write_struct(out, field_kind, value)
    elif isinstance(field_kind, list):
        kind = kind_of(field_kind[0])
        if len(value) < 15:
            out.append(len(value) << 4 | kind)
        else:
            out.append(0xF0 | kind)
            write_number(out, len(value))
        for each in value:
            write_value(out, field_kind[0], each)
    elif field_kind == BINARY:
        write_number(out, len(value))
        out += value
    elif field_kind == BYTE:
        out.append(value)
    else:
        write_number(out, value << 1 if value >= 0 else (-value << 1) - 1)


def write_number(out: bytearray, value: int) -> None:
    """Append a number of seven bits in each byte."""
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)


MAGIC = b"PAR1"
"""Begins and ends a Parquet file."""
LONGEST_FOOTER = 2**27
"""Bytes of a footer: recordings of 100 000 000 rows have a tenth of it."""
MOST_COLUMNS = 10_000
"""Columns of a table, the groups of nested ones among them."""
DEEPEST_COLUMN = 8
"""Groups within each other of which a column consists."""
ARROW = b"ARROW:schema"
"""The key under which Arrow keeps its own types, as a message of its own in base64."""
EXTENSION = b"ARROW:extension"
"""Stands where a type has a reader of its own, to which it hands whatever the file says."""

EMPTY = StructSchema({})
UNIT = StructSchema({1: EMPTY, 2: EMPTY, 3: EMPTY})
MOMENT = StructSchema({1: TRUE, 2: UNIT})
MEANING = StructSchema(
    dict.fromkeys((1, 2, 3, 4, 6, 11, 12, 13, 14, 15), EMPTY)
    | {
        5: StructSchema({1: I32, 2: I32}),
        7: MOMENT,
        8: MOMENT,
        10: StructSchema({1: BYTE, 2: TRUE}),
    }
)
"""What a column's values mean: text, a moment, a whole number of so many bits ..."""
KIND, LENGTH, REPETITION, NAME, CHILDREN, CONVERTED, SCALE, PRECISION, LOGICAL = (
    1, 2, 3, 4, 5, 6, 7, 8, 10,
)  # fmt: skip
ELEMENT = StructSchema(
    {
        KIND: I32, LENGTH: I32, REPETITION: I32, NAME: BINARY, CHILDREN: I32, CONVERTED: I32,
        SCALE: I32, PRECISION: I32, LOGICAL: MEANING,
    }
)  # fmt: skip
ENCODINGS, PATH, CODEC, VALUES, UNPACKED, PACKED, DATA, DICTIONARY = 2, 3, 4, 5, 6, 7, 9, 11
CONTENT = StructSchema(
    {
        KIND: I32, ENCODINGS: [I32], PATH: [BINARY], CODEC: I32, VALUES: I64, UNPACKED: I64,
        PACKED: I64, DATA: I64, DICTIONARY: I64,
    }
)  # fmt: skip
ELSEWHERE, OFFSET, META, CRYPTED, CRYPTED_META = 1, 2, 3, 8, 9
CHUNK = StructSchema(
    {ELSEWHERE: BINARY, OFFSET: I64, META: CONTENT, CRYPTED: EMPTY, CRYPTED_META: BINARY}
)
CHUNKS, BYTES, GROUP_ROWS = 1, 2, 3
GROUP = StructSchema({CHUNKS: [CHUNK], BYTES: I64, GROUP_ROWS: I64})
KEY, VALUE = 1, 2
PAIR = StructSchema({KEY: BINARY, VALUE: BINARY})
VERSION, SCHEMA, ROWS, GROUPS, PAIRS, ENCRYPTION = 1, 2, 3, 4, 5, 8
FOOTER = StructSchema(
    {VERSION: I32, SCHEMA: [ELEMENT], ROWS: I64, GROUPS: [GROUP], PAIRS: [PAIR], ENCRYPTION: EMPTY}
)

FIXED = 7
"""The kind of column whose values have one length."""
KINDS, CODECS, CODINGS, REPETITIONS, MEANINGS = range(8), range(8), range(10), range(3), range(22)
REPEATED = 2
"""The repetition of a column that has any number of values in a row."""
LONGEST_VALUE = 2**16
"""Bytes of a value of a column whose values have one length."""


class Leaf(NamedTuple):
    """A column that has values."""

    kind: int
    path: list[bytes]
    is_repeated: bool
    """Whether a row may have several values."""


def sound_footer(file: BinaryIO) -> bytes:
    """A Parquet file of a footer alone, which says of `file` what its own footer says.

    Raises Damaged for a footer that is none, LookupError for a file that has none, or OSError.
    """
    size = file.seek(0, os.SEEK_END)
    file.seek(max(size - 8, 0))
    end = file.read(8)
    length = int.from_bytes(end[:4], "little")
    file.seek(0)
    if size < 12 or end[4:] != MAGIC or file.read(4) != MAGIC or length > size - 12:
        raise LookupError
    if length > LONGEST_FOOTER:
        raise ParquetError
    start = size - 8 - length
    file.seek(start)
    footer, _ = read_struct(file.read(length), 0, FOOTER)
    content = struct_bytes(FOOTER, check_footer(footer, start))
    return MAGIC + content + len(content).to_bytes(4, "little") + MAGIC


def check_footer(footer: dict[int, Any], start: int) -> dict[int, Any]:
    """What is needed of a footer that begins at byte `start` of its file. Raises Damaged."""
    if not {VERSION, SCHEMA, ROWS, GROUPS} <= footer.keys() or ENCRYPTION in footer:
        raise ParquetError
    leaves = list(leaves_of(footer[SCHEMA]))
    groups = [check_group(group, leaves, start) for group in footer[GROUPS]]
    if footer[ROWS] < 0 or sum(group[GROUP_ROWS] for group in groups) != footer[ROWS]:
        raise ParquetError
    pairs = [pair for pair in footer.get(PAIRS, []) if is_plain(pair)]
    return {
        VERSION: footer[VERSION],
        SCHEMA: footer[SCHEMA],
        ROWS: footer[ROWS],
        GROUPS: groups,
        PAIRS: pairs,
    }


def leaves_of(elements: list[dict[int, Any]]) -> Iterator[Leaf]:
    """The columns of a table whose groups and columns stand one after another, the root first.

    Raises Damaged.
    """
    if not 1 < len(elements) <= MOST_COLUMNS or KIND in elements[0]:
        raise ParquetError
    open_groups: list[tuple[int, list[bytes], bool]] = [(elements[0].get(CHILDREN, 0), [], False)]
    """Of each group that is open: how many are still to come in it, its path, its repetition."""
    if open_groups[0][0] < 1:
        raise ParquetError
    for element in elements[1:]:
        if not open_groups or len(open_groups) > DEEPEST_COLUMN:
            raise ParquetError
        children_left, parent_path, is_repeated = open_groups.pop()
        if children_left > 1:
            open_groups.append((children_left - 1, parent_path, is_repeated))
        demand_element(element)
        path = [*parent_path, element[NAME]]
        is_repeated = is_repeated or element[REPETITION] == REPEATED
        if KIND in element:
            yield Leaf(element[KIND], path, is_repeated)
        else:
            open_groups.append((element[CHILDREN], path, is_repeated))
    if open_groups:
        raise ParquetError


def demand_element(element: dict[int, Any]) -> None:
    """Raise Damaged for what is neither a column nor a group of columns."""
    if NAME not in element or element.get(REPETITION) not in REPETITIONS:
        raise ParquetError
    if (KIND in element) == (element.get(CHILDREN, 0) > 0) or element.get(CHILDREN, 0) < 0:
        raise ParquetError
    if KIND in element and element[KIND] not in KINDS:
        raise ParquetError
    if element.get(KIND) == FIXED and not 0 < element.get(LENGTH, 0) <= LONGEST_VALUE:
        raise ParquetError
    if element.get(CONVERTED, 0) not in MEANINGS or len(element.get(LOGICAL, {0: 0})) != 1:
        raise ParquetError


def check_group(group: dict[int, Any], leaves: list[Leaf], start: int) -> dict[int, Any]:
    """What is needed of a row group, which must have every column. Raises Damaged."""
    rows, chunks = group.get(GROUP_ROWS, -1), group.get(CHUNKS, [])
    if rows < 0 or len(chunks) != len(leaves):
        raise ParquetError
    columns = [
        check_chunk(chunk, leaf, rows, start) for chunk, leaf in zip(chunks, leaves, strict=True)
    ]
    total = sum(chunk[META][UNPACKED] for chunk in columns)
    return {CHUNKS: columns, BYTES: min(total, 2**62), GROUP_ROWS: rows}


def check_chunk(chunk: dict[int, Any], leaf: Leaf, rows: int, start: int) -> dict[int, Any]:
    """What is needed of the values of a column in a row group. Raises Damaged."""
    content = chunk.get(META, {})
    if not {KIND, CODEC, VALUES, UNPACKED, PACKED, DATA} <= content.keys():
        raise ParquetError
    if chunk.get(ELSEWHERE) or CRYPTED in chunk or CRYPTED_META in chunk:
        raise ParquetError
    if content[KIND] != leaf.kind or content[CODEC] not in CODECS:
        raise ParquetError
    if any(encoding not in CODINGS for encoding in content.get(ENCODINGS, [])):
        raise ParquetError
    values, unpacked_size, packed_size = content[VALUES], content[UNPACKED], content[PACKED]
    if values < 0 or unpacked_size < 0 or (values != rows and not leaf.is_repeated):
        raise ParquetError
    data = content[DATA]
    first = min(data, content.get(DICTIONARY) or data)  # some write 0 for none
    if first < len(MAGIC) or packed_size < 0 or max(data, first + packed_size) > start:
        raise ParquetError
    return {OFFSET: 0, META: content | {ENCODINGS: content.get(ENCODINGS, []), PATH: leaf.path}}


def is_plain(pair: dict[int, Any]) -> bool:
    """Whether a pair of the metadata is left in: all but types of Arrow with readers of their own.

    Raises Damaged for what is no pair.
    """
    if KEY not in pair:
        raise ParquetError
    if pair[KEY] != ARROW:
        return True
    try:
        return EXTENSION not in base64.b64decode(pair.get(VALUE, b""), validate=True)
    except binascii.Error:
        return False
