"""Calls a policy in a process of its own.

A process, and no thread: whatever a policy does, also in a loop of C that never lets go of the
interpreter, its process can be ended, and whoever runs the flock goes on. It reads the policy's
file itself, so it may import what it likes.
"""

from __future__ import annotations

import os
import queue
import signal
import struct
import subprocess
import sys
import threading
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import NoReturn

import numpy as np

from agents.models.rule_file import declaration_in_file
from agents.policies import Policy
from worlds.input_error import InputError, shorten

START = 60.0
"""Seconds in which a policy's file is read, with all that it imports."""
GRACE = 2.0
"""Seconds that a process has to end once its stream is closed."""
REQUEST = struct.Struct("!III")
"""Before what agents see: how many, of how many numbers, and how many numbers an action has."""
READY, ACTIONS, FAULT = b"R", b"A", b"F"
"""What the first byte says of a message of the child."""
LONGEST_FAULT = 500
"""Characters of what went wrong in a policy that are told."""


class PolicyError(InputError):
    """A policy has not answered as it must; the text says how, without who."""


class PolicyProcess:
    """A process that has read a policy's file, and calls it; begun with the first request."""

    def __init__(self, policy: Policy):
        self.policy = policy
        self.lock = threading.Lock()
        """Held while it is asked: flocks on several threads may share a policy."""
        self.process: subprocess.Popen[bytes] | None = None
        self.line: Connection | None = None

    def act(self, seen: np.ndarray, numbers: int) -> np.ndarray:
        """The actions (M, numbers) of agents that see `seen` (M, width). Raises PolicyError; after
        one that is late another process begins."""
        with self.lock:
            if self.process is None or self.process.poll() is not None:
                self.begin()
            assert self.line is not None
            try:
                self.line.send_bytes(REQUEST.pack(*seen.shape, numbers) + seen.tobytes())
                kind, content = self.read(self.policy.timeout)
            except (EOFError, OSError):
                raise PolicyError(f"its process ended with code {self.end(GRACE)}") from None
            if kind == FAULT:
                raise PolicyError(content.decode(errors="replace"))
            return np.frombuffer(content).reshape(len(seen), numbers)

    def begin(self) -> None:
        """Start it and wait until the file is read. Raises PolicyError."""
        self.end()
        self.line, child = Pipe()
        with child:
            code = (
                f"import sys; sys.path[:] = {sys.path!r}; "
                f"from {__name__} import serve; serve({child.fileno()}, {self.policy.file!r})"
            )
            self.process = subprocess.Popen(
                [sys.executable, "-c", code], stdin=subprocess.DEVNULL, pass_fds=[child.fileno()]
            )
        try:
            kind, content = self.read(START)
        except (EOFError, OSError):
            raise PolicyError(f"its process ended with code {self.end(GRACE)}") from None
        if kind == FAULT:
            self.end()
            raise PolicyError(content.decode(errors="replace"))

    def read(self, timeout: float) -> tuple[bytes, bytes]:
        """The next message of the child. Raises PolicyError if it is late, and EOFError."""
        assert self.line is not None
        if not self.line.poll(timeout):
            self.end()
            raise PolicyError(f"no answer within {timeout:g} s")
        message = self.line.recv_bytes()
        return message[:1], message[1:]

    def end(self, grace: float = 0.0) -> int | None:
        """End the process, that has `grace` s to end by itself; its exit code."""
        if self.line is not None:
            self.line.close()
        if self.process is None:
            return None
        with suppress(subprocess.TimeoutExpired):
            self.process.wait(grace)
        self.process.kill()
        code, self.process = self.process.wait(), None
        return code


PROCESSES: dict[str, PolicyProcess] = {}
"""The process of each policy, by its name."""
STARTING = threading.Lock()
"""Held while one is looked up: a policy has one process."""


def process_of(policy: Policy) -> PolicyProcess:
    """The process of a policy; that of another one of its name, as its file was before, ends."""
    with STARTING:
        process = PROCESSES.get(policy.name)
        if process is None or process.policy is not policy:
            if process is not None:
                with process.lock:
                    process.end()
            process = PROCESSES[policy.name] = PolicyProcess(policy)
        return process


# The child.


def serve(line_number: int, path: str) -> NoReturn:
    """Read a policy's file, and answer what it does until the parent is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which ends us
    os.dup2(2, 1)  # whatever a policy prints is no output of the run
    line = Connection(line_number)
    try:
        policy = declaration_in_file(path)
        if not isinstance(policy, Policy):
            raise InputError(f"{path} holds no policy any more")
    except BaseException as error:
        line.send_bytes(FAULT + fault_of(error).encode(errors="replace"))
        os._exit(1)
    line.send_bytes(READY)
    requests: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=watch_parent, args=(line, requests), daemon=True).start()
    while True:
        line.send_bytes(answer(policy, requests.get()))


def watch_parent(line: Connection, requests: queue.SimpleQueue[bytes]) -> None:
    """On a thread of its own: take requests, and end this process when its parent is gone."""
    with suppress(EOFError, OSError):
        while True:
            requests.put(line.recv_bytes())
    os._exit(1)


def answer(policy: Policy, request: bytes) -> bytes:
    """What a policy does about what its agents see, or what is wrong with that."""
    agents, width, numbers = REQUEST.unpack_from(request)
    seen = np.frombuffer(request, np.float32, offset=REQUEST.size).reshape(agents, width).copy()
    try:
        given = policy.act(seen)
    except BaseException as error:
        return FAULT + fault_of(error).encode(errors="replace")
    try:
        actions = np.asarray(given, float)
    except (TypeError, ValueError):
        return FAULT + f"{shorten(given)} is no array of numbers".encode(errors="replace")
    if actions.shape == (agents,) and numbers == 1:
        actions = actions[:, None]
    if actions.shape != (agents, numbers):
        wanted = f"an array of the shape {actions.shape}, and ({agents}, {numbers}) is needed"
        return FAULT + wanted.encode()
    return ACTIONS + actions.tobytes()


def fault_of(error: BaseException) -> str:
    """An error of a policy as one line."""
    text = str(error) if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
    return " ".join(text.split())[:LONGEST_FAULT]
