"""Files that anybody may have made are read by a process of their own, with limits.

A hostile file does not only raise: some end the process that reads them, some take seconds of an
interpreter on which a page waits, some take all memory. What comes back is JSON, or a file that was
written by ours.
"""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import import_module
from typing import Any

from worlds.input_error import InputError
from worlds.text_file import toml

TIMEOUT = 30.0
"""Seconds that a file may take to be read, those of the process's start included."""
MEMORY = 4 << 30
"""Bytes of address space that a reader may have, where the system can limit it."""
FINE, REFUSED = b"+", b"-"
"""Begin the reply: what was read, or why it cannot be read."""


def read_in_sandbox(reader: str, name: str, content: bytes) -> bytes:
    """What a reader makes of a file from a browser, in a process of its own.

    `reader`: a function of ours as "module:function", of (name, content), which returns bytes and
    raises InputError. Raises InputError, also where the process dies or takes longer than
    `TIMEOUT`.
    """
    # It ends at once: in the usual farewell threads of pyarrow's may end it with another code.
    begin = (
        f"import os, sys; sys.path[:] = {sys.path!r}; from {__name__} import serve; serve(); "
        "sys.stdout.flush(); os._exit(0)"
    )
    try:
        done = subprocess.run(
            [sys.executable, "-c", begin, reader, name],
            input=content,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=TIMEOUT,
        )
    except subprocess.TimeoutExpired:
        raise InputError(f"{name} cannot be read within {TIMEOUT:g} s") from None
    kind, rest = done.stdout[:1], done.stdout[1:]
    if done.returncode == 0 and kind == FINE:
        return rest
    if done.returncode == 0 and kind == REFUSED:
        raise InputError(rest.decode())
    raise InputError(f"{name} cannot be read: it is broken, or takes too much memory")


def serve() -> None:
    """In the process that reads: the file comes by standard input, the reply goes out."""
    limit_memory()
    place, name = sys.argv[1:3]
    module, function = place.split(":")
    content = sys.stdin.buffer.read()
    try:
        reply = FINE + getattr(import_module(module), function)(name, content)
    except InputError as refusal:
        reply = REFUSED + str(refusal).encode()
    sys.stdout.buffer.write(reply)


def limit_memory() -> None:
    """Take no more address space than `MEMORY`, where the system knows such limits."""
    try:
        import resource
    except ImportError:  # Windows
        return
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    limit = MEMORY if most == resource.RLIM_INFINITY else min(MEMORY, most)
    resource.setrlimit(resource.RLIMIT_AS, (limit, most))


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
