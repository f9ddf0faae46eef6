"""Open Parquet files that anybody may have made, and read them in pieces of bounded size.

Few bytes can stand for billions of numbers, and a footer can end the process that reads it. So the
footer is judged and written anew by ours, a row group is decoded only after that and the headers of
its pages say that it is of a sensible size, a whole file never, and whatever the parsers of others
raise becomes one line.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from io import BytesIO
from itertools import accumulate
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from agents.recordings.parquet_footer import (
    I32,
    ParquetError,
    StructSchema,
    read_struct,
    sound_footer,
)
from worlds.input_error import InputError, shorten
from worlds.plug_ins import demand_parquet

# What the pages of a Parquet file unpack to, by their own headers, before any is unpacked.
#
# A footer says it too, but a reader makes room for what the header of each page says:
# https://github.com/apache/parquet-format.

MOST_PAGES = 20_000
"""Pages of a column chunk."""
UNPACKED, PACKED = 2, 3
"""Fields of a page's header: bytes of its content unpacked, and in the file."""
HEADER = StructSchema({UNPACKED: I32, PACKED: I32})


def unpacked_bytes(content: bytes) -> int:
    """Bytes that the pages of a column chunk (its `content`, as it lies in the file) unpack to.

    Raises Damaged for headers that are none, and for more pages than anybody writes.
    """
    total = pages = at = 0
    while at < len(content):
        header, begins = read_struct(content, at, HEADER)
        packed_size, unpacked_size = header.get(PACKED, -1), header.get(UNPACKED, -1)
        pages += 1
        if packed_size < 0 or unpacked_size < 0 or pages > MOST_PAGES:
            raise ParquetError
        total += unpacked_size
        at = begins + packed_size
    return total


MOST_NUMBERS = 2**27
"""Numbers that are decoded together, those of a row group or of a tick: 1 GB."""
MOST_BYTES = 2**31
"""Bytes that the pages of a row group unpack to."""
MOST_METADATA = 2**25
"""Bytes of a file's metadata: a world of 100 000 corners is a tenth of it."""
MOST_TEXT = 2**28
"""Bytes of texts that are decoded together: a word that stands once in a file may
stand in every row."""
LONGEST = 10_000
"""Bytes of a text in a table."""
BATCH = 2**18
"""Rows that are decoded together where a file is looked through."""


class ParquetTable:
    """A Parquet file, its rows read as they are asked for.

    `path` names it; `content`: its bytes where there is no file. `kind`: what it should be, for
    messages, as "a recording". `longest`: bytes of a text in it. Raises InputError for what cannot
    be read.

    Attributes
    ----------
    origin: its name for messages. names: of its columns. schema: of pyarrow. rows: how many.
    offsets: of each row group the first row, and at the end the number of all rows.
    """

    def __init__(self, path: str | Path, content: bytes | None, kind: str, longest: int = LONGEST):
        demand_parquet(f"reading {str(path)!r}")
        import pyarrow as pa
        import pyarrow.parquet as pq

        self.path, self.content, self.kind = Path(path), content, kind
        self.longest = longest
        self.origin = repr(str(path))
        try:
            with self.open() as opened:
                footer = sound_footer(opened)
            meta = pq.read_metadata(pa.BufferReader(footer))
            source = self.path if content is None else pa.BufferReader(content)
            file = pq.ParquetFile(source, metadata=meta)
            self.schema = file.schema_arrow
            self.names: list[str] = self.schema.names
            texts = [field.name for field in self.schema if is_text(field.type)]
            # Few bytes can stand for long texts in every row: they stay apart until they are
            # measured.
            if texts:
                file = pq.ParquetFile(source, metadata=meta, read_dictionary=texts)
            self.file = file
            self.meta = self.file.metadata
            self.rows: int = self.meta.num_rows
            sizes = [self.meta.row_group(k).num_rows for k in range(self.meta.num_row_groups)]
        except LookupError:
            raise self.is_none() from None
        except OSError as error:
            if error.strerror is None:  # of pyarrow, not of the disk
                raise self.damage_error("its footer cannot be read") from None
            raise InputError(f"{self.origin} cannot be read: {error.strerror}") from None
        except (pa.ArrowException, ValueError):
            raise self.damage_error("its footer cannot be read") from None
        self.offsets = np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])
        for name in self.names:
            if self.names.count(name) > 1:
                raise InputError(f"{self.origin} has the column {shorten(name)} twice")

    def open(self) -> BinaryIO:
        """Its bytes, to be read. Raises OSError."""
        return open(self.path, "rb") if self.content is None else BytesIO(self.content)

    def is_none(self) -> InputError:
        """The refusal for a file that is something else."""
        return InputError(f"{self.origin} is not {self.kind}")

    def damage_error(self, how: str = "its rows cannot be read") -> InputError:
        """The refusal for a file that is none in its inside."""
        return InputError(f"{self.origin} is damaged: {how}")

    def metadata(self, key: bytes) -> dict[str, Any]:
        """The JSON object under a key of the metadata. Raises InputError."""
        text = (self.schema.metadata or {}).get(key, b"")
        if len(text) > MOST_METADATA:
            raise InputError(
                f"the metadata of {self.origin} has {len(text)} bytes: at most {MOST_METADATA} "
                "are read"
            )
        try:
            values = json.loads(text)
        except RecursionError:
            raise InputError(f"the metadata of {self.origin} is nested too deeply") from None
        except ValueError:
            raise self.is_none() from None
        if not isinstance(values, dict):
            raise self.is_none()
        return values

    def batches(
        self, columns: Iterable[str] | None = None, rows: int = BATCH, group: int | None = None
    ) -> Iterator[Any]:
        """Record batches of some columns (all), of a row group (all), at most `rows` at once.

        Raises InputError.
        """
        names = self.names if columns is None else list(columns)
        for k in range(self.meta.num_row_groups) if group is None else (group,):
            if not self.meta.row_group(k).num_rows:
                continue
            self.demand_modest(k, names)
            count = 0
            with self.reading():
                record_batches = self.file.iter_batches(
                    rows, row_groups=[k], columns=names, use_threads=False
                )
                for batch in record_batches:
                    count += batch.num_rows
                    if batch.schema.names != names:
                        raise self.damage_error()
                    yield self.decode_texts(batch)
            if count != self.meta.row_group(k).num_rows:
                raise self.damage_error("rows are missing")

    @contextmanager
    def reading(self) -> Iterator[None]:
        """While entered, what pyarrow raises of a broken file is an InputError."""
        import pyarrow as pa

        try:
            yield
        except InputError:
            raise
        except (pa.ArrowException, OSError, ValueError, KeyError):
            raise self.damage_error() from None

    def decode_texts(self, batch: Any) -> Any:
        """A batch with its texts as texts. Raises InputError for long ones."""
        import pyarrow as pa
        import pyarrow.compute as pc

        columns, fields, size = [], [], 0
        for name, column in zip(batch.schema.names, batch.columns, strict=True):
            if pa.types.is_dictionary(column.type):
                dictionary = column.dictionary
                dictionary.validate(full=True)  # text that is no UTF-8
                if is_text(dictionary.type) and (
                    (pc.max(pc.binary_length(dictionary)).as_py() or 0) > self.longest
                ):
                    raise self.damage_error(f"a text of it is longer than {self.longest} bytes")
                if is_text(dictionary.type):
                    each = pc.cast(pc.binary_length(dictionary), pa.int64()).take(column.indices)
                    size += pc.sum(each).as_py() or 0
                    if size > MOST_TEXT:
                        raise self.damage_error(f"its texts unpack to more than {MOST_TEXT} bytes")
                column = column.dictionary_decode()
            columns.append(column)
            fields.append(self.schema.field(name).with_type(column.type))
        return pa.RecordBatch.from_arrays(columns, schema=pa.schema(fields, self.schema.metadata))

    def group(self, k: int, columns: Iterable[str] | None = None) -> Any:
        """Some columns (all) of a row group, a pyarrow Table. Raises InputError."""
        return self.table(
            self.batches(columns, max(self.meta.row_group(k).num_rows, 1), k), columns
        )

    def read(self, columns: Iterable[str] | None = None) -> Any:
        """Some columns (all), a pyarrow Table. Raises InputError for more than MOST_NUMBERS."""
        names = self.names if columns is None else list(columns)
        if self.rows * len(names) > MOST_NUMBERS:
            raise self.size_error(f"{self.rows} rows of {len(names)} columns")
        numbers = sum(self.numbers(k, names) for k in range(self.meta.num_row_groups))
        if numbers > MOST_NUMBERS:  # a row of a list has many
            raise self.size_error(f"{numbers} numbers")
        return self.table(self.batches(names), names)

    def table(self, batches: Iterable[Any], columns: Iterable[str] | None = None) -> Any:
        """Batches of some columns (all) as a pyarrow Table, which may be empty. Raises
        InputError."""
        import pyarrow as pa

        pieces, size = [], 0
        for batch in batches:
            pieces.append(batch)
            size += batch.nbytes
            if size > MOST_BYTES:
                raise self.damage_error(f"its rows unpack to more than {MOST_BYTES} bytes")
        names = self.names if columns is None else list(columns)
        none = pa.schema([self.schema.field(name) for name in names], self.schema.metadata)
        return pa.Table.from_batches(pieces, pieces[0].schema if pieces else none)

    def size_error(self, thing: str) -> InputError:
        """The refusal for more than is decoded together."""
        return InputError(
            f"{self.origin} holds {thing}: at most {MOST_NUMBERS} numbers are read at once"
        )

    def demand_modest(self, k: int, names: Iterable[str]) -> None:
        """Raise InputError for columns of a row group that unpack to too much."""
        if (numbers := self.numbers(k, names)) > MOST_NUMBERS:
            raise self.size_error(f"{numbers} numbers in a row group")
        if self.unpacked_size(k, names) > MOST_BYTES:
            raise self.damage_error("its pages unpack to too much")

    def chunks(self, k: int, names: Iterable[str]) -> list[Any]:
        """The column chunks of a row group that belong to columns."""
        wanted_names = set(names)
        with self.reading():
            group = self.meta.row_group(k)
            columns = [group.column(place) for place in range(group.num_columns)]
            return [
                column
                for column in columns
                if not wanted_names.isdisjoint(column_names(column.path_in_schema))
            ]

    def numbers(self, k: int, names: Iterable[str]) -> int:
        """Numbers in columns of a row group, by the footer."""
        rows = self.meta.row_group(k).num_rows
        return sum(max(column.num_values, rows) for column in self.chunks(k, names))

    def unpacked_size(self, k: int, names: Iterable[str]) -> int:
        """Bytes that the pages of columns of a row group unpack to, by their own headers.

        A reader makes room for what these say, whatever the footer says. Raises InputError.
        """
        total = 0
        try:
            with self.open() as file:
                for chunk in self.chunks(k, names):
                    starts = (chunk.dictionary_page_offset, chunk.data_page_offset)
                    file.seek(min(start for start in starts if start))
                    total += unpacked_bytes(file.read(max(chunk.total_compressed_size, 0)))
        except (ParquetError, OSError, ValueError):
            raise self.damage_error() from None
        return total


def column_names(path: str) -> list[str]:
    """What the column of a path may be called: names may have points, and paths join them by one.

    >>> column_names("x.y.list.element")
    ['x', 'x.y', 'x.y.list', 'x.y.list.element']
    """
    return list(accumulate(path.split("."), "{}.{}".format))


def is_text(kind: Any) -> bool:
    """Whether it is the type of texts or bytes."""
    import pyarrow as pa

    types = pa.types
    return bool(
        types.is_string(kind) or types.is_large_string(kind)
        or types.is_binary(kind) or types.is_large_binary(kind)
    )  # fmt: skip


def demand_format(meta: dict[str, Any], newest: int, origin: str) -> int:
    """The number of the format that a file is written in. Raises InputError for one not known."""
    number = meta.get("format")
    if not isinstance(number, int) or isinstance(number, bool) or not 1 <= number <= newest:
        newer = isinstance(number, int) and number > newest
        reason = "it is newer than this version of flockscope reads" if newer else "it is none"
        raise InputError(f"{origin} has format {shorten(number)}: {reason} (1 to {newest})")
    return number
