"""The child's end of a child process: what it is asked, it does and answers, and then it ends.

`app.processes` is the other end. Messages have a header and bytes, so that whoever does not trust
the other end reads what it wrote without unpickling it.
"""

from __future__ import annotations

import os
import pickle
import queue
import signal
import socket
import struct
import sys
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from enum import IntEnum
from functools import partial
from types import GeneratorType
from typing import Any, BinaryIO, NoReturn

from worlds.input_error import InputError

HEADER = struct.Struct("!BQ")
"""Before each message: its kind, and its length in bytes."""


@dataclass(frozen=True)
class ProcessLimits:
    """What a child process may take."""

    memory: int | None = None
    """Bytes of address space, where the system can limit it (not on Windows and macOS); no reply is
    longer either."""
    processor_time: int | None = None
    """Seconds of processor time of its whole life: then the system kills it, even if its parent is
    gone and a library in C keeps its interpreter from noticing (not on Windows)."""
    niceness: int = 0
    """Added to that of the parent, where the system knows of it."""
    start: float = 180.0
    """Seconds until it is ready: imports on a busy machine, and what is compiled first."""
    idle: float | None = None
    """Seconds without a request after which it ends by itself, with code 0; None: never."""

    def apply(self) -> None:
        """Have this process keep to them."""
        if self.niceness and hasattr(os, "nice"):
            os.nice(self.niceness)
        try:
            import resource
        except ImportError:  # Windows
            return
        for kind, limit in (
            (resource.RLIMIT_AS, self.memory),
            (resource.RLIMIT_CPU, self.processor_time),
        ):
            if limit is not None:
                _, most = resource.getrlimit(kind)  # only root may raise it
                limit = limit if most == resource.RLIM_INFINITY else min(limit, most)
                with suppress(ValueError):  # macOS has the limit of memory, and lets nobody set it
                    resource.setrlimit(kind, (limit, most))


class MessageKind(IntEnum):
    """What a message says: the first two to a child, the others from it."""

    REQUEST = 0
    END = 1
    READY = 2
    PART = 3
    """One value of a method that yields several."""
    VALUE = 4
    REFUSAL = 5
    """An InputError."""
    FAULT = 6
    """Any other error, as one line."""


def write_message(stream: BinaryIO, kind: int, data: bytes = b"") -> None:
    """Write a message whole."""
    stream.write(HEADER.pack(kind, len(data)))
    stream.write(data)
    stream.flush()


def read_message(stream: BinaryIO, most: int | None = None) -> tuple[int, bytes]:
    """The next message: kind and data. Raises EOFError if there is none; ValueError if it has more
    than `most` bytes."""
    head = stream.read(HEADER.size)
    if len(head) < HEADER.size:
        raise EOFError
    kind, size = HEADER.unpack(head)
    if most is not None and size > most:
        raise ValueError(f"a message of {size} bytes")
    data = stream.read(size)
    if len(data) < size:
        raise EOFError
    return kind, data


def one_line(error: BaseException) -> str:
    """An error as one line: its kind and its text.

    >>> one_line(ValueError("a\\nb"))
    'ValueError: a b'
    """
    return " ".join(f"{type(error).__name__}: {error}".split())


def serve_pipes() -> None:
    """The child, with its standard streams."""
    replies = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever a rule, a measure or a library prints is no reply
    serve(sys.stdin.buffer, replies)


def serve_socket(line: socket.socket) -> None:
    """The child, with a socket."""
    serve(line.makefile("rb"), line.makefile("wb"))


def serve(requests: BinaryIO, replies: BinaryIO) -> None:
    """Make the worker, and have it do what is asked, in order, until the parent ends that."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which ends us
    try:
        limits, is_trusted, setup, first = pickle.loads(read_message(requests)[1])
        inbox: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        threading.Thread(target=watch_parent, args=(requests, inbox), daemon=True).start()
        limits.apply()
        worker, arguments = pickle.loads(setup)
        worker = worker(*arguments)
    except BaseException as error:
        write_message(replies, MessageKind.FAULT, one_line(error).encode(errors="replace"))
        exit_process(1)
    if first:
        with suppress(Exception):
            getattr(worker, first[0])(*first[1:])
    try:
        write_message(replies, MessageKind.READY)
        while (content := inbox.get(timeout=limits.idle)) is not None:
            for message in carry_out(worker, content, is_trusted):
                write_message(replies, *message)
    except queue.Empty:
        exit_process(0)
    except BaseException:  # SystemExit too: in the usual farewell our thread would be in the way
        traceback.print_exc()
        exit_process(1)
    exit_process(0)


def watch_parent(requests: BinaryIO, inbox: queue.SimpleQueue[bytes | None]) -> None:
    """On a thread of its own: take requests, and end this process when its parent is gone."""
    with suppress(EOFError, OSError):
        while True:
            kind, content = read_message(requests)
            inbox.put(None if kind == MessageKind.END else content)
    os._exit(1)


def carry_out(worker: Any, content: bytes, is_trusted: bool) -> Iterator[tuple[MessageKind, bytes]]:
    """Call a method; the messages that it is answered with."""
    encode: Callable[[Any], bytes] = partial(pickle.dumps, protocol=-1) if is_trusted else bytes
    try:
        name, arguments = pickle.loads(content)
        value = getattr(worker, name)(*arguments)
        if isinstance(value, GeneratorType):
            for part in value:
                yield MessageKind.PART, encode(part)
            value = None if is_trusted else b""
        yield MessageKind.VALUE, encode(value)
    except InputError as refusal:
        text = str(refusal).encode(errors="replace")
        yield MessageKind.REFUSAL, pickle.dumps(refusal, -1) if is_trusted else text
    except Exception as error:
        yield MessageKind.FAULT, one_line(error).encode(errors="replace")


def exit_process(code: int) -> NoReturn:
    """End at once: threads of libraries may end the usual farewell with another code."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(Exception):
            stream.flush()
    os._exit(code)
