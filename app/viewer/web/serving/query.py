"""What the address of a page may not ask for."""

from __future__ import annotations

import re
from urllib.parse import parse_qsl

FORBIDDEN = ("websocket", "playbackpath")
"""Parameters by which viser's client would take its messages from elsewhere, in small letters."""
OTHER = re.compile(r"[^a-z]")
MOST = 100
"""Parameters of an address."""


def leads_elsewhere(query: str) -> str:
    """The parameter of a query that names another source of messages; empty if none does.

    >>> leads_elsewhere("a=1&%57ebSocket=ws://example.org")
    'websocket'
    >>> leads_elsewhere("token=1")
    ''
    """
    try:
        named = parse_qsl(query, keep_blank_values=True, max_num_fields=MOST)
    except ValueError:
        return f"more than {MOST} parameters"
    for name, _ in named:
        letters = OTHER.sub("", name.casefold())
        for word in FORBIDDEN:
            if word in letters:
                return word
    return ""
