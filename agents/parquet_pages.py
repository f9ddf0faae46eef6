"""What the pages of a Parquet file unpack to, by their own headers, before any is unpacked.

A footer says it too, but a reader makes room for what the header of each page says:
https://github.com/apache/parquet-format.
"""

from __future__ import annotations

from agents.parquet_thrift import I32, ParquetError, StructSchema, read_struct

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
        packed, unpacked = header.get(PACKED, -1), header.get(UNPACKED, -1)
        pages += 1
        if packed < 0 or unpacked < 0 or pages > MOST_PAGES:
            raise ParquetError
        total += unpacked
        at = begins + packed
    return total
