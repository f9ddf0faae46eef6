"""A Parquet file that anybody may have made is read and written anew by a process of its own.

A broken file does not only raise: some end the process that reads them. What comes back was written
by ours.
"""

from __future__ import annotations

import io
import subprocess
import sys

from worlds.refusal import Refusal

PATIENCE = 30.0
"""Seconds that a file may take to be read."""
ROWS = 100_000
"""Rows of a group of what is written: what is decoded together when a tick is looked at."""
SOUND, REFUSED = b"+", b"-"
"""Begin the answer: the file written anew, or what is wrong with it."""


def rewritten(name: str, content: bytes) -> bytes:
    """The file, as a process of ours has written it. Raises Refusal for one that is unsound."""
    # It ends at once: in the usual farewell threads of pyarrow's may end it with another code.
    begin = (
        f"import os, sys; sys.path[:] = {sys.path!r}; from {__name__} import serve; serve(); "
        "sys.stdout.flush(); os._exit(0)"
    )
    try:
        done = subprocess.run(
            [sys.executable, "-c", begin, name],
            input=content,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=PATIENCE,
        )
    except subprocess.TimeoutExpired:
        raise Refusal(f"{name} cannot be read within {PATIENCE:g} s") from None
    kind, rest = done.stdout[:1], done.stdout[1:]
    if done.returncode == 0 and kind == SOUND:
        return rest
    if done.returncode == 0 and kind == REFUSED:
        raise Refusal(rest.decode())
    raise Refusal(f"{name} cannot be read: it is broken")


def serve() -> None:
    """In the process that reads: the file comes by standard input, the answer goes out."""
    import pyarrow.parquet as pq

    from app.viewer.run.past.stored import stored

    name, content = sys.argv[1], sys.stdin.buffer.read()
    try:
        stored(name, content)
        table = pq.read_table(io.BytesIO(content), use_threads=False)
    except Refusal as refusal:
        sys.stdout.buffer.write(REFUSED + str(refusal).encode())
        return
    made = io.BytesIO()
    pq.write_table(table, made, compression="zstd", row_group_size=ROWS)
    sys.stdout.buffer.write(SOUND + made.getvalue())
