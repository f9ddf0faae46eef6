"""What may stand in a file is printed here, so that no text of it commands the terminal.

The streams of the command line and its one console of rich show control characters as escapes. So
a new command is safe as long as it prints, echoes, warns, logs or takes `make_console`.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from typing import Any, TextIO

from worlds.input_error import CONTROLS

ESCAPED = re.compile(f"[{CONTROLS}]|\r(?!\n)")  # newlines, tabs and the line ends of CSV stay


def escape_controls(text: str) -> str:
    """A text whose control characters are shown as escapes; newlines and tabs stay.

    >>> print(escape_controls("a" + chr(27) + "[2J"))
    a\\x1b[2J
    """
    return ESCAPED.sub(lambda found: ascii(found[0])[1:-1], text)


class EscapingStream:
    """A text stream that escapes control characters.

    It has no `buffer`, as typer would write past it on Windows and where the encoding is ASCII.
    """

    def __init__(self, stream: TextIO):
        self.rich_proxied_file = stream  # rich takes this one for its colours and cursor
        """The stream itself, under the name that rich looks for."""

    def __getattr__(self, name: str) -> Any:
        if name in ("buffer", "rich_proxied_file"):
            raise AttributeError(name)
        return getattr(self.rich_proxied_file, name)

    def write(self, text: str) -> int:
        """Write a text; returns its length."""
        self.rich_proxied_file.write(escape_controls(text))
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """Write texts."""
        for line in lines:
            self.write(line)


def guard_streams() -> None:
    """Let this process's stdout and stderr escape control characters."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is not None and not isinstance(stream, EscapingStream):
            setattr(sys, name, EscapingStream(stream))


def rewrite_line(text: str) -> None:
    """Write a text over the line of stderr that the cursor is in, and leave the cursor there."""
    stream = getattr(sys.stderr, "rich_proxied_file", sys.stderr)
    stream.write("\r" + escape_controls(text))
    stream.flush()


def make_console(**options: Any) -> Any:
    """A Console of rich, with its options, that escapes the control characters of texts."""
    from rich.console import Console
    from rich.segment import Segment

    class EscapingConsole(Console):
        """It escapes where every text passes, that of tables and of bars.

        Texts are escaped before rich measures them, so that it cuts what is shown.
        """

        def render_str(self, text: str, **more: Any) -> Any:
            return super().render_str(escape_controls(text), **more)

        def render(self, *args: Any, **more: Any) -> Iterable[Segment]:
            for part in super().render(*args, **more):
                yield part if part.control else Segment(escape_controls(part.text), part.style)

    return EscapingConsole(**options)
