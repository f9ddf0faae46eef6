"""Jobs for processes, which tests send them: sums, failures, kills."""

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

from app.studies.runs.database import Outcome


@dataclass(frozen=True)
class Sums:
    """Adds; the payload says what else happens."""

    folder: str = ""

    def prepare(self):
        if self.folder == "nowhere":
            raise RuntimeError("not prepared")

    def run(self, payload, seed):
        if payload == "raise":
            raise ValueError(f"seed {seed}\nis bad")
        if payload == "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        if payload == "kill worker":
            os.kill(os.getppid(), signal.SIGKILL)
            time.sleep(60)
        if payload == "kill once":
            mark = Path(self.folder) / f"killed-{seed}"
            if not mark.exists():
                mark.touch()
                os.kill(os.getpid(), signal.SIGKILL)
        if payload == "halt once":
            mark = Path(self.folder) / f"halted-{seed}"
            if not mark.exists():
                mark.touch()
                os.kill(os.getpid(), signal.SIGSTOP)
        if payload == "halt":
            os.kill(os.getpid(), signal.SIGSTOP)
        if payload == "work":  # the interpreter is kept busy for longer than silence is borne
            until = time.monotonic() + 12.0
            while time.monotonic() < until:
                sum(range(1000))
        if payload == "print":
            print("this is no report")
        if payload == "sleep":
            time.sleep(60)
        return Outcome("ok", {"sum": seed + 1})
