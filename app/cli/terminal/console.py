"""What may stand in a file is printed here, so that no text of it commands the terminal.

The streams of the command line and its one console of rich show control characters as escapes. So
a new command is safe as long as it prints, echoes, warns, logs or takes `make_console`.
"""

from __future__ import annotations

import errno
import re
import sys
from bdb import BdbQuit
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import wraps
from typing import Any, NoReturn, TextIO

import typer

from worlds.input_error import CONTROLS, InputError, InputErrors

ESCAPED = re.compile(f"[{CONTROLS}]|\r(?!\n)")  # newlines, tabs and the line ends of CSV stay


def escape_controls(text: str) -> str:
    """A text whose control characters are shown as escapes; newlines and tabs stay.

    >>> print(escape_controls("a" + chr(27) + "[2J"))
    a\\x1b[2J
    """
    return ESCAPED.sub(lambda match: ascii(match[0])[1:-1], text)


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


# What cannot be done is told in a line on stderr, with exit code 2 and no traceback.

REFUSED = 2
LONGEST = 1500
"""Characters of a refusal."""
MOST_LINES = 40
"""Most lines that are told of several refusals at once."""
INTERRUPTED = 130


def with_one_line_errors(command: Callable[..., Any]) -> Callable[..., Any]:
    """The command, with its refusals turned into one line."""

    @wraps(command)
    def guarded(*args: Any, **kwargs: Any) -> Any:
        try:
            return command(*args, **kwargs)
        except InputError as refusal:
            refuse(refusal)
        except ArithmeticError as error:
            from agents.engine.runner import NotANumber

            if not isinstance(error, NotANumber):
                raise
            refuse(error)
        except OSError as error:
            if error.errno == errno.EPIPE:  # the reader of stdout has gone
                raise
            named = "" if error.filename is None else f"{str(error.filename)!r}: "
            refuse(f"{named}{error.strerror or error}")
        except MemoryError as error:
            if "allocate" not in str(error):  # NumPy says how much; else the limit is what helps
                raise
            refuse(f"there is not enough memory: {error}")
        except (KeyboardInterrupt, BdbQuit):  # BdbQuit: pdb was left
            raise typer.Exit(INTERRUPTED) from None

    return guarded


def refuse(reason: object) -> NoReturn:
    """Tell the reason and stop; where nothing can be told, the exit code still says so."""
    lines = reason.lines if isinstance(reason, InputErrors) else (str(reason),)
    with suppress(OSError):  # stderr may be closed, or on a disk that is full
        for line in lines[:MOST_LINES]:
            typer.echo(f"flockscope: {one_line(line)}", err=True)
        if len(lines) > MOST_LINES:
            typer.echo(f"flockscope: and {len(lines) - MOST_LINES} more of the kind", err=True)
    raise typer.Exit(REFUSED) from None


def visible(text: str) -> str:
    """A text of a file or a stranger for a terminal, which would obey what it cannot show.

    >>> print(visible("a" + chr(27) + "[2J"))
    a\\x1b[2J
    """
    return "".join(
        character if character.isprintable() else ascii(character)[1:-1] for character in text
    )


def one_line(text: str) -> str:
    """A text in one line that a terminal can show, the middle left out of what is very long.

    >>> one_line("eta\\n  = \\x1b[31m9")
    'eta = \\\\x1b[31m9'
    """
    line = visible(" ".join(text.split()))
    line = re.sub(r"(\S{60})\S{80,}(\S{60})", r"\1...\2", line)
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 300]} ... {line[-295:]}"
