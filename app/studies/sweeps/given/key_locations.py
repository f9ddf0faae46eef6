"""Where the keys of a sweep are from: lines of its file, or options of a command line."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from app.studies.key_lines import line_of

DESIGN = re.compile(r"\s*\[\[\s*design\s*\]\]")
OTHER = re.compile(r"\s*\[\[?\s*(?!design\s*\.)")
NAMED = re.compile(r"unknown (?:parameter|key|option) '([^']*)'|(?:unknown )?([A-Za-z_][\w-]*)")
"""What a refusal is about: the first word of it."""


@dataclass(frozen=True)
class KeyLocations:
    """A text and its name; `options` are where keys are from that no file has."""

    origin: str
    text: str = ""
    options: Mapping[str, str] = field(default_factory=dict)

    def of(self, key: str, table: str = "", design: int | None = None) -> str:
        """File and line of a key of a table, of the design of that number where one is given."""
        if key in self.options:
            return self.options[key]
        first, text = self._block(design) if design is not None else (0, self.text)
        line = line_of(text, key, table)
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


def about(refusal: str) -> str:
    """The word that a refusal is about.

    >>> about("eta = 9 rad is outside [0, 6.28] rad"), about("unknown parameter 'p9' (known: p1)")
    ('eta', 'p9')
    """
    found = NAMED.match(refusal)
    return found[found.lastindex or 0] if found else ""
