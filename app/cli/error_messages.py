"""What cannot be done is told in a line on stderr, with exit code 2 and no traceback."""

from __future__ import annotations

import errno
import re
from bdb import BdbQuit
from collections.abc import Callable
from contextlib import suppress
from functools import wraps
from typing import Any, NoReturn

import typer

from worlds.input_error import InputError, InputErrors

REFUSED = 2
LONGEST = 1500
"""Characters of a refusal."""
MOST_LINES = 40
"""Most lines that are told of several refusals at once."""
INTERRUPTED = 130


def told(command: Callable[..., Any]) -> Callable[..., Any]:
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
            refuse(f"there is not enough memory: {str(error) or 'use fewer agents'}")
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
    return "".join(one if one.isprintable() else ascii(one)[1:-1] for one in text)


def one_line(text: str) -> str:
    """A text in one line that a terminal can show, the middle left out of what is very long.

    >>> one_line("eta\\n  = \\x1b[31m9")
    'eta = \\\\x1b[31m9'
    """
    line = visible(" ".join(text.split()))
    line = re.sub(r"(\S{60})\S{80,}(\S{60})", r"\1...\2", line)
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 300]} ... {line[-295:]}"
