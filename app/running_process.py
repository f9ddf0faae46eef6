"""One process of the system, started in either way, and the two streams that lead to it."""

from __future__ import annotations

import multiprocessing
import multiprocessing.connection
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

from app import process_worker

GRACE = 2.0
"""Seconds that a process has to finish what it is at once it is to end, before it is killed."""


class RunningProcess:
    """One process of the system, and the two streams that lead to it. Raises OSError if the system
    has none for us."""

    forking = threading.Lock()
    """multiprocessing asks after all its children as it starts another, and which of two threads
    learns a child's exit code is chance: the other is told 255."""

    def __init__(
        self, preload: Sequence[str], environment: Mapping[str, str], stderr: int | None
    ) -> None:
        self.process: Any
        self.requests: Any
        self.replies: Any
        if preload:
            self.fork(preload)
        else:
            self.spawn(environment, stderr)
        self.is_ready = False
        self.turned = time.monotonic()
        """When it turned to what it is at: its start, or what followed its last reply."""
        self.reason = ""
        """Why it cannot begin, in one line."""

    def fork(self, preload: Sequence[str]) -> None:
        """Start a copy of a process that has imported these modules once: it takes no seconds, and
        shares their memory. Windows has no fork: there it is as slow as any."""
        method = "forkserver"
        if method not in multiprocessing.get_all_start_methods():
            method = "spawn"
        context: Any = multiprocessing.get_context(method)
        if method == "forkserver":
            context.set_forkserver_preload([process_worker.__name__, *preload])
        parent_end, child_end = socket.socketpair()
        with parent_end, child_end:  # the streams go on when the socket is closed
            self.process = context.Process(
                target=process_worker.serve_socket, args=(child_end,), daemon=True
            )
            with self.forking:
                self.process.start()
            self.requests, self.replies = parent_end.makefile("wb"), parent_end.makefile("rb")

    def spawn(self, environment: Mapping[str, str], stderr: int | None) -> None:
        """Start an interpreter.

        Not by multiprocessing, which would import the user's own script in each child, and run it
        there unless it is guarded by `if __name__ == "__main__"`. It stays in its parent's group,
        so that Ctrl-Z halts both, and ignores Ctrl-C before it imports anything.
        """
        code = (
            "import signal, sys; signal.signal(signal.SIGINT, signal.SIG_IGN); "
            f"sys.path[:] = {sys.path!r}; "
            f"from {process_worker.__name__} import serve_pipes; serve_pipes()"
        )
        self.process = subprocess.Popen(
            [sys.executable, "-c", code],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=stderr,
            env={**os.environ, **environment},
        )
        self.requests, self.replies = self.process.stdin, self.process.stdout

    def wait(self) -> int:
        """Its exit code, minus the signal if one ended it; for one thread only.

        It is killed if it lives though its stream is closed: nobody hears of it any more.
        """
        if isinstance(self.process, subprocess.Popen):
            with suppress(subprocess.TimeoutExpired):
                return self.process.wait(GRACE)
            self.process.kill()
            return self.process.wait()
        if not multiprocessing.connection.wait([self.process.sentinel], GRACE):
            self.process.kill()
            multiprocessing.connection.wait([self.process.sentinel])
        with self.forking:
            self.process.join()
        return self.process.exitcode

    def close(self) -> None:
        """Close the streams."""
        for stream in (self.requests, self.replies):
            with suppress(OSError):
                stream.close()
