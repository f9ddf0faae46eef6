"""A worker for child processes, which does what tests ask for."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path

from worlds.input_error import InputError, InputErrors


class Worker:
    """Does what tests ask for."""

    def __init__(self, text: str = "", folder: Path | None = None):
        if text == "refuse":
            raise InputError("this worker\ncannot begin")
        self.text, self.folder, self.calls = text, folder, 0

    def echo(self, *values):
        self.calls += 1
        return values

    def process(self):
        return os.getpid()

    def count(self):
        return self.calls

    def refuse(self):
        raise InputErrors(["one thing", "another"])

    def crash(self):
        raise KeyError("a name\nof two lines")

    def die(self):
        os._exit(7)

    def leave(self):
        raise SystemExit(5)

    def write(self, name):
        (self.folder / name).touch()

    def wait_for(self, name):
        """Work until a file is there."""
        (self.folder / f"{name} begun").touch()
        while not (self.folder / name).exists():
            time.sleep(0.01)
        return name

    def parts(self, most):
        for number in range(most):
            print("this is no reply")
            yield number

    def burn(self):
        signal.setitimer(signal.ITIMER_PROF, 0.1)
        while True:
            pass

    def take(self, size):
        return len(bytearray(size))

    def unreadable(self):
        return threading.Lock()

    def content(self, data):
        return data[::-1]
