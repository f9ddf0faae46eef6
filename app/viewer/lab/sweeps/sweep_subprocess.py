"""The process that makes the runs: the same command as on the command line, apart from the page.

It has a session of its own, so that neither Ctrl-C in the laboratory's terminal nor the end of the
laboratory ends it: `flockscope sweep stop`, the page, or another laboratory does.
"""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from app.viewer.lab.sweeps.sweep_limits import NICE, workers
from worlds.input_error import InputError

MESSAGES = "messages.txt"
"""What the command has to say, beside the runs."""
ENDS = (0, 3)
"""Exit codes of a sweep that came to its end: whole, and with runs that failed."""
OF_LINES = 2_000
"""Bytes of its messages that are looked at."""


@dataclass
class SweepSubprocess:
    """One such process, and the folder that it fills."""

    folder: Path
    process: subprocess.Popen[bytes]

    @classmethod
    def begin(cls, folder: Path, what: Path) -> SweepSubprocess:
        """Begin a sweep, or go on with one: `what` is its file or its folder. Raises InputError."""
        command = [sys.executable, "-P", "-m", "flockscope", "sweep", "run", str(what)]
        command += ["--out", str(folder), "--workers", str(workers()), "--nice", str(NICE)]
        try:
            with open(folder / MESSAGES, "wb") as said:
                process = subprocess.Popen(
                    command,
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=said,
                    start_new_session=True,
                )
        except OSError as error:
            raise InputError(
                f"the sweep {folder.name} cannot be begun: {error.strerror or error}"
            ) from None
        return cls(folder, process)

    @property
    def runs(self) -> bool:
        """Whether it is there."""
        return self.process.poll() is None

    @property
    def has_failed(self) -> bool:
        """Whether it has ended, but not as a sweep does or because it was stopped."""
        code = self.process.poll()
        return code is not None and code > 0 and code not in (*ENDS, 130)

    def stop(self) -> None:
        """Ask it to stop; what is finished is kept."""
        self.process.terminate()

    def said(self) -> str:
        """The last line that it has said."""
        try:
            with open(self.folder / MESSAGES, "rb") as file:
                file.seek(max(0, file.seek(0, 2) - OF_LINES))
                lines = file.read().decode("utf-8", "replace").split("\n")
        except OSError:
            return ""
        last = next((line.strip() for line in reversed(lines) if line.strip()), "")
        return last.removeprefix("flockscope: ")
