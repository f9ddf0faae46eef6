"""Jobs for processes, which tests send them: sums, failures, kills."""

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

from app.experiments.runs.outcome import Outcome


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
        if payload == "print":
            print("this is no report")
        if payload == "sleep":
            time.sleep(60)
        return Outcome("ok", {"sum": seed + 1})
