"""Where a key stands in a TOML file, for messages: `tomllib` gives values without their lines."""

from __future__ import annotations

import re


def line_of(text: str, key: str, table: str = "") -> int | None:
    """The line (from 1) on which `key` of `[table]` is set; None if it cannot be found.

    >>> line_of("model = 'vem'\\n[parameters]\\neta = 9", "eta", "parameters")
    3
    """
    here = ""
    inline = None
    for number, line in enumerate(text.splitlines(), 1):
        header = re.match(r"\s*\[\[?\s*([^\]]+?)\s*\]", line)
        if header:
            here = header[1]
        elif here == table and sets(line, key):
            return number
        elif inline is None and table and sets_inline(line, key):
            inline = number
    return inline


def sets(line: str, key: str) -> bool:
    """Whether a line sets the key."""
    return re.match(rf"\s*[\"']?{re.escape(key)}[\"']?\s*=", line) is not None


def sets_inline(line: str, key: str) -> bool:
    """Whether a line sets the key within braces."""
    return re.search(rf"[{{,]\s*[\"']?{re.escape(key)}[\"']?\s*=", line) is not None


def place(path: object, text: str, key: str, table: str = "") -> str:
    """File and line of a key, as messages name them: `experiments/fig5.toml, line 12`."""
    line = line_of(text, key, table)
    return f"{path}, line {line}" if line else str(path)
