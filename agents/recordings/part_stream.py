"""Read the `.part` of a recording batch by batch: an Arrow stream that anybody may have made.

A batch is judged by its own header before room is made for it: what its length says, whether it is
packed, how many rows it claims. Arrow believes what stands in a batch, so every batch is
validated in full before anything looks at its values. https://arrow.apache.org/docs/format has
Message.fbs, of which the few numbers that are needed are read here.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from agents.recordings.parquet_footer import EXTENSION, MOST_COLUMNS
from agents.recordings.parquet_table import (
    LONGEST,
    MOST_BYTES,
    MOST_METADATA,
    MOST_NUMBERS,
    is_text,
)
from worlds.input_error import InputError, shorten

BEGIN = b"\xff\xff\xff\xff"
"""Begins every message."""
SCHEMA, BATCH = 1, 3
"""Kinds of messages: which columns there are, and rows of them."""
MOST_HEADER = 2 * MOST_METADATA
"""Bytes of what a message says of itself."""
MOST_WAITING = 2**28
"""Bytes of batches that are kept until they are enough rows to be written together."""
NO_STREAM = "is not a recording that flockscope has begun"


class PartStream:
    """The schema and the whole batches of a `.part` that is open; `longest`: bytes of a text in it.

    Raises InputError for what is no such stream, and OSError.

    Attributes
    ----------
    schema: of pyarrow.
    """

    def __init__(self, path: Path, file: BinaryIO, longest: int = LONGEST):
        import pyarrow as pa

        self.origin = repr(str(path))
        self.file = file
        self.longest = longest
        self.size = os.fstat(file.fileno()).st_size
        first = self.message()
        if first is None or first.kind != SCHEMA or EXTENSION in first.content:
            raise InputError(f"{self.origin} {NO_STREAM}")
        try:
            self.schema = pa.ipc.read_schema(pa.BufferReader(first.content))
            self.demand_columns(pa)
        except (pa.ArrowException, ValueError, OSError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"{self.origin} {NO_STREAM}") from None

    def demand_columns(self, pa: Any) -> None:
        """Raise InputError for a stream that no recording has."""
        texts = self.schema.metadata or {}
        if sum(map(len, texts.values())) > MOST_METADATA:
            raise InputError(
                f"the metadata of {self.origin} has more than {MOST_METADATA} bytes, "
                "the most that is read"
            )
        if not 0 < len(self.schema) <= MOST_COLUMNS:
            raise InputError(f"{self.origin} {NO_STREAM}")
        for field in self.schema:
            kind = field.type
            if pa.types.is_fixed_size_list(kind):
                kind = kind.value_type
            numbers = (pa.types.is_integer, pa.types.is_floating, pa.types.is_boolean, is_text)
            if not any(is_number(kind) for is_number in numbers):
                raise InputError(
                    f"{self.origin}: its column {shorten(field.name)} holds neither numbers "
                    "nor text"
                )
            if self.schema.names.count(field.name) > 1:
                raise InputError(f"{self.origin} has the column {shorten(field.name)} twice")

    def message(self) -> Message | None:
        """The next message; None where no whole one follows. Raises InputError, OSError."""
        begin = self.file.read(8)
        length = int.from_bytes(begin[4:], "little")
        if len(begin) < 8 or begin[:4] != BEGIN or not 0 < length <= self.remaining_bytes:
            return None
        if length > MOST_HEADER:
            raise self.size_error(f"a header of {length} bytes", MOST_HEADER)
        header = self.file.read(length)
        try:
            reply = Message(header)
        except (struct.error, ValueError):
            return None
        if not 0 <= reply.length <= self.remaining_bytes:
            return None
        if reply.length > MOST_BYTES:
            raise self.size_error(f"a batch of {reply.length} bytes", MOST_BYTES)
        reply.content = begin + header + self.file.read(reply.length)
        return reply

    @property
    def remaining_bytes(self) -> int:
        """Bytes that have not been read."""
        return self.size - self.file.tell()

    def batches(self, rows: int) -> Iterator[Any]:
        """Its rows as record batches of at least so many rows, but for the last, and for those
        after which more than `MOST_WAITING` bytes wait.

        They end where no whole batch follows: a kill leaves the last one unfinished. Raises
        InputError, OSError.
        """
        import pyarrow as pa

        waiting: list[Any] = []
        count = size = 0
        while (batch := self.read_batch()) is not None:
            if batch.num_rows:
                waiting.append(batch)
                count += batch.num_rows
                size += batch.nbytes
            if count >= rows or size > MOST_WAITING:  # few rows may hold long texts
                yield from pa.Table.from_batches(waiting).combine_chunks().to_batches()
                waiting, count, size = [], 0, 0
        if waiting:
            yield from pa.Table.from_batches(waiting).combine_chunks().to_batches()

    def read_batch(self) -> Any:
        """The next record batch; None where no sound one follows. Raises InputError, OSError."""
        import pyarrow as pa
        import pyarrow.compute as pc

        message = self.message()
        if message is None or message.kind != BATCH:
            return None
        if message.is_packed:
            raise InputError(f"{self.origin} has packed batches, and flockscope writes none")
        if message.rows * len(self.schema) > MOST_NUMBERS:
            raise self.size_error(
                f"a batch of {message.rows} rows", MOST_NUMBERS // len(self.schema)
            )
        try:
            content = pa.ipc.read_message(pa.BufferReader(message.content))
            batch = pa.ipc.read_record_batch(content, self.schema)
            batch.validate(full=True)
        except (pa.ArrowException, OSError, ValueError):
            return None
        for column in batch.columns:
            if is_text(column.type) and (
                (pc.max(pc.binary_length(column)).as_py() or 0) > self.longest
            ):
                raise InputError(f"{self.origin}: a text of it is longer than {self.longest} bytes")
        return batch

    def size_error(self, thing: str, limit: int) -> InputError:
        """The refusal for more than is read together."""
        return InputError(f"{self.origin} holds {thing}: at most {limit} are read at once")


class Message:
    """What the header of a message says of it. Raises ValueError or struct.error if it is none.

    Attributes
    ----------
    kind: SCHEMA, BATCH or another. length: bytes that follow the header. rows: of a batch.
    is_packed: whether its columns are. content: all its bytes, once they are read.
    """

    def __init__(self, header: bytes):
        self.header = header
        self.content = b""
        root = self.unpack("<I", 0)
        self.kind = self.field(root, 1, "<B")
        self.length = self.field(root, 3, "<q")
        self.rows, self.is_packed = 0, False
        if self.kind == BATCH and (place := self.place(root, 2)):
            batch = place + self.unpack("<I", place)
            self.rows = self.field(batch, 0, "<q")
            self.is_packed = self.place(batch, 3) != 0
        if self.rows < 0:
            raise ValueError

    def unpack(self, form: str, at: int) -> int:
        """The number at a byte."""
        if at < 0:
            raise ValueError
        value: int = struct.unpack_from(form, self.header, at)[0]
        return value

    def place(self, table: int, field: int) -> int:
        """The byte at which a field of a table stands; 0 if it is left out."""
        names = table - self.unpack("<i", table)
        if 4 + 2 * field >= self.unpack("<H", names):
            return 0
        offset = self.unpack("<H", names + 4 + 2 * field)
        return table + offset if offset else 0

    def field(self, table: int, field: int, form: str) -> int:
        """The number in a field of a table, 0 if it is left out."""
        place = self.place(table, field)
        return self.unpack(form, place) if place else 0
