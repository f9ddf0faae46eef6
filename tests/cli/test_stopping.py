"""Ctrl-C ends what makes runs, wherever it comes, and a second one what the first has closed."""

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

SWALLOWED = """
import os, signal, weakref
from pathlib import Path
from app.cli.terminal.progress import runs_progress

class Holder: pass

with runs_progress("calm", Path("calm"), True) as progress:
    holder = Holder()
    weakref.finalize(holder, lambda: os.kill(os.getpid(), signal.SIGTERM))
    del holder
    print("goes on")
    progress.update(0.5)
    print("never")
"""


def test_a_signal_that_a_finalizer_swallows_stops_at_the_next_beat():
    done = subprocess.run(
        [sys.executable, "-c", SWALLOWED], capture_output=True, text=True, timeout=60
    )
    assert "Exception ignored in" in done.stderr, "Python has dropped the interrupt"
    assert done.stdout == "goes on\n"
    assert "flockscope: stopped; finished runs are in calm; go on with:" in done.stderr


def test_a_second_interrupt_while_the_first_closes_is_one_line():
    done = subprocess.run(
        [sys.executable, "-c", CLOSING], capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "stopped; go on with: again\n"
