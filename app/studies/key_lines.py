"""Where a key stands in a TOML file, for messages: `tomllib` gives values without their lines."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field


def find_line(text: str, key: str, table: str = "") -> int | None:
    """The line (from 1) on which `key` of `[table]` is set; None if it cannot be found.

    >>> find_line("model = 'vem'\\n[parameters]\\neta = 9", "eta", "parameters")
    3
    """
    current_table = ""
    inline = None
    for number, line in enumerate(text.splitlines(), 1):
        header = re.match(r"\s*\[\[?\s*([^\]]+?)\s*\]", line)
        if header:
            current_table = header[1]
        elif current_table == table and sets(line, key):
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
    line = find_line(text, key, table)
    return f"{path}, line {line}" if line else str(path)


# Where the keys of a sweep are from: lines of its file, or options of a command line.

DESIGN = re.compile(r"\s*\[\[\s*design\s*\]\]")
OTHER = re.compile(r"\s*\[\[?\s*(?!design\s*\.)")
NAMED = re.compile(
    r"unknown (?:parameter|key|option) '([^']*)'|"
    r"(?:unknown )?([A-Za-z_][\w-]*(?:\.[A-Za-z_][\w-]*)*)"
)
"""What a refusal is about: the first word of it."""


@dataclass(frozen=True)
class KeyLocations:
    """A text and its name; `options` are where keys are from that no file has."""

    origin: str
    text: str = ""
    options: Mapping[str, str] = field(default_factory=dict)

    def describe(self, key: str, table: str = "", design: int | None = None) -> str:
        """File and line of a key of a table, of the design of that number where one is given."""
        if key in self.options:
            return self.options[key]
        first, text = self._block(design) if design is not None else (0, self.text)
        line = find_line(text, key, table)
        return f"{self.origin}, line {first + line}" if line else self.origin

    def _block(self, design: int) -> tuple[int, str]:
        """The lines of a [[design]], and how many stand before them."""
        lines = self.text.splitlines()
        begins = [number for number, line in enumerate(lines) if DESIGN.match(line)]
        if design >= len(begins):
            return 0, self.text
        first = begins[design]
        rest = range(first + 1, len(lines))
        last = next((n for n in rest if OTHER.match(lines[n])), len(lines))
        return first, "\n".join(lines[first:last])


def name_in_refusal(refusal: str) -> str:
    """The word that a refusal is about.

    >>> name_in_refusal("eta = 9 rad is outside [0, 6.28] rad")
    'eta'
    >>> name_in_refusal("unknown parameter 'p9' (known: p1)")
    'p9'
    >>> name_in_refusal("shark.s.spread = -1 is not allowed: a spread is >= 0")
    'shark.s.spread'
    """
    match = NAMED.match(refusal)
    return match[match.lastindex or 0] if match else ""
