"""The footer of a Parquet file that anybody may have made: judged, and written anew by ours.

A library that meets a footer with something missing may end the whole process, which no `except`
can catch. So its footer is never shown to one. What is needed is read here, checked
against the length of the file and against itself, and written down again; all else, statistics and
indexes among it, is left out. https://github.com/apache/parquet-format has `parquet.thrift`.
"""

from __future__ import annotations

import base64
import binascii
import os
from collections.abc import Iterator
from typing import Any, BinaryIO, NamedTuple

from agents.parquet_thrift import (
    BINARY,
    BYTE,
    I32,
    I64,
    TRUE,
    ParquetError,
    StructSchema,
    read_struct,
    written_struct,
)

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
    again = written_struct(FOOTER, checked(footer, start))
    return MAGIC + again + len(again).to_bytes(4, "little") + MAGIC


def checked(footer: dict[int, Any], start: int) -> dict[int, Any]:
    """What is needed of a footer that begins at byte `start` of its file. Raises Damaged."""
    if not {VERSION, SCHEMA, ROWS, GROUPS} <= footer.keys() or ENCRYPTION in footer:
        raise ParquetError
    leaves = list(leaves_of(footer[SCHEMA]))
    groups = [checked_group(group, leaves, start) for group in footer[GROUPS]]
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
    left: list[tuple[int, list[bytes], bool]] = [(elements[0].get(CHILDREN, 0), [], False)]
    """Of each group that is open: how many are still to come in it, its path, its repetition."""
    if left[0][0] < 1:
        raise ParquetError
    for element in elements[1:]:
        if not left or len(left) > DEEPEST_COLUMN:
            raise ParquetError
        to_come, above, repeated = left.pop()
        if to_come > 1:
            left.append((to_come - 1, above, repeated))
        demand_element(element)
        path = [*above, element[NAME]]
        repeated = repeated or element[REPETITION] == REPEATED
        if KIND in element:
            yield Leaf(element[KIND], path, repeated)
        else:
            left.append((element[CHILDREN], path, repeated))
    if left:
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


def checked_group(group: dict[int, Any], leaves: list[Leaf], start: int) -> dict[int, Any]:
    """What is needed of a row group, which must have every column. Raises Damaged."""
    rows, chunks = group.get(GROUP_ROWS, -1), group.get(CHUNKS, [])
    if rows < 0 or len(chunks) != len(leaves):
        raise ParquetError
    made = [
        checked_chunk(chunk, leaf, rows, start) for chunk, leaf in zip(chunks, leaves, strict=True)
    ]
    total = sum(chunk[META][UNPACKED] for chunk in made)
    return {CHUNKS: made, BYTES: min(total, 2**62), GROUP_ROWS: rows}


def checked_chunk(chunk: dict[int, Any], leaf: Leaf, rows: int, start: int) -> dict[int, Any]:
    """What is needed of the values of a column in a row group. Raises Damaged."""
    content = chunk.get(META, {})
    if not {KIND, CODEC, VALUES, UNPACKED, PACKED, DATA} <= content.keys():
        raise ParquetError
    if chunk.get(ELSEWHERE) or CRYPTED in chunk or CRYPTED_META in chunk:
        raise ParquetError
    if content[KIND] != leaf.kind or content[CODEC] not in CODECS:
        raise ParquetError
    if any(one not in CODINGS for one in content.get(ENCODINGS, [])):
        raise ParquetError
    values, unpacked, packed = content[VALUES], content[UNPACKED], content[PACKED]
    if values < 0 or unpacked < 0 or (values != rows and not leaf.is_repeated):
        raise ParquetError
    data = content[DATA]
    first = min(data, content.get(DICTIONARY) or data)  # some write 0 for none
    if first < len(MAGIC) or packed < 0 or max(data, first + packed) > start:
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
