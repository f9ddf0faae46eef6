"""A second Ctrl-C ends what the first has begun to close, with one line."""

from __future__ import annotations

import subprocess
import sys

CLOSING = """
import os, signal, threading
from app.cli.terminal.progress import StopSignals

def interrupt():
    os.kill(os.getpid(), signal.SIGINT)
    threading.Event().wait(60)

with StopSignals(at_once="stopped; go on with: again"):
    try:
        interrupt()
    finally:
        interrupt()
"""


def test_a_second_interrupt_while_the_first_closes_is_one_line():
    done = subprocess.run(
        [sys.executable, "-c", CLOSING], capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "stopped; go on with: again\n"
