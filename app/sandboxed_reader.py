"""Files that anybody may have made are read by a process of their own, with limits.

A hostile file does not only raise: some end the process that reads them, some take seconds of an
interpreter on which a page waits, some take all memory. What comes back is JSON, or a file that was
written by ours.
"""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from importlib import import_module
from typing import Any

from app.process_worker import ProcessLimits
from app.processes import ChildError, ChildProcess, ProcessLostError, ProcessTimeoutError
from worlds.input_error import InputError
from worlds.text_file import toml

TIMEOUT = 30.0
"""Seconds that a file may take to be read."""
MEMORY = 4 << 30
"""Bytes of address space that a reader may have, where the system can limit it."""
PROCESSOR_TIME = 120
"""Seconds of processor time, of many threads perhaps, after which the system ends a reader: one
that hangs in a library in C does not notice that its parent is gone."""


def read_in_sandbox(reader: str, name: str, content: bytes) -> bytes:
    """What a reader makes of a file from a browser, in a process of its own.

    `reader`: a function of ours as "module:function", of (name, content), which returns bytes and
    raises InputError. Raises InputError, also where the process dies or takes longer than
    `TIMEOUT`.
    """
    limits = ProcessLimits(memory=MEMORY, processor_time=PROCESSOR_TIME)
    # Not trusted: a file that takes the reader over could have pickle run anything here.
    with ChildProcess(
        SandboxedReader, reader, limits=limits, is_trusted=False, stderr=subprocess.DEVNULL
    ) as child:
        try:
            read: bytes = child.ask("read", name, content, timeout=TIMEOUT).result()
        except ProcessTimeoutError:
            raise InputError(f"{name} cannot be read within {TIMEOUT:g} s") from None
        except (ChildError, ProcessLostError):
            raise InputError(
                f"{name} cannot be read: it is broken, or takes too much memory"
            ) from None
    return read


class SandboxedReader:
    """In the process that reads: a function of ours, "module:function".

    It is imported before any file is there: seconds on a busy machine, which no file is charged.
    """

    def __init__(self, reader: str):
        module, function = reader.split(":")
        self.function: Callable[[str, bytes], bytes] = getattr(import_module(module), function)

    def read(self, name: str, content: bytes) -> bytes:
        """What the function makes of a file. Raises InputError."""
        return self.function(name, content)


def read_toml(name: str, content: bytes) -> dict[str, Any]:
    """The tables of a TOML file from a browser. Raises InputError."""
    values: dict[str, Any] = json.loads(read_in_sandbox(f"{__name__}:toml_as_json", name, content))
    return values


def toml_as_json(name: str, content: bytes) -> bytes:
    """The tables of a TOML file as JSON; times, which nothing of ours has, become text."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{name} is not a text file") from None
    return json.dumps(toml(text, name), default=str).encode()
