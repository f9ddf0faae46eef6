"""A table on its way to the disk: an Arrow stream that a kill leaves readable, then Parquet."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from agents.part_stream import PartStream
from agents.record import KEY
from worlds.plug_ins import demand_parquet

LONGEST = 2**20
"""Bytes of a text in a table: events keep what was asked, whatever a browser sent."""
GROUP = 100_000
"""Rows of a row group of the Parquet file; the stream has some hundreds in a batch."""


class RecordingStream:
    """Rows of one table, with metadata, in a `.part` beside where its Parquet file will be.

    `columns` are names and Arrow types. Raises OSError if it cannot be written, or InputError.
    """

    def __init__(self, path: Path, columns: Mapping[str, str], meta: Mapping[str, Any]):
        demand_parquet("a recording of the laboratory")
        import pyarrow as pa

        self.path = path
        self.part = path.with_name(path.name + ".part")
        fields = [pa.field(name, arrow_type(kind)) for name, kind in columns.items()]
        self.schema = pa.schema(fields, {KEY: json.dumps(meta).encode()})
        self.file = self.part.open("wb")
        self.stream = pa.ipc.new_stream(self.file, self.schema)
        # the schema comes before the first batch, and a table without rows is to be readable too
        self.put([() for _ in fields])

    def write(self, rows: list[tuple]) -> None:
        """Append rows. Raises OSError."""
        if rows:
            self.put(list(zip(*rows, strict=True)))

    def put(self, columns: list[tuple]) -> None:
        """Append a batch of columns, and bring it to the disk. Raises OSError."""
        import pyarrow as pa

        arrays = [
            pa.array(column, field.type, from_pandas=False)
            for column, field in zip(columns, self.schema, strict=True)
        ]
        self.stream.write_batch(pa.RecordBatch.from_arrays(arrays, schema=self.schema))
        self.file.flush()

    @property
    def size(self) -> int:
        """Bytes written."""
        return self.file.tell()

    def close(self) -> None:
        """End the stream. Raises OSError."""
        self.stream.close()
        self.file.close()


def arrow_type(kind: str) -> Any:
    """An Arrow type by its name."""
    import pyarrow as pa

    return pa.bool_() if kind == "bool" else getattr(pa, kind)()


def finish(part: Path, path: Path) -> int:
    """Make the Parquet file `path` of all whole batches of a `.part`, which is removed; its rows.

    Raises OSError, or InputError if it is no stream of ours.
    """
    import pyarrow.parquet as pq

    made = path.with_name(path.name + ".tmp")
    rows = 0
    try:
        with open(part, "rb") as source:
            stream = PartStream(part, source, LONGEST)
            with pq.ParquetWriter(made, stream.schema, compression="zstd") as writer:
                for batch in stream.batches(GROUP):
                    writer.write_batch(batch)
                    rows += batch.num_rows
        os.replace(made, path)
    finally:
        made.unlink(missing_ok=True)
    part.unlink()
    return rows
